//! Points of a plane or of space, tied together by elements that depend on the differences of their coordinates alone.

use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar, Scene, Sum,
};
use nalgebra::SVector;

/// ½ m |v|², of points of D coordinates.
struct Mass;

impl<const D: usize> KineticEnergy<D, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, D>, v: &SVector<S, D>, b: &SVector<S, 1>) -> S {
        v.dot(v) * b[0] * 0.5
    }
}

/// Ties two points, whose N coordinates are those of one, then those of the other.
struct Tie;

/// How the one moves as the other sees it.
fn between<S: Scalar, const N: usize>(x: &SVector<S, N>) -> impl Iterator<Item = S> {
    let half = N / 2;
    (0..half).map(move |i| x[half + i] - x[i])
}

fn squares<S: Scalar>(x: impl Iterator<Item = S>) -> S {
    x.fold(S::from(0.0), |sum, x| sum + x * x)
}

/// ½ b (ḋ)² (1 + d²): what resists accelerations of one point relative to the other.
impl<const N: usize> KineticEnergy<N, 1> for Tie {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, N>, v: &SVector<S, N>, b: &SVector<S, 1>) -> S {
        squares(between(v)) * (squares(between(q)) + 1.0) * b[0] * 0.5
    }
}

/// ½ c (|d| − l₀)² with b = [c, l₀].
impl<const N: usize> PotentialEnergy<N, 2> for Tie {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, 2>, _t: S) -> S {
        let strain = squares(between(q)).sqrt() - b[1];
        strain * strain * b[0] * 0.5
    }
}

/// A damper b |d|² ḋ that a control pulls together.
impl<const N: usize> Force<N, 1, 1> for Tie {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, N, 1>, b: &SVector<S, 1>) -> SVector<S, N> {
        let square = squares(between(&at.q));
        let pull: Vec<S> = between(&at.v).zip(between(&at.q)).map(|(v, d)| square * v * b[0] + at.u[0] * d).collect();
        SVector::from_fn(|i, _| if i < N / 2 { pull[i] } else { -pull[i - N / 2] })
    }
}

/// |d|² = l².
impl<const N: usize> Constraint<N, 1, 1> for Tie {
    fn phi<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([squares(between(q)) - b[0] * b[0]])
    }
}

/// ½ |q − 1|².
struct Away;

impl<const D: usize> Cost<D> for Away {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, D, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q.iter().fold(S::from(0.0), |sum, x| sum + (*x - 1.0) * (*x - 1.0) * 0.5)
    }
}

/// How the points are tied.
#[derive(Clone, Copy, Debug)]
pub enum Net {
    /// Each to the next.
    Chain,
    /// Each to the next, every third one to the first as well, and half of all the other way round.
    Tangled,
}

/// So many points of D coordinates with all ties, N = 2 D.
pub fn points<const D: usize, const N: usize>(count: usize, net: Net) -> Scene {
    let mut scene = Scene::new();
    let (stiffness, length, u) = (scene.design("stiffness", 30.0), scene.design("length", 0.3), scene.control("u"));
    let place = |k: usize, i: usize| (1.3 * k as f64 + 2.1 * i as f64).sin() + if i == 0 { 0.4 * k as f64 } else { 0.0 };
    let q: Vec<[Coordinate; D]> = (0..count)
        .map(|k| {
            let q = scene.coordinates(&format!("point {k}"), std::array::from_fn(|i| ["x", "y", "z"][i]));
            q.into_iter().enumerate().for_each(|(i, q)| scene.place(q, place(k, i)));
            scene.kinetic_energy(&format!("mass {k}"), Mass, q, [(0.5 + 0.1 * k as f64).into()]);
            q
        })
        .collect();
    let mut ties: Vec<[usize; 2]> = (1..count).map(|k| [k - 1, k]).collect();
    if matches!(net, Net::Tangled) {
        ties.extend((3..count).step_by(3).map(|k| [0, k]));
        ties.iter_mut().step_by(2).for_each(|tie| tie.reverse());
    }
    for (k, [a, b]) in ties.into_iter().enumerate() {
        let ends: [Coordinate; N] = std::array::from_fn(|i| if i < D { q[a][i] } else { q[b][i - D] });
        let distance = (0..D).map(|i| (place(a, i) - place(b, i)).powi(2)).sum::<f64>().sqrt();
        scene.kinetic_energy(&format!("inerter {k}"), Tie, ends, [0.05.into()]);
        scene.potential_energy(&format!("cable {k}"), Tie, ends, [stiffness.into(), length.into()]);
        scene.force(&format!("damper {k}"), Tie, ends, [u], [0.2.into()]);
        if k % 4 == 1 {
            scene.constraint(&format!("rod {k}"), Tie, ends, [distance.into()]);
        }
    }
    scene.cost("away", Away, Sum::Integral, q[count - 1], [], [], []);
    scene
}

/// Few and many of them, side by side or not.
pub fn all() -> Vec<(String, Scene)> {
    let mut all = Vec::new();
    for (count, net) in [2, 3, 6, 10, 20].into_iter().flat_map(|count| [(count, Net::Chain), (count, Net::Tangled)]) {
        all.push((format!("{net:?} of {count} points of a plane"), points::<2, 4>(count, net)));
        all.push((format!("{net:?} of {count} points of space"), points::<3, 6>(count, net)));
    }
    all
}
