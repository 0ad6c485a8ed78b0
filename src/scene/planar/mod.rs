//! Planar rigid bodies, joints and forces, as elements of a scene.
//!
//! A body has the coordinates (x, y, φ) of its centre of mass in the inertial frame, in m and rad. A point of a body is expressed in the
//! body's own frame, `body.at(0.5, 0.0)`; [`Body::GROUND`] is the inertial frame and has no coordinates. Every number can be replaced by a
//! [`Design`](crate::Design) variable.
//!
//! ```
//! use hamiltonian_adjoint::planar::Body;
//! use hamiltonian_adjoint::Scene;
//!
//! let mut scene = Scene::new();
//! scene.gravity(0.0, -9.81);
//! let rod = scene.body("rod", 1.2, 0.1, [0.0, -0.5, -std::f64::consts::FRAC_PI_2]);
//! scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
//! scene.joint_friction("pivot friction", Body::GROUND, rod, 0.01);
//! let system = scene.compile()?;
//! assert_eq!((system.n(), system.m()), (3, 2));
//! # Ok::<(), hamiltonian_adjoint::Error>(())
//! ```

mod body;
mod circles;
mod contact;
mod drawing;
mod drives;
mod forces;
mod gears;
mod geometry;
mod ground;
mod joints;
mod motion;
mod onset;
mod rigid;
mod stops;
#[cfg(test)]
mod tests;

pub use crate::model::{Frame, Point};
pub use body::{Body, Particle, PointMass, RigidBody, Weight};
pub use circles::CircleContact;
pub(super) use contact::dry_friction;
pub use contact::{Bushing, BushingDamper, CoulombFriction, CoulombSliding};
pub use drives::{AppliedForce, AppliedTorque, DrivenDistance, DrivenSlider, MOST_PARAMETERS, TwoPointActuator};
pub use forces::{
    Actuator, Damper, JointFriction, LinearSpring, SlidingFriction, TorqueActuator, TorsionalSpring, ZeroLengthSpring,
};
pub use gears::{Curve, Gear, PointOnCurve, Rack};
pub use geometry::{Link, rotated, turned};
pub use joints::{Distance, DrivenAngle, Prismatic, Revolute, Weld};
#[cfg(feature = "files")]
pub(crate) use motion::MOTIONS;
pub(super) use motion::with_motion;
pub use motion::{Constant, ConstantSpeed, Harmonic, Motion};
pub use rigid::{PointOnLine, RigidContact};
pub use stops::{EndStop, SlidingEndStop};
pub(super) use stops::{stop_force, within};

/// All kinds of ready-made parts.
#[cfg(feature = "files")]
pub(crate) static KINDS: [&crate::scene::ready::Kind; 31] = [
    &body::BODY,
    &body::PARTICLE,
    &joints::REVOLUTE,
    &joints::PRISMATIC,
    &joints::WELD,
    &joints::DISTANCE,
    &joints::DRIVEN_ANGLE,
    &drives::DRIVEN_DISTANCE,
    &drives::DRIVEN_SLIDER,
    &drives::TWO_POINT_ACTUATOR,
    &drives::APPLIED_FORCE,
    &drives::APPLIED_TORQUE,
    &forces::SPRING_DAMPER,
    &forces::TORSIONAL_SPRING_DAMPER,
    &forces::JOINT_FRICTION,
    &forces::SLIDING_FRICTION,
    &forces::ACTUATOR,
    &forces::TORQUE_ACTUATOR,
    &contact::BUSHING,
    &contact::COULOMB_FRICTION,
    &contact::COULOMB_SLIDING,
    &rigid::RIGID_CONTACT,
    &circles::CONTACT,
    &circles::CIRCLE_CONTACT,
    &circles::CIRCLE_PAIR,
    &stops::END_STOP,
    &stops::SLIDING_END_STOP,
    &gears::GEAR,
    &gears::RACK,
    &drawing::DRAWN_SPRING,
    &drawing::DRAWN_ROD,
];
