//! The joints of space. Where all coordinates of a joint are zero, the axes of its two markers coincide.

use nalgebra::SVector;

use super::Spatial;
use crate::model::space::{Components, Following, Marker, Motion};
use crate::model::{Coordinate, Multiplier};
use crate::scene::ready::{Entry, Kind, Part, Sort};
use crate::{Constraint, Scalar};

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
    /// rotation. Set them by [`Scene::place_rotation`](crate::Scene::place_rotation), and their rates by [`Start::set_angular_velocity`](crate::Start::set_angular_velocity).
    pub orientation: [Coordinate; 4],
}

/// The motion of a body that no joint holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// The displacement of b relative to a along the axes of a, m.
    pub position: [Coordinate; 3],
    /// The Euler parameters e = (cos θ/2, n sin θ/2) of the rotation of b relative to a by the angle θ about the unit vector n; e and −e are the same
    /// rotation. Set them by [`Scene::place_rotation`](crate::Scene::place_rotation), and their rates by [`Start::set_angular_velocity`](crate::Start::set_angular_velocity).
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

/// A turn about, or a slide along, axis `axis`.
fn turn(axis: usize, angle: Coordinate) -> Motion<Following> {
    Motion::Turn(axis, Following::of(angle))
}

fn slide(axis: usize, offset: Coordinate) -> Motion<Following> {
    Motion::Slide(axis, Following::of(offset))
}

pub(super) static REVOLUTE: Kind = Kind::of_markers("revolute in space", &[], |scene, name, part| {
    let [angle] = scene.coordinates(name, ["angle"]);
    scene.spatial().join(name, part, vec![turn(Z, angle)]);
});

pub(super) static PRISMATIC: Kind = Kind::of_markers("prismatic in space", &[], |scene, name, part| {
    let [offset] = scene.coordinates(name, ["offset"]);
    scene.spatial().join(name, part, vec![slide(Z, offset)]);
});

const FOLLOWING: &[(&str, Sort)] = &[("of", Sort::Coordinate)];

pub(super) static DEPENDENT_REVOLUTE: Kind =
    Kind::of_markers("dependent revolute", &["factor", "offset"], |scene, name, part| {
        let motion = Motion::Turn(Z, scene.following(name, part));
        scene.spatial().join(name, part, vec![motion]);
    })
    .with(FOLLOWING);

pub(super) static DEPENDENT_PRISMATIC: Kind =
    Kind::of_markers("dependent prismatic", &["factor", "offset"], |scene, name, part| {
        let motion = Motion::Slide(Z, scene.following(name, part));
        scene.spatial().join(name, part, vec![motion]);
    })
    .with(FOLLOWING);

pub(super) static UNIVERSAL: Kind = Kind::of_markers("universal", &[], |scene, name, part| {
    let [first, second] = scene.coordinates(name, ["first angle", "second angle"]);
    scene.spatial().join(name, part, vec![turn(X, first), turn(Y, second)]);
});

pub(super) static CYLINDRICAL: Kind = Kind::of_markers("cylindrical", &[], |scene, name, part| {
    let [offset, angle] = scene.coordinates(name, ["offset", "angle"]);
    scene.spatial().join(name, part, vec![slide(Z, offset), turn(Z, angle)]);
});

pub(super) static PLANAR: Kind = Kind::of_markers("planar joint", &[], |scene, name, part| {
    let [x, y, angle] = scene.coordinates(name, ["x", "y", "angle"]);
    scene.spatial().join(name, part, vec![slide(X, x), slide(Y, y), turn(Z, angle)]);
});

pub(super) static FIXED: Kind = Kind::of_markers("fixed", &[], |scene, name, part| {
    scene.spatial().join(name, part, Vec::new());
});

pub(super) static LOAD_CELL: Kind = Kind::of_markers("load cell", &[], |scene, name, part| {
    let q = scene.coordinates(name, ["x", "y", "z", "turn about x", "turn about y", "turn about z"]);
    let slides = (X..=Z).map(|axis| slide(axis, q[axis]));
    let turns = (X..=Z).map(|axis| turn(axis, q[3 + axis]));
    scene.spatial().join(name, part, slides.chain(turns).collect());
    scene.constraint(name, Locked, q, []);
});

pub(super) static BALL: Kind = Kind::of_markers("ball", &[], |scene, name, part| {
    let orientation = scene.coordinates(name, ["e0", "e1", "e2", "e3"]);
    let mut space = scene.spatial();
    space.turn_freely(name, orientation);
    space.join(name, part, vec![Motion::Ball(orientation.map(Following::of))]);
});

pub(super) static FREE: Kind = Kind::of_markers("free", &[], |scene, name, part| {
    let (_, motions) = scene.spatial().free_motions(name);
    scene.spatial().join(name, part, motions);
});

impl Spatial<'_> {
    /// Adds a hinge: b turns relative to a about their common z axis.
    pub fn revolute(&mut self, name: &str, a: Marker, b: Marker) -> Revolute {
        let [angle] = self.joint(name, Part::at_markers(&REVOLUTE, &[a, b], &[]));
        Revolute { angle }
    }

    /// Adds a slider: b moves relative to a along their common z axis.
    pub fn prismatic(&mut self, name: &str, a: Marker, b: Marker) -> Prismatic {
        let [offset] = self.joint(name, Part::at_markers(&PRISMATIC, &[a, b], &[]));
        Prismatic { offset }
    }

    /// Adds a hinge whose angle is a factor times another coordinate plus an offset, rad, for example of a gear; `numbers` are factor and offset.
    pub fn dependent_revolute(&mut self, name: &str, a: Marker, b: Marker, of: Coordinate, numbers: impl Components<2>) {
        let part = Part::at_markers(&DEPENDENT_REVOLUTE, &[a, b], &numbers.params());
        self.scene.ready(name, Part { more: vec![Entry::Coordinate(of)], ..part });
    }

    /// Adds a slider whose displacement is a factor times another coordinate plus an offset, m, for example of a rack; `numbers` are factor and offset.
    pub fn dependent_prismatic(&mut self, name: &str, a: Marker, b: Marker, of: Coordinate, numbers: impl Components<2>) {
        let part = Part::at_markers(&DEPENDENT_PRISMATIC, &[a, b], &numbers.params());
        self.scene.ready(name, Part { more: vec![Entry::Coordinate(of)], ..part });
    }

    /// Adds a universal joint: b turns relative to a about the x axis of a, then about its own y axis.
    pub fn universal(&mut self, name: &str, a: Marker, b: Marker) -> Universal {
        Universal { angles: self.joint(name, Part::at_markers(&UNIVERSAL, &[a, b], &[])) }
    }

    /// Adds a cylindrical joint: b moves along and turns about the common z axis.
    pub fn cylindrical(&mut self, name: &str, a: Marker, b: Marker) -> Cylindrical {
        let [offset, angle] = self.joint(name, Part::at_markers(&CYLINDRICAL, &[a, b], &[]));
        Cylindrical { offset, angle }
    }

    /// Adds a planar joint: b moves in the x–y plane of a and turns about its z axis.
    pub fn planar(&mut self, name: &str, a: Marker, b: Marker) -> PlanarJoint {
        let [x, y, angle] = self.joint(name, Part::at_markers(&PLANAR, &[a, b], &[]));
        PlanarJoint { offsets: [x, y], angle }
    }

    /// Fixes b to a.
    pub fn fixed(&mut self, name: &str, a: Marker, b: Marker) {
        self.scene.ready(name, Part::at_markers(&FIXED, &[a, b], &[]));
    }

    /// Fixes b to a by a load cell, whose multipliers are the impulses of the force and torque that the connection transmits: read their reactions λ in
    /// costs and outputs. To measure the forces in a joint, insert a body without mass between it and its outer body, and fix that by a load cell.
    ///
    /// The cell has six coordinates, which six constraints keep at zero.
    pub fn load_cell(&mut self, name: &str, a: Marker, b: Marker) -> LoadCell {
        let part = Part::at_markers(&LOAD_CELL, &[a, b], &[]);
        let [x, y, z, torque @ ..]: [Multiplier; 6] = self.scene.multipliers_of(|scene| scene.ready(name, part));
        LoadCell { force: [x, y, z], torque }
    }

    /// Adds a ball joint. Its orientation has four coordinates, the Euler parameters e, and one constraint, (|e|² − 1)/2 = 0, with the
    /// name of the joint and `(|e| = 1)`.
    pub fn ball(&mut self, name: &str, a: Marker, b: Marker) -> Ball {
        Ball { orientation: self.joint(name, Part::at_markers(&BALL, &[a, b], &[])) }
    }

    /// Lets b move freely relative to a.
    pub fn free(&mut self, name: &str, a: Marker, b: Marker) -> Free {
        let part = Part::at_markers(&FREE, &[a, b], &[]);
        let [x, y, z, orientation @ ..]: [Coordinate; 7] = self.joint(name, part);
        Free { position: [x, y, z], orientation }
    }

    /// Seven coordinates of a free motion.
    pub(super) fn free_motions(&mut self, name: &str) -> ([Coordinate; 7], Vec<Motion<Following>>) {
        let all = self.scene.coordinates(name, ["x", "y", "z", "e0", "e1", "e2", "e3"]);
        let [x, y, z, e @ ..] = all;
        self.turn_freely(name, e);
        (all, vec![slide(X, x), slide(Y, y), slide(Z, z), Motion::Ball(e.map(Following::of))])
    }

    fn turn_freely(&mut self, name: &str, e: [Coordinate; 4]) {
        self.scene.place(e[0], 1.0);
        self.scene.constraint(&format!("{name} (|e| = 1)"), Unit, e, []);
    }
}
