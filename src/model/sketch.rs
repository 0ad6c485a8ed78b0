//! [`Sketch`]: what of a scene can be drawn: its bodies, and what joins them.

use super::{Control, Frame, Param, Point};

/// The parts of a scene that have a place in the plane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sketch {
    /// Bodies and particles by their names.
    pub(crate) bodies: Vec<(String, Frame)>,
    pub(crate) drawn: Vec<Drawn>,
}

impl Sketch {
    /// Those of the controls of actuators are known, where a control has no other.
    pub(crate) fn units_of_controls(&self, controls: usize) -> Vec<Unit> {
        let mut units: Vec<Option<Unit>> = vec![None; controls];
        for part in &self.drawn {
            let (control, unit) = match part.shape {
                Shape::Force { control, .. } | Shape::Cylinder { control: Some(control) } => (control, Unit::Length),
                Shape::Torque { control } => (control, Unit::Angle),
                _ => continue,
            };
            let known = &mut units[control.index()];
            *known = Some(if known.is_some_and(|other| other != unit) { Unit::Unknown } else { unit });
        }
        units.into_iter().map(|unit| unit.unwrap_or(Unit::Unknown)).collect()
    }
}

/// What a coordinate or a constraint measures, or a control works along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unit {
    Length,
    Angle,
    Unknown,
}

impl Unit {
    /// The unit for lengths or for angles; none if it is not known.
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

/// What joins a point of one body and one of another.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    pub(crate) a: Point,
    pub(crate) b: Point,
}

/// How it looks. Angles are those of an axis, in a's frame.
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
