//! [`Sketch`]: the parts of a scene that can be drawn, bodies and their connections.

use super::frame::Owner;
use super::space::{Bodies, Motion};
use super::{Control, Coordinate, Frame, Param, Point};

/// The parts of a scene that have a position.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sketch {
    /// Bodies and particles with their names.
    pub(crate) bodies: Vec<(String, Frame)>,
    /// The numbers of the bodies without a moment of inertia: point masses at the end of a rod.
    pub(crate) point_masses: Vec<usize>,
    pub(crate) drawn: Vec<Drawn>,
    /// The bodies in space.
    pub(crate) space: Bodies,
    /// Controls that act along coordinates, and in space along directions, or about them.
    pub(crate) driven: Vec<(Control, Drives)>,
    /// The acceleration of gravity, m/s², if it was set.
    pub(crate) gravity: [Option<Param>; 3],
}

impl Sketch {
    /// The unit of each coordinate; only those of bodies and joints are known.
    pub(crate) fn units_of_coordinates(&self, coordinates: usize) -> Vec<Unit> {
        let mut units = vec![Unit::Unknown; coordinates];
        for frame in self.bodies.iter().map(|(_, frame)| frame) {
            match frame.owner() {
                Owner::Body([x, y, phi]) => {
                    [x, y].into_iter().for_each(|q| units[q.index()] = Unit::Length);
                    units[phi.index()] = Unit::Angle;
                }
                Owner::Particle(q) => q.into_iter().for_each(|q| units[q.index()] = Unit::Length),
                Owner::Ground => {}
            }
        }
        // The coordinate of several joints is that of the first one.
        for frame in self.space.frames.iter().rev() {
            match &frame.motion {
                Motion::Turn(_, of) => units[of.coordinate.index()] = Unit::Angle,
                Motion::Slide(_, of) => units[of.coordinate.index()] = Unit::Length,
                Motion::Ball(_) => {}
            }
        }
        units
    }

    /// The unit of each control, known if all actuators that it drives agree.
    pub(crate) fn units_of_controls(&self, controls: usize, coordinates: usize) -> Vec<Unit> {
        let of_coordinates = self.units_of_coordinates(coordinates);
        let of_drawn = self.drawn.iter().filter_map(|part| match part.shape {
            Shape::Force { control, .. } | Shape::Cylinder { control: Some(control) } => Some((control, Unit::Length)),
            Shape::Torque { control } => Some((control, Unit::Angle)),
            _ => None,
        });
        let of_driven = self.driven.iter().map(|(control, driven)| match driven {
            Drives::Displacement(unit) => (*control, *unit),
            Drives::Coordinate(q) => (*control, of_coordinates[q.index()]),
        });
        let mut units: Vec<Option<Unit>> = vec![None; controls];
        for (control, unit) in of_drawn.chain(of_driven) {
            let known = &mut units[control.index()];
            *known = Some(if known.is_some_and(|other| other != unit) { Unit::Unknown } else { unit });
        }
        units.into_iter().map(|unit| unit.unwrap_or(Unit::Unknown)).collect()
    }
}

/// The displacement along which a control acts: of a known kind, or a coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drives {
    Displacement(Unit),
    Coordinate(Coordinate),
}

/// Kind of a coordinate or constraint, or of the displacement along which a control acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unit {
    Length,
    Angle,
    Unknown,
}

impl Unit {
    /// The unit for lengths or for angles; empty if the kind is unknown.
    pub(crate) fn of<'a>(self, (length, angle): (&'a str, &'a str)) -> &'a str {
        match self {
            Unit::Length => length,
            Unit::Angle => angle,
            Unit::Unknown => "",
        }
    }
}

/// Units of forces and torques.
pub(crate) const FORCE: (&str, &str) = ("N", "N m");

/// A connection between a point of one body and a point of another.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    pub(crate) a: Point,
    pub(crate) b: Point,
}

/// Shape of a connection. Angles are those of an axis in the frame of a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    Hinge,
    Slider {
        axis: Param,
    },
    Weld,
    Rod,
    Spring,
    /// A cylinder between a and b: a force given by the control if there is one, otherwise a prescribed distance.
    Cylinder {
        control: Option<Control>,
    },
    /// A force on the point b along an axis of the frame of a, given by a control.
    Force {
        axis: Param,
        control: Control,
    },
    Torque {
        control: Control,
    },
    /// The half-plane through the point a, given by its outer normal.
    Ground {
        normal: Param,
    },
    /// A wheel on b.
    Wheel {
        radius: Param,
    },
}
