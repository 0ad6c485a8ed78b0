//! Strings of like elements, of any number and in any order.

use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar, Scene, Sum,
};
use nalgebra::SVector;

/// ½ v².
struct Heavy;

impl KineticEnergy<1> for Heavy {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

/// ½ b d² + d⁴ + sin(0.3 d + t) of a distance d, and a force that depends on a control.
struct Tie;

impl PotentialEnergy<2, 1> for Tie {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, t: S) -> S {
        let d = q[1] - q[0];
        b[0] * d * d * 0.5 + d.powi(4) + (d * 0.3 + t).sin()
    }
}

impl Force<2, 1, 1> for Tie {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 1>) -> SVector<S, 2> {
        SVector::from_fn(|i, _| at.u[0] * at.q[i] - at.v[i] * at.q[1 - i].exp() * b[0] * 0.1)
    }
}

/// Keeps x² + y² = 1.
struct Circle;

impl Constraint<2, 1> for Circle {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([(q[0] * q[0] + q[1] * q[1] - 1.0) * 0.5])
    }
}

/// ½ x².
struct Square;

impl Cost<1> for Square {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0] * at.q[0] * 0.5
    }
}

/// How the ties of a string of bodies follow each other.
#[derive(Clone, Copy, Debug)]
pub enum Order {
    Forwards,
    Backwards,
    /// Every third one ties to the first body.
    Mixed,
}

/// So many bodies of C coordinates, each tied to the next; the first and the last coordinate of each are on a circle if these are two.
pub fn string<const C: usize>(bodies: usize, order: Order) -> Scene {
    let mut scene = Scene::new();
    let strength = scene.design("strength", 3.0);
    let u = scene.control("u");
    let q: Vec<[Coordinate; C]> = (0..bodies)
        .map(|k| {
            let q = scene.coordinates(&format!("body {k}"), std::array::from_fn(|i| ["x", "y", "z", "w"][i]));
            let (sin, cos) = (0.7 * k as f64).sin_cos();
            scene.place(q[C - 1], sin);
            if C > 1 {
                scene.place(q[0], cos);
                scene.constraint(&format!("circle {k}"), Circle, [q[0], q[C - 1]], []);
            }
            for (i, q) in q.into_iter().enumerate() {
                scene.kinetic_energy(&format!("mass {k} {i}"), Heavy, [q], []);
            }
            q
        })
        .collect();
    for k in 1..bodies {
        let k = if matches!(order, Order::Backwards) { bodies - k } else { k };
        let before = if matches!(order, Order::Mixed) && k % 3 == 0 { 0 } else { k - 1 };
        let ends = [q[before][C - 1], q[k][0]];
        scene.potential_energy(&format!("tie {k}"), Tie, ends, [strength.into()]);
        scene.force(&format!("damper {k}"), Tie, ends, [u], [0.2.into()]);
    }
    scene.cost("square", Square, Sum::Trapezoidal, [q[bodies - 1][0]], [], [], []);
    scene
}
