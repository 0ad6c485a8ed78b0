//! [`Sketch`]: what of a scene can be drawn: its bodies, and what joins them.

use super::{Control, Frame, Param, Point};

/// The parts of a scene that have a place in the plane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sketch {
    /// Bodies and particles by their names.
    pub(crate) bodies: Vec<(String, Frame)>,
    pub(crate) drawn: Vec<Drawn>,
}

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
    /// A force by a control, if it has one, or a prescribed distance.
    Cylinder {
        control: Option<Control>,
    },
    /// A force on b along an axis of a, or a torque on b, by a control.
    Force {
        axis: Param,
        control: Control,
    },
    Torque {
        control: Control,
    },
    /// The half-plane through a with its outer normal.
    Ground {
        normal: Param,
    },
    /// A wheel on b.
    Wheel {
        radius: Param,
    },
}
