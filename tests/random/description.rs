//! A scene and a motion of it as plain data, which generators make and shrink and `build` turns into calls of the public interface.
//!
//! Every index counts round and round through what there is, so that a description stays valid when something is taken out of it;
//! [`FOREIGN`] alone means a thing of another scene.

use hamiltonian_adjoint::{Composition, Settings, Sum};

/// The index of a thing that belongs to another scene.
pub const FOREIGN: usize = usize::MAX;

/// A scene and a motion.
#[derive(Clone, Debug)]
pub struct Description {
    pub gravity: [f64; 2],
    pub gravity_binding: Binding,
    /// The values of the design variables.
    pub designs: Vec<f64>,
    /// The number of control channels.
    pub controls: usize,
    pub bodies: Vec<Bar>,
    pub groups: Vec<Group>,
    /// Joints that close loops of the tree.
    pub loops: Vec<Loop>,
    pub redundant: Vec<Redundant>,
    pub loads: Vec<Load>,
    pub terms: Vec<Term>,
    /// Give all things of a kind the same name.
    pub same_names: bool,
    pub run: Run,
}

/// Which constants of an element are bound: constant number c is a multiple of design variable `first` + c if bit c of the mask is set.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    pub mask: u16,
    pub first: usize,
}

/// A rigid body with the joint that hangs it on the tree.
#[derive(Clone, Debug)]
pub struct Bar {
    pub mass: f64,
    pub inertia: f64,
    /// x, y, φ at the start.
    pub place: [f64; 3],
    /// The ground (0) or a body before this one.
    pub parent: usize,
    pub joint: Joint,
    pub binding: Binding,
}

/// A joint at a point of the plane: both sides have the point where it is at the start, so that every joint fits every placement.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    pub at: [f64; 2],
    pub kind: JointKind,
    pub binding: Binding,
}

#[derive(Clone, Copy, Debug)]
pub enum JointKind {
    Free,
    Revolute,
    Prismatic {
        axis: f64,
    },
    Weld,
    /// A rod to the point at this distance and angle.
    Distance {
        length: f64,
        angle: f64,
    },
    /// A hinge whose angle turns at constant speed.
    ConstantSpeed {
        speed: f64,
    },
    /// A hinge whose angle swings.
    Harmonic {
        amplitude: f64,
        frequency: f64,
        phase: f64,
    },
    /// A point of the second side on a parabola of the plane.
    Parabola {
        curvature: f64,
    },
    /// Angles that depend on each other, not linearly.
    Geared {
        ratio: f64,
    },
}

/// Two different ones of the ground and the bodies, or one with itself if `step` is [`FOREIGN`].
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub a: usize,
    pub step: usize,
}

#[derive(Clone, Copy, Debug)]
pub struct Loop {
    pub pair: Pair,
    pub joint: Joint,
}

/// Constraints that follow from others.
#[derive(Clone, Copy, Debug)]
pub enum Redundant {
    /// The hinge of this body once more, or further hinges at the same place if it has no hinge.
    DoubledHinge { body: usize },
    /// A parallelogram on the ground with three cranks of one length.
    ThirdCrank { length: f64, angle: f64 },
}

/// A mechanism in coordinates of its own, whose mass matrix depends on them.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    pub kind: GroupKind,
    pub place: [f64; 2],
    pub binding: Binding,
    /// Its second coordinate follows the angle of this body, if there is one, with this ratio.
    pub geared: Option<(usize, f64)>,
}

#[derive(Clone, Copy, Debug)]
pub enum GroupKind {
    Polar { mass: f64, radius: f64 },
    Coupled { masses: [f64; 2], coupling: f64 },
}

/// A force, a potential or a further mass.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    pub kind: LoadKind,
    pub pair: Pair,
    pub control: usize,
    pub binding: Binding,
}

#[derive(Clone, Copy, Debug)]
pub enum LoadKind {
    Strut {
        at: [f64; 2],
        length: f64,
        angle: f64,
        stiffness: f64,
        stretch: f64,
        damping: f64,
    },
    Torsion {
        stiffness: f64,
        angle: f64,
        damping: f64,
    },
    Friction {
        damping: f64,
    },
    Sliding {
        at: [f64; 2],
        axis: f64,
        damping: f64,
    },
    Actuator {
        at: [f64; 2],
        axis: f64,
    },
    Torque,
    AirDrag {
        coefficient: f64,
    },
    Magnet {
        strength: f64,
        distance: f64,
    },
    Wave {
        strength: f64,
        frequency: f64,
    },
    Mixed {
        constants: [f64; 3],
    },
    TipMass {
        mass: f64,
        at: [f64; 2],
    },
    /// A circle on a line or, if a radius is given, on a circle (or in a bore, for a negative radius); depth at the start, k, c, μ and width.
    Contact {
        at: [f64; 2],
        angle: f64,
        radius: Option<f64>,
        depth: f64,
        law: [f64; 4],
    },
    /// Limits from where the angle, or the displacement along an axis, is at the start; k, c and width.
    Stop {
        at: [f64; 2],
        axis: Option<f64>,
        limits: [f64; 2],
        law: [f64; 3],
    },
}

/// A term of the cost.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    pub kind: TermKind,
    pub sum: Sum,
    pub body: usize,
    pub multiplier: usize,
    pub control: usize,
    pub weight: f64,
    pub binding: Binding,
}

#[derive(Clone, Copy, Debug)]
pub enum TermKind {
    Everything,
    Coordinate,
    Effort,
    Reaction,
    Momentum,
}

/// How the scene is set in motion.
#[derive(Clone, Debug)]
pub struct Run {
    pub start: f64,
    pub steps: Vec<f64>,
    /// Macro steps of the first length in the place of the steps.
    pub composition: Option<Composition>,
    /// Steps by tolerance in the place of the steps.
    pub tolerance: Option<f64>,
    pub from: From,
    /// The size of the velocities and of the controls at the start.
    pub speed: f64,
    pub controls: f64,
    /// Where the seemingly random numbers of speeds and controls begin.
    pub seed: usize,
    pub settings: Settings,
    pub faults: Vec<Fault>,
}

#[derive(Clone, Copy, Debug)]
pub enum From {
    Momentum,
    /// The velocities that belong to those momenta.
    Velocity,
    /// Velocities that nobody made consistent.
    AnyVelocity,
}

/// Something wrong with the inputs.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// One entry (counted round) of a vector has this value.
    Value { of: Vector, index: usize, value: f64 },
    /// A vector has this many entries.
    Length { of: Vector, length: usize },
}

#[derive(Clone, Copy, Debug)]
pub enum Vector {
    Coordinates,
    Rates,
    Controls,
    Designs,
    Steps,
}
