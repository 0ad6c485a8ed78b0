//! The joints of space. Where all coordinates of a joint are zero, the axes of its two markers coincide.

use nalgebra::SVector;

use super::Spatial;
use crate::model::space::{self, Body, BodyPart, Carried, Components, Following, Joint, Marker, Motion};
use crate::model::{Coordinate, Multiplier, Param};
use crate::scene::Scene;
use crate::{Constraint, Error, Scalar};

/// A joint with one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolute {
    /// The rotation of b relative to a about their common z axis, rad.
    pub angle: Coordinate,
}

/// A joint with one displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prismatic {
    /// The displacement of b relative to a along their common z axis, m.
    pub offset: Coordinate,
}

/// A joint with two angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Universal {
    /// The rotation about the x axis of a, then about the y axis of b, rad.
    pub angles: [Coordinate; 2],
}

/// A joint with one displacement and one angle about the same axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylindrical {
    /// The displacement of b relative to a along their common z axis, m.
    pub offset: Coordinate,
    /// The rotation of b relative to a about their common z axis, rad.
    pub angle: Coordinate,
}

/// A joint in whose plane a body moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarJoint {
    /// The displacement of b relative to a along the x and y axes of a, m.
    pub offsets: [Coordinate; 2],
    /// The rotation of b relative to a about their common z axis, rad.
    pub angle: Coordinate,
}

/// A joint with all rotations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// The Euler parameters e = (cos θ/2, n sin θ/2) of the rotation of b relative to a by the angle θ about the unit vector n; e and −e are the same
    /// rotation. Set them by [`Scene::place_rotation`], and their rates by [`Start::set_angular_velocity`](crate::Start::set_angular_velocity).
    pub orientation: [Coordinate; 4],
}

/// The motion of a body that no joint holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// The displacement of b relative to a along the axes of a, m.
    pub position: [Coordinate; 3],
    /// The Euler parameters e = (cos θ/2, n sin θ/2) of the rotation of b relative to a by the angle θ about the unit vector n; e and −e are the same
    /// rotation. Set them by [`Scene::place_rotation`], and their rates by [`Start::set_angular_velocity`](crate::Start::set_angular_velocity).
    pub orientation: [Coordinate; 4],
}

/// A rigid connection whose force and torque are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadCell {
    /// The multipliers of the force along the axes x, y and z of a. Their reactions λ (N) act on b as −λ and on a as λ.
    pub force: [Multiplier; 3],
    /// The multipliers of the torque about these axes, with reactions in N m of the same signs.
    pub torque: [Multiplier; 3],
}

/// q = 0.
struct Locked;

impl Constraint<6, 6> for Locked {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 6> {
        *q
    }
}

/// |e|² − 1 = 0, halved so that its derivative is e.
struct Unit;

impl Constraint<4, 1> for Unit {
    fn phi<S: Scalar>(&self, e: &SVector<S, 4>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from_element((e.dot(e) - 1.0) * 0.5)
    }
}

/// The axes x, y and z.
const X: usize = 0;
const Y: usize = 1;
const Z: usize = 2;

impl Spatial<'_> {
    /// Adds a hinge: b turns relative to a about their common z axis.
    pub fn revolute(&mut self, name: &str, a: Marker, b: Marker) -> Revolute {
        let [angle] = self.scene.coordinates(name, ["angle"]);
        self.join(name, a, b, vec![Motion::Turn(Z, Following::of(angle))]);
        Revolute { angle }
    }

    /// Adds a slider: b moves relative to a along their common z axis.
    pub fn prismatic(&mut self, name: &str, a: Marker, b: Marker) -> Prismatic {
        let [offset] = self.scene.coordinates(name, ["offset"]);
        self.join(name, a, b, vec![Motion::Slide(Z, Following::of(offset))]);
        Prismatic { offset }
    }

    /// Adds a hinge whose angle is a factor times another coordinate plus an offset, rad, for example of a gear; `numbers` are factor and offset.
    pub fn dependent_revolute(&mut self, name: &str, a: Marker, b: Marker, of: Coordinate, numbers: impl Components<2>) {
        let motion = Motion::Turn(Z, self.following(name, of, numbers.params()));
        self.join(name, a, b, vec![motion]);
    }

    /// Adds a slider whose displacement is a factor times another coordinate plus an offset, m, for example of a rack; `numbers` are factor and offset.
    pub fn dependent_prismatic(&mut self, name: &str, a: Marker, b: Marker, of: Coordinate, numbers: impl Components<2>) {
        let motion = Motion::Slide(Z, self.following(name, of, numbers.params()));
        self.join(name, a, b, vec![motion]);
    }

    /// Adds a universal joint: b turns relative to a about the x axis of a, then about its own y axis.
    pub fn universal(&mut self, name: &str, a: Marker, b: Marker) -> Universal {
        let angles = self.scene.coordinates(name, ["first angle", "second angle"]);
        let [first, second] = angles.map(Following::of);
        self.join(name, a, b, vec![Motion::Turn(X, first), Motion::Turn(Y, second)]);
        Universal { angles }
    }

    /// Adds a cylindrical joint: b moves along and turns about the common z axis.
    pub fn cylindrical(&mut self, name: &str, a: Marker, b: Marker) -> Cylindrical {
        let [offset, angle] = self.scene.coordinates(name, ["offset", "angle"]);
        self.join(name, a, b, vec![Motion::Slide(Z, Following::of(offset)), Motion::Turn(Z, Following::of(angle))]);
        Cylindrical { offset, angle }
    }

    /// Adds a planar joint: b moves in the x–y plane of a and turns about its z axis.
    pub fn planar(&mut self, name: &str, a: Marker, b: Marker) -> PlanarJoint {
        let [x, y, angle] = self.scene.coordinates(name, ["x", "y", "angle"]);
        let slides = [(X, x), (Y, y)].map(|(axis, offset)| Motion::Slide(axis, Following::of(offset)));
        self.join(name, a, b, [&slides[..], &[Motion::Turn(Z, Following::of(angle))]].concat());
        PlanarJoint { offsets: [x, y], angle }
    }

    /// Fixes b to a.
    pub fn fixed(&mut self, name: &str, a: Marker, b: Marker) {
        self.join(name, a, b, Vec::new());
    }

    /// Fixes b to a by a load cell, whose multipliers are the impulses of the force and torque that the connection transmits: read their reactions λ in
    /// costs and outputs. To measure the forces in a joint, insert a body without mass between it and its outer body, and fix that by a load cell.
    ///
    /// The cell has six coordinates, which six constraints keep at zero.
    pub fn load_cell(&mut self, name: &str, a: Marker, b: Marker) -> LoadCell {
        let q = self.scene.coordinates(name, ["x", "y", "z", "turn about x", "turn about y", "turn about z"]);
        let of = q.map(Following::of);
        let slides = (X..=Z).map(|axis| Motion::Slide(axis, of[axis]));
        let turns = (X..=Z).map(|axis| Motion::Turn(axis, of[3 + axis]));
        self.join(name, a, b, slides.chain(turns).collect());
        let [x, y, z, torque @ ..] = self.scene.constraint(name, Locked, q, []);
        LoadCell { force: [x, y, z], torque }
    }

    /// Adds a ball joint. Its orientation has four coordinates, the Euler parameters e, and one constraint, (|e|² − 1)/2 = 0, with the
    /// name of the joint and `(|e| = 1)`.
    pub fn ball(&mut self, name: &str, a: Marker, b: Marker) -> Ball {
        let orientation = self.scene.coordinates(name, ["e0", "e1", "e2", "e3"]);
        self.turn_freely(name, orientation);
        self.join(name, a, b, vec![Motion::Ball(orientation.map(Following::of))]);
        Ball { orientation }
    }

    /// Lets b move freely relative to a.
    pub fn free(&mut self, name: &str, a: Marker, b: Marker) -> Free {
        let ([x, y, z, orientation @ ..], motions) = self.free_motions(name);
        self.join(name, a, b, motions);
        Free { position: [x, y, z], orientation }
    }

    /// Seven coordinates of a free motion.
    pub(super) fn free_motions(&mut self, name: &str) -> ([Coordinate; 7], Vec<Motion<Following>>) {
        let all = self.scene.coordinates(name, ["x", "y", "z", "e0", "e1", "e2", "e3"]);
        let [x, y, z, e @ ..] = all;
        self.turn_freely(name, e);
        let slides = [(X, x), (Y, y), (Z, z)].map(|(axis, offset)| Motion::Slide(axis, Following::of(offset)));
        (all, [&slides[..], &[Motion::Ball(e.map(Following::of))]].concat())
    }

    fn turn_freely(&mut self, name: &str, e: [Coordinate; 4]) {
        self.scene.place(e[0], 1.0);
        self.scene.constraint(&format!("{name} (|e| = 1)"), Unit, e, []);
    }

    fn following(&mut self, name: &str, coordinate: Coordinate, [factor, offset]: [Param; 2]) -> Following {
        self.scene.check(name, "coordinate", [coordinate.0]);
        self.scene.check_params(name, &[factor, offset]);
        Following { coordinate, factor, offset }
    }

    /// Lets a joint carry the body of b.
    fn join(&mut self, name: &str, a: Marker, b: Marker, motions: Vec<Motion<Following>>) {
        self.scene.recipe.note_own(name);
        if !self.scene.check_marker(name, b) {
            return;
        }
        let Body(Some(body)) = b.body() else { return self.scene.report(Error::CarriesGround { joint: name.into() }) };
        if a.body() == b.body() {
            return self.scene.report(Error::NoBody { element: name.into() });
        }
        let Some(outer) = self.fixed_at(name, a) else { return };
        let scene = &mut *self.scene;
        let inner = match b.axes.checked_rotation(name, &|param| scene.present_value(param)) {
            Ok(inner) => inner,
            Err(error) => return scene.report(error),
        };
        let space = &mut scene.parts.sketch.space;
        let BodyPart { name: own, carried, .. } = &space.all[body.index];
        if carried.is_some() {
            let first = space.joints.iter().find(|joint| joint.body == body.index).map_or(own, |joint| &joint.name);
            let (joint, first, body) = (name.into(), first.clone(), own.clone());
            return scene.report(Error::SecondJoint { joint, first, body });
        }
        // The frame of the body from the marker.
        let back = space::transposed(inner);
        let origin = space::negated(space::apply(back, b.at));
        let first = space.frames.len();
        let carried = space.add_frames(outer, motions).inner(back, origin);
        space.carry(body.index, carried);
        space.joints.push(Joint { name: name.into(), body: body.index, frames: first..space.frames.len() });
    }

    /// Where a marker is fixed; `None` after an error was reported.
    pub(super) fn fixed_at(&mut self, part: &str, marker: Marker) -> Option<Carried> {
        let scene = &mut *self.scene;
        if !scene.check_marker(part, marker) {
            return None;
        }
        let at = scene.parts.sketch.space.fixed_at(part, marker, &|param| scene.present_value(param));
        at.map_err(|error| scene.report(error)).ok()
    }
}

impl Scene {
    fn check_marker(&mut self, part: &str, marker: Marker) -> bool {
        self.check(part, "body", marker.body().0) && self.check_params(part, &marker.params())
    }

    /// The value of a parameter for the design variables of the scene.
    fn present_value(&self, param: Param) -> f64 {
        param.constant().unwrap_or_else(|| self.present_values()(param))
    }

    /// The values of all parameters for the design variables of the scene.
    pub(super) fn present_values(&self) -> impl Fn(Param) -> f64 + use<> {
        let designs: Vec<f64> = self.parts.designs.iter().map(|(_, value)| *value).collect();
        let expressions = self.parts.scene.expressions().evaluate(&[], &designs);
        move |param| param.present_value(&designs, &expressions)
    }
}
