//! Parts that act along an axis: motors, springs, friction, rotors, stops and drives of single coordinates.
//!
//! An [`Axis`] is a coordinate s of the scene in m or rad: the angle or the displacement of a joint in space, a coordinate of a planar body, or a
//! coordinate of your own. It may also be a linear combination s = Σ a_k q_k, for example the difference of two angles. A force F along
//! the axis acts with a_k F on the coordinate q_k. Every number can be replaced by a [`Design`](crate::Design) variable.
//!
//! | part | equation |
//! |---|---|
//! | [`motor`](Scene::motor), [`axis_force`](Scene::axis_force) | F = u, F = f(t) |
//! | [`axis_spring_damper`](Scene::axis_spring_damper) | F = −c (s − s₀) − d ds/dt |
//! | [`axis_coulomb_friction`](Scene::axis_coulomb_friction) | F = −F_max tanh((ds/dt)/v_s) |
//! | [`axis_end_stop`](Scene::axis_end_stop) | F as a contact beyond a lower and an upper limit |
//! | [`rotor`](Scene::rotor) | T = ½ I (n ds/dt)² |
//! | [`driven_axis`](Scene::driven_axis), [`linear_relation`](Scene::linear_relation) | s = f(t), Σ a_k q_k = c |
//!
//! ```
//! use hamiltonian_adjoint::Scene;
//! use hamiltonian_adjoint::axis::Axis;
//! use hamiltonian_adjoint::spatial::{Body, Inertia};
//!
//! let mut scene = Scene::new();
//! let mut space = scene.spatial();
//! space.gravity([0.0, 0.0, -9.81]);
//! let [upper, lower] = ["upper", "lower"].map(|name| space.body(name, Inertia::cuboid(1.2, [0.05, 0.05, 0.5])));
//! let [y, x] = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
//! let shoulder = space.revolute("shoulder", Body::GROUND.origin().along(y), upper.at([0.0, 0.0, 0.25]).along(y));
//! let elbow = space.revolute("elbow", upper.at([0.0, 0.0, -0.25]).along(x), lower.at([0.0, 0.0, 0.25]).along(x));
//! let (torque, ratio) = (scene.control("torque"), scene.design("gear ratio", 50.0));
//! scene.motor("motor", shoulder.angle, torque);
//! scene.rotor("rotor", shoulder.angle, 2e-5, ratio); // kg m²
//! scene.axis_coulomb_friction("bearing", shoulder.angle, 0.2, 0.01); // N m, rad/s
//! scene.axis_spring_damper("belt", Axis::difference(shoulder.angle, 1.0, elbow.angle), 30.0, 0.0, 0.1);
//! scene.axis_end_stop("stop", elbow.angle, [(-2.0).into(), 2.0.into()], [200.0.into(), 0.1.into(), 0.02.into()]);
//! assert_eq!(scene.compile()?.n(), 2);
//! # Ok::<(), hamiltonian_adjoint::Error>(())
//! ```

mod along;
mod parts;

#[cfg(feature = "files")]
pub(crate) use parts::KINDS;

#[cfg(doc)]
use crate::Scene;
pub use crate::model::Axis;
