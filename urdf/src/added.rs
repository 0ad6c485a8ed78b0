//! [`Options`] of adding a robot to a scene, and [`Added`]: its parts in the scene.

use hamiltonian_adjoint::spatial::{Body, Free};
use hamiltonian_adjoint::{Control, Coordinate, Scene};

use crate::error::Doubt;
use crate::mimic::Cause;
use crate::robot::{Kind, Limit};

/// How a robot is added to a scene. By default its base is fixed at the origin, and joints are not damped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// The motion of the root link relative to the inertial frame.
    pub base: Base,
    /// Joints that keep a value, rad or m, by their names. Joints with several coordinates can be locked at 0 only.
    pub locked: Vec<(String, f64)>,
    /// The beginning of the names of all bodies and joints in the scene, for several robots in one scene.
    pub prefix: String,
    /// The damping of joints with one coordinate.
    pub damping: Damping,
    /// True if joints that mimic others have coordinates of their own.
    pub ignore_mimic: bool,
    /// True if inertias may be those of no distribution of mass, as in some files; [`Added::doubts`] contains them. If the mass matrix is not positive
    /// definite, the equations of motion may have no solution.
    pub accept_impossible_inertias: bool,
}

/// The motion of the root link relative to the inertial frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Base {
    /// None: its frame is the inertial frame.
    #[default]
    Fixed,
    /// Any: a free joint with the name `base` carries it.
    Floating,
}

/// The damping of joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Damping {
    /// None.
    #[default]
    None,
    /// The forces −d v with the values d of the file. Joints that mimic others contribute d times their factor squared.
    File,
}

/// The parts of a scene that belong to a robot, by their names in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Added {
    /// The joint of a floating base.
    pub base: Option<Free>,
    /// The joints that move, in the order of their coordinates: depth first from the root.
    pub joints: Vec<Moving>,
    /// The joints that follow others.
    pub followers: Vec<Follower>,
    /// The joints that do not move, without those of the type fixed.
    pub locked: Vec<Locked>,
    /// The bodies of the links, whose frames are those of the links.
    pub links: Vec<(String, Body)>,
    /// The links whose inertias no distribution of mass has.
    pub doubts: Vec<(String, Doubt)>,
    pub(crate) prefix: String,
}

/// A joint with coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Moving {
    /// The name of the joint.
    pub name: String,
    /// The type of the joint.
    pub kind: Kind,
    /// Its coordinates: an angle or a displacement; x, y and the angle of a planar joint, whose x axis is the next coordinate axis after the one
    /// closest to the normal, projected onto the plane; x, y, z and the Euler parameters of a floating joint.
    pub coordinates: Vec<Coordinate>,
    /// The limits of the file, which have no effect on the motion.
    pub limit: Option<Limit>,
    /// The damping of the file ([`Options::damping`]).
    pub damping: f64,
    /// The friction of the file, which has no effect on the motion.
    pub friction: f64,
}

/// A joint whose value is a factor times the coordinate of another joint plus an offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Follower {
    /// The name of the joint.
    pub name: String,
    /// The name of the joint with the coordinate.
    pub of: String,
    /// The factor, composed along a chain of joints.
    pub factor: f64,
    /// The offset, rad or m.
    pub offset: f64,
}

/// A joint that keeps a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Locked {
    /// The name of the joint.
    pub name: String,
    /// The value, rad or m.
    pub value: f64,
    /// The reason.
    pub cause: Cause,
}

impl Added {
    /// A joint that moves.
    pub fn joint(&self, name: &str) -> Option<&Moving> {
        self.joints.iter().find(|joint| joint.name == name)
    }

    /// The body of a link.
    pub fn link(&self, name: &str) -> Option<Body> {
        self.links.iter().find(|(known, _)| known == name).map(|(_, body)| *body)
    }

    /// The joints with one coordinate.
    pub fn drivable(&self) -> impl Iterator<Item = (&Moving, Coordinate)> {
        self.joints.iter().filter_map(|joint| match joint.coordinates[..] {
            [only] => Some((joint, only)),
            _ => None,
        })
    }

    /// Adds a control for every joint with one coordinate: its torque, N m, or its force, N. Their names are those of the joints.
    pub fn drive(&self, scene: &mut Scene) -> Vec<Control> {
        let drive = |(joint, coordinate): (&Moving, Coordinate)| {
            let name = format!("{}{}", self.prefix, joint.name);
            let control = scene.control(&name);
            scene.motor(&format!("drive of {name}"), coordinate, control);
            control
        };
        self.drivable().map(drive).collect()
    }
}
