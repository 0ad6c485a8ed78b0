//! A mass on a line, and elements that are one formula of its place, its velocity and time.

use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar, Scene, System,
};
use nalgebra::SVector;

/// ½ m v², b = [m].
pub struct Mass;
impl KineticEnergy<1, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        b[0] * v[0] * v[0] * 0.5
    }
}

/// A function of q, v, t as an element of any kind, so that each test is a formula.
pub struct Own<F>(pub F);
pub trait Formula: Send + Sync + 'static {
    fn at<S: Scalar>(&self, q: S, v: S, t: S) -> S;
}
impl<F: Formula> Force<1> for Own<F> {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([self.0.at(at.q[0], at.v[0], at.t)])
    }
}
impl<F: Formula> PotentialEnergy<1> for Own<F> {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, t: S) -> S {
        self.0.at(q[0], S::zero(), t)
    }
}
impl<F: Formula> Constraint<1, 1> for Own<F> {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        SVector::from([self.0.at(q[0], S::zero(), t)])
    }
}
impl<F: Formula> Cost<1> for Own<F> {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        self.0.at(at.q[0], at.v[0], at.t)
    }
}

/// A mass on a line, with what `add` adds to it.
pub fn sled(mass: f64, add: impl FnOnce(&mut Scene, Coordinate)) -> System {
    let mut scene = Scene::new();
    let [x] = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Mass, [x], [mass.into()]);
    add(&mut scene, x);
    scene.compile().expect("scene")
}
