//! Rigid bodies in space and the joints between them.
//!
//! A joint carries a body: it connects a [`Marker`] of an outer body, or of the ground, to a marker of the body that it carries, and has the
//! coordinates of their relative motion. Joints and bodies form trees, whose coordinates need no constraints. Every body needs exactly one joint that
//! carries it; joints are added from the ground outwards.
//!
//! ```
//! use hamiltonian_adjoint::spatial::{Body, Inertia};
//! use hamiltonian_adjoint::Scene;
//!
//! let mut scene = Scene::new();
//! let mut space = scene.spatial();
//! space.gravity([0.0, 0.0, -9.81]);
//! let rod = space.body("rod", Inertia::cuboid(1.2, [0.05, 0.05, 1.0]));
//! let hinge = space.revolute("hinge", Body::GROUND.at([0.0; 3]).along([0.0, 1.0, 0.0]), rod.at([0.0, 0.0, 0.5]).along([0.0, 1.0, 0.0]));
//! scene.place(hinge.angle, 0.3);
//! let system = scene.compile()?;
//! assert_eq!((system.n(), system.m()), (1, 0));
//! # Ok::<(), hamiltonian_adjoint::Error>(())
//! ```

mod carry;
mod cut;
mod elements;
mod forces;
mod formula;
mod functions;
mod joints;
mod loops;
mod path;
mod quaternion;
mod tree;

pub use forces::MarkerForce;
pub use functions::{MarkerFunction, MarkerPoint};
pub use joints::{Ball, Cylindrical, Free, LoadCell, PlanarJoint, Prismatic, Revolute, Universal};
pub use path::{Load, MarkerState};

use super::Scene;
use crate::Error;
pub use crate::model::space::{Body, Components, Inertia, Marker, Quantity};
use crate::model::space::{BodyPart, Carried, Following, Motion};
use crate::scene::planar;
use crate::scene::ready::{Entry, Kind, Part, Sort};

/// The part of a scene that is in space ([`Scene::spatial`]).
#[derive(Debug)]
pub struct Spatial<'a> {
    scene: &'a mut Scene,
}

const OF_BODY: &[&str] = &[
    "mass", "centre", "centre", "centre", "inertia", "inertia", "inertia", "inertia", "inertia", "inertia", "lengths",
    "lengths", "lengths",
];

static BODY: Kind = Kind {
    optional: &["centre", "lengths"],
    ..Kind::new("body in space", OF_BODY, |scene, name, part| {
        let (centre, tensor, lengths) = (part.numbers_from(1), part.numbers_from(4), part.numbers_from(10));
        scene.add_body_in_space(name, Inertia { mass: part.number(0), centre, tensor, lengths, is_unchecked: part.flag() });
    })
    .with(&[("unchecked", Sort::Flag)])
};

static PLANAR_BODY: Kind = Kind::of_frames("planar body", &[], |scene, name, part| {
    let inner = scene.add_body_in_space(name, Inertia::none());
    let Some(q) = part.points[0].frame.coordinates() else {
        return scene.report(Error::NoBody { element: name.to_string() });
    };
    let [x, y, angle] = q.map(Following::of);
    if scene.check(name, "coordinate", q.map(|q| q.0)) {
        let space = &mut scene.parts.sketch.space;
        let motions = vec![Motion::Slide(0, x), Motion::Slide(1, y), Motion::Turn(2, angle)];
        let at = space.add_frames(Carried::at_origin(None), motions);
        space.carry(inner, at);
    }
})
.at(&["body"]);

/// All kinds of parts in space.
#[cfg(feature = "files")]
pub(crate) static KINDS: [&Kind; 32] = [
    &BODY,
    &PLANAR_BODY,
    &joints::REVOLUTE,
    &joints::PRISMATIC,
    &joints::DEPENDENT_REVOLUTE,
    &joints::DEPENDENT_PRISMATIC,
    &joints::UNIVERSAL,
    &joints::CYLINDRICAL,
    &joints::PLANAR,
    &joints::FIXED,
    &joints::LOAD_CELL,
    &joints::BALL,
    &joints::FREE,
    &cut::CUT,
    &loops::CLOSE_BALL,
    &loops::CLOSE_PARALLEL,
    &loops::CLOSE_REVOLUTE,
    &loops::CLOSE_CYLINDRICAL,
    &loops::CLOSE_PRISMATIC,
    &loops::CLOSE_FIXED,
    &loops::POINT_ON_PLANE,
    &loops::POINT_ON_LINE,
    &loops::DISTANCE,
    &loops::DRIVEN_DISTANCE,
    &forces::THRUST,
    &forces::TORQUE,
    &forces::APPLIED_IN_SPACE,
    &forces::APPLIED_ON_BODY,
    &forces::TWO_POINT_ACTUATOR,
    &forces::SPRING_DAMPER,
    &functions::OUTPUTS,
    &functions::ROTATION_ERROR,
];

impl Scene {
    /// Adds a rigid body in space and returns its number.
    fn add_body_in_space(&mut self, name: &str, inertia: Inertia) -> usize {
        self.check_params(name, &inertia.params());
        self.require_nonnegative(inertia.mass, format!("the mass of `{name}`"));
        for length in inertia.lengths.into_iter().filter(|length| length.constant() != Some(0.0)) {
            self.require_nonnegative(length, format!("an edge or the radius of `{name}`"));
        }
        if !inertia.is_unchecked {
            self.parts.tensors.push((name.into(), inertia.tensor));
        }
        self.parts.scene.begin_part();
        let bodies = &mut self.parts.sketch.space.all;
        bodies.push(BodyPart { name: name.into(), inertia, carried: None });
        bodies.len() - 1
    }

    /// Access to rigid bodies in space and their joints.
    pub fn spatial(&mut self) -> Spatial<'_> {
        Spatial { scene: self }
    }
}

impl Spatial<'_> {
    /// Adds a rigid body. A joint must carry it.
    pub fn body(&mut self, name: &str, inertia: Inertia) -> Body {
        // Lengths that can never be negative need no check.
        let lengths = inertia.lengths.map(|x| if x.constant().is_some_and(|x| x >= 0.0) { 0.0.into() } else { x });
        let (numbers, more) = (Inertia { lengths, ..inertia }.params(), vec![Entry::Flag(inertia.is_unchecked)]);
        self.scene.ready(name, Part { numbers, more, ..Part::of(&BODY) });
        self.last_body()
    }

    fn last_body(&self) -> Body {
        let last = self.scene.parts.sketch.space.all.len() - 1;
        Body(Some(self.scene.parts.scene.handle(last)))
    }

    /// A body in the plane as a body in space, whose z axis is that of the inertial frame: for joints that carry bodies in space, and for markers.
    pub fn planar_body(&mut self, name: &str, body: planar::Body) -> Body {
        let points = vec![planar::Frame::from(body).origin()];
        self.scene.ready(name, Part { points, ..Part::of(&PLANAR_BODY) });
        self.last_body()
    }

    /// Sets the acceleration of gravity of all bodies, m/s², including those in the plane, of which x and y act. The default is zero.
    pub fn gravity(&mut self, acceleration: impl Components<3>) {
        self.scene.set_gravity(acceleration.params());
    }
}
