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
pub use functions::{MarkerFunction, MarkerPoint, Quantity};
pub use joints::{Ball, Cylindrical, Free, LoadCell, PlanarJoint, Prismatic, Revolute, Universal};
pub use path::{Load, MarkerState};

use super::Scene;
pub use crate::model::space::{Body, Components, Inertia, Marker};
use crate::model::space::{BodyPart, Carried, Following, Motion};
use crate::scene::planar;

/// The part of a scene that is in space ([`Scene::spatial`]).
#[derive(Debug)]
pub struct Spatial<'a> {
    scene: &'a mut Scene,
}

impl Scene {
    /// Access to rigid bodies in space and their joints.
    pub fn spatial(&mut self) -> Spatial<'_> {
        Spatial { scene: self }
    }
}

impl Spatial<'_> {
    /// Adds a rigid body. A joint must carry it.
    pub fn body(&mut self, name: &str, inertia: Inertia) -> Body {
        let scene = &mut *self.scene;
        scene.recipe.note_own(name);
        scene.check_params(name, &inertia.params());
        scene.require_nonnegative(inertia.mass, format!("the mass of `{name}`"));
        for length in inertia.lengths.into_iter().filter(|length| length.constant() != Some(0.0)) {
            scene.require_nonnegative(length, format!("an edge or the radius of `{name}`"));
        }
        if !inertia.is_unchecked {
            scene.parts.tensors.push((name.into(), inertia.tensor));
        }
        scene.parts.scene.begin_part();
        scene.parts.sketch.space.all.push(BodyPart { name: name.into(), inertia, carried: None });
        Body(Some(scene.parts.scene.handle(scene.parts.sketch.space.all.len() - 1)))
    }

    /// A body in the plane as a body in space, whose z axis is that of the inertial frame: for joints that carry bodies in space, and for markers.
    pub fn planar_body(&mut self, name: &str, body: planar::Body) -> Body {
        let inner = self.body(name, Inertia::none());
        let [x, y, angle] = body.coordinates.map(Following::of);
        let motions = vec![Motion::Slide(0, x), Motion::Slide(1, y), Motion::Turn(2, angle)];
        let scene = &mut *self.scene;
        if scene.check(name, "coordinate", body.coordinates.map(|q| q.0)) {
            let space = &mut scene.parts.sketch.space;
            let at = space.add_frames(Carried::at_origin(None), motions);
            space.carry(space.all.len() - 1, at);
        }
        inner
    }

    /// Sets the acceleration of gravity of all bodies, m/s², including those in the plane, of which x and y act. The default is zero.
    pub fn gravity(&mut self, acceleration: impl Components<3>) {
        self.scene.set_gravity(acceleration.params());
    }
}
