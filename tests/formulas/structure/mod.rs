//! What a scene concludes from its formulas when it is compiled holds for every value that they are run with: the same formula, once traced and
//! once opaque to the trace, gives the same motion and the same gradient.

mod changed;
mod cut;
mod domains;
mod random;
mod vanishing;
mod wide;
mod zeros;

use crate::files;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Error, Force, ForcePoint, Gradient, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene,
    Settings, Sum, System, gradient,
};
use nalgebra::SVector;

/// T = ½ b v².
struct Mass;
impl KineticEnergy<1, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        b[0] * v[0] * v[0] * 0.5
    }
}

/// Σ (q_i + ½ v_i)².
struct Squares;
impl<const N: usize> Cost<N> for Squares {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, 0, 0>, _b: &SVector<S, 0>) -> S {
        (0..N).map(|i| (at.q[i] + at.v[i] * 0.5).powi(2)).sum()
    }
}

/// A formula that looks at a value, so that a trace learns nothing of it.
struct Opaque<E>(E);

fn look<S: Scalar>(x: S) {
    assert!(!x.re().is_nan());
}

impl<E: KineticEnergy<N, P>, const N: usize, const P: usize> KineticEnergy<N, P> for Opaque<E> {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, N>, v: &SVector<S, N>, b: &SVector<S, P>) -> S {
        look(v[0]);
        self.0.kinetic_energy(q, v, b)
    }
}

impl<E: PotentialEnergy<N, P>, const N: usize, const P: usize> PotentialEnergy<N, P> for Opaque<E> {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, P>, t: S) -> S {
        look(q[0]);
        self.0.potential_energy(q, b, t)
    }
}

impl<E: Force<N, 0, P>, const N: usize, const P: usize> Force<N, 0, P> for Opaque<E> {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, N, 0>, b: &SVector<S, P>) -> SVector<S, N> {
        look(at.q[0]);
        self.0.force(at, b)
    }
}

impl<E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> Constraint<N, M, P> for Opaque<E> {
    fn phi<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, P>, t: S) -> SVector<S, M> {
        look(q[0]);
        self.0.phi(q, b, t)
    }
}

impl<E: Cost<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> Cost<N, M, K, P> for Opaque<E> {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, M, K>, b: &SVector<S, P>) -> S {
        look(at.q[0]);
        self.0.cost(at, b)
    }
}

/// J and all its derivatives for inputs that are made when the scene has been compiled.
fn run(scene: Scene, inputs: impl Fn(&mut Inputs)) -> Result<Gradient, Error> {
    let all = |system: &System| {
        let mut all = Inputs::at_rest(system, hamiltonian_adjoint::Grid::uniform(12, 0.05));
        inputs(&mut all);
        all
    };
    files::compared("a formula and what follows from it", &scene, &|_, system| all(system));
    let system = scene.compile()?;
    gradient(&system, &all(&system), Settings::default())
}

/// The largest difference of two gradients and their values, relative to the largest entry.
fn distance(a: &Gradient, b: &Gradient) -> f64 {
    let list = |g: &Gradient| -> Vec<f64> {
        let start = g.start.q().iter().chain(g.start.rate().iter()).copied();
        [g.value]
            .into_iter()
            .chain(start)
            .chain(g.controls.iter().copied())
            .chain(g.design.iter().copied())
            .chain(g.steps.iter().copied())
            .collect()
    };
    let (a, b) = (list(a), list(b));
    let size = a.iter().chain(&b).fold(1e-300f64, |size, x| size.max(x.abs()));
    // NaN is the largest of all.
    let distances = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / size);
    distances.fold(0.0, |worst: f64, x| if worst.is_nan() || x <= worst { worst } else { x })
}
