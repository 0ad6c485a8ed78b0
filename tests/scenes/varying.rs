//! A bead whose mass matrix varies, with energy that is linear in the velocities, on an ellipse that grows in time.

use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{Constraint, Coordinate, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar, Scene, Sum};
use nalgebra::SVector;

/// T = ½ m (1 + x²) |v|² + k (x ẏ − 3 y ẋ), V = m g y, b = [m, k]: a mass matrix that varies, and a part that is linear in the velocities.
struct Varying;

impl KineticEnergy<2, 2> for Varying {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 2>) -> S {
        b[0] * (q[0] * q[0] + 1.0) * v.dot(v) * 0.5 + b[1] * (q[0] * v[1] - q[1] * v[0] * 3.0)
    }
}

impl PotentialEnergy<2, 2> for Varying {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 2>, _t: S) -> S {
        b[0] * q[1] * 9.81
    }
}

/// x² + 2 y² = b² (1 + t).
struct Ellipse;

impl Constraint<2, 1, 1> for Ellipse {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] * q[0] + q[1] * q[1] * 2.0 - b[0] * b[0] * (t + 1.0)])
    }
}

/// A control as a force.
struct Push;

impl Force<1, 1> for Push {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0]])
    }
}

/// The bead, not quite on its ellipse.
pub fn bead() -> (Scene, [Coordinate; 2]) {
    let mut scene = Scene::new();
    let q = scene.coordinates("bead", ["x", "y"]);
    let [m, k, size] = [("mass", 1.3), ("gyro", 0.4), ("size", 1.1)].map(|(name, value)| scene.design(name, value));
    scene.place(q[0], 0.9);
    scene.place(q[1], -0.9);
    scene.kinetic_energy("bead", Varying, q, [m.into(), k * m]);
    scene.potential_energy("weight", Varying, q, [m.into(), k.into()]);
    scene.constraint("ellipse", Ellipse, q, [size.into()]);
    let u = scene.control("push");
    scene.force("push", Push, [q[0]], [u], []);
    scene.cost("x", AngleError, Sum::Trapezoidal, [q[0]], [], [], [0.2.into()]);
    (scene, q)
}
