//! Formulas that are linear in pieces: their second derivatives vanish, and yet they are neither linear nor constant.

use hamiltonian_adjoint::{Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar, Scene, Sum};
use nalgebra::SVector;

/// Which formula.
#[derive(Clone, Copy, Debug)]
pub enum Piece {
    /// V = b |x − y|
    Distance,
    /// V = b max(x, y)
    Larger,
    /// V = min(3 x, 2 y + b, 2 − x)
    Least,
    /// V = b |x| + y⁴: bent in y alone.
    Beside,
    /// V = |x| sin(t + b)
    Timed,
    /// T = ½ (ẋ² + ẏ²) − b |x|
    OfPlace,
    /// Q = b max(x, y) u and b |u|
    Forces,
    /// J of Σ |x_i| + b max(ẋ_i, −x_i)
    Cost,
    /// V and J with roots of what is cut off at zero, whose slopes are infinite there
    Root,
}

impl Piece {
    pub const ALL: [Piece; 9] = {
        use Piece::*;
        [Distance, Larger, Least, Beside, Timed, OfPlace, Forces, Cost, Root]
    };
}

impl PotentialEnergy<2, 1> for Piece {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, t: S) -> S {
        let ([x, y], b) = ([q[0], q[1]], b[0]);
        match self {
            Piece::Distance => b * (x - y).abs(),
            Piece::Larger => b * x.max(y),
            Piece::Least => (x * 3.0).min(y * 2.0 + b).min(-x + 2.0),
            Piece::Beside => b * x.abs() + y.powi(4),
            Piece::Timed => x.abs() * (t + b).sin(),
            Piece::Root => (x + y * 0.1).max(S::zero()).sqrt() * b - (-x).min(S::zero()).abs().powf(1.5) + x * x * y,
            _ => b * 0.0,
        }
    }
}

impl KineticEnergy<2, 1> for Piece {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        let energy = v.dot(v) * 0.5;
        if matches!(self, Piece::OfPlace) { energy - b[0] * q[0].abs() } else { energy }
    }
}

impl Force<2, 1, 1> for Piece {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 1>) -> SVector<S, 2> {
        match self {
            Piece::Forces => SVector::from([at.q[0].max(at.q[1]) * at.u[0] * b[0], at.u[0].abs() * b[0]]),
            _ => SVector::from([at.u[0], at.u[0] * 0.0]),
        }
    }
}

impl Cost<3, 0, 0, 1> for Piece {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, b: &SVector<S, 1>) -> S {
        match self {
            Piece::Cost => (0..3).map(|i| at.q[i].abs() + at.v[i].max(-at.q[i])).sum::<S>() * b[0],
            Piece::Root => (0..3).map(|i| (at.q[i] - 1.0).max(S::zero()).sqrt() * b[0] + at.q[i] * at.q[i]).sum::<S>(),
            _ => at.q.dot(&at.q) * b[0],
        }
    }
}

/// A scene of such a formula, in three coordinates.
pub fn scene(piece: Piece) -> Scene {
    let mut scene = Scene::new();
    let [x, y, z] = scene.coordinates("point", ["x", "y", "z"]);
    [(x, -0.5), (y, 0.4), (z, -0.2)].into_iter().for_each(|(q, at)| scene.place(q, at));
    let u = scene.control("u");
    let b = scene.design("b", 0.7);
    // A number of its own, so that the cost is a polynomial in its arguments.
    let weight = 1.3.into();
    scene.kinetic_energy("masses of x and y", piece, [x, y], [b.into()]);
    scene.kinetic_energy("masses of z and y", piece, [z, y], [b.into()]);
    scene.potential_energy("V of x and y", piece, [x, y], [b.into()]);
    scene.potential_energy("V of z and y", piece, [z, y], [b.into()]);
    scene.force("push", piece, [y, z], [u], [b.into()]);
    scene.cost("cost", piece, Sum::Trapezoidal, [x, y, z], [], [], [weight]);
    scene
}
