//! Robots from URDF files.
//!
//! A [`Robot`] is read from a file or a text and added to a scene, as rigid bodies in space with the coordinates of its joints:
//!
//! ```
//! use hamiltonian_adjoint::{Grid, Inputs, Mechanics, Scene};
//! use urdf::{Options, Robot};
//!
//! let robot = Robot::from_text(
//!     r#"<robot name="pendulum">
//!          <link name="wall"/>
//!          <link name="bob"><inertial>
//!            <origin xyz="0 0 -0.5"/><mass value="2"/>
//!            <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>
//!          </inertial></link>
//!          <joint name="hinge" type="continuous">
//!            <parent link="wall"/><child link="bob"/><axis xyz="0 1 0"/>
//!          </joint>
//!        </robot>"#,
//! )?;
//! let mut scene = Scene::new();
//! scene.spatial().gravity([0.0, 0.0, -9.81]);
//! let added = robot.add_to(&mut scene, &Options::default())?;
//! let hinge = added.joint("hinge").expect("it moves").coordinates[0];
//! scene.place(hinge, 0.3);
//! let system = scene.compile()?;
//! let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
//! let (acceleration, _) = Mechanics::at_start(&system, &inputs)?.accelerations()?;
//! assert!((acceleration[0] + 9.81 / 0.5 * 0.3f64.sin()).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Links become bodies, whose frames are those of the links. Joints of the types revolute, continuous, prismatic, fixed, floating and planar are read,
//! with mimic joints and any axes. Shapes, meshes, transmissions and the tags of simulators are ignored: no file is opened except the given one.
//! Limits, friction and efforts are returned as data and have no effect on the motion.
//!
//! Files may come from strangers: their size and the number of their elements are bounded, document type definitions (DTD) are refused, and a
//! malformed file causes an [`Error`] with line and column.

mod add;
mod added;
mod error;
mod inertia;
mod mimic;
mod read;
mod robot;
mod scan;
mod tree;

pub use added::{Added, Base, Damping, Follower, Locked, Moving, Options};
pub use error::{Doubt, Error, Fault, Position, Why};
pub use mimic::Cause;
pub use robot::{Inertial, Joint, Kind, Limit, Link, Mimic, Pose, Robot};
