//! Chains of hinges in space.

use hamiltonian_adjoint::spatial::{Body, Inertia, Quantity};
use hamiltonian_adjoint::{Cost, CostPoint, Param, Scalar, Scene, Sum};
use nalgebra::SVector;

/// sin q₀ + ½ v₀².
struct Swing;

impl Cost<1, 0, 0, 0> for Swing {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.v[0] * at.v[0] * 0.5
    }
}

/// A chain of boxes with hinges about different axes, cut at every `piece`-th body unless this is zero.
pub fn chain(joints: usize, piece: usize, is_skew: bool) -> Scene {
    let mut scene = Scene::new();
    let numbers: [Param; 2] = if is_skew {
        [("mass", 0.4), ("length", 0.1)].map(|(name, value)| scene.design(name, value).into())
    } else {
        [0.4.into(), 0.1.into()]
    };
    let [mass, length] = numbers;
    let torque = scene.control("torque");
    let mut space = scene.spatial();
    space.gravity([0.3, 0.0, -9.81]);
    let (mut outer, mut angles) = (Body::GROUND.origin(), Vec::new());
    for k in 0..joints {
        let axis = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.2, 0.9]][k % if is_skew { 3 } else { 2 }];
        let inertia = Inertia::cuboid(mass, (0.04, 0.03, length)).centred_at((0.005, 0.0, length * -0.5));
        let link = space.body(&format!("link {k}"), inertia);
        angles.push(space.revolute(&format!("hinge {k}"), outer.along(axis), link.origin().along(axis)).angle);
        if piece > 0 && k % piece == piece - 1 && k + 1 < joints {
            space.cut(&format!("cut {k}"), link);
        }
        outer = link.at((0.0, 0.01, length * -1.0));
    }
    space.torque("motor", Body::GROUND.origin(), outer, torque);
    space.outputs("tip", Quantity::Velocity, outer, Sum::Terminal);
    angles.iter().enumerate().for_each(|(k, angle)| scene.place(*angle, 0.3 - 0.05 * k as f64));
    angles
        .iter()
        .enumerate()
        .for_each(|(k, angle)| scene.axis_spring_damper(&format!("damper {k}"), *angle, 0.0, 0.0, 0.02));
    scene.cost("swing", Swing, Sum::Terminal, [angles[joints - 1]], [], [], []);
    scene
}
