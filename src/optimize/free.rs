//! [`Free`]: a quantity that an optimiser may change, with its bounds, scale and form.

use super::problem::Interval;
use crate::model::Handle;
use crate::{Control, Coordinate, Design, Error, Inputs, System};

/// A quantity that an optimiser may change.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// A control at all nodes.
    Control(Control),
    /// A control given at a number of knots that are equidistant in time, and linear between them.
    LinearControl(Control, usize),
    /// A control in a number of pieces of equal duration, with the same value at all nodes of a piece; a node between two pieces belongs to
    /// the later one. Between nodes, and hence between pieces, controls are linear.
    PiecewiseControl(Control, usize),
    /// A control as a clamped cubic B-spline with a number of coefficients and with knots equidistant in time. Bounds are those of the coefficients,
    /// and hence of all values.
    SplineControl(Control, usize),
    /// A design variable.
    Design(Design),
    /// An initial coordinate; for an assembled start, the guess or the held value.
    Coordinate(Coordinate),
    /// An initial velocity, or an initial momentum if momenta are given.
    Rate(Coordinate),
    /// The duration of the motion, s; all steps scale by the same factor.
    Duration,
    /// The length (s) of the step that ends at the given node; the first step ends at node 1.
    StepLength(usize),
}

/// A free quantity with its bounds, scale and form.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Free {
    /// The quantity.
    pub quantity: Quantity,
    /// Bounds in the unit of the quantity.
    pub bounds: Interval,
    /// Scale: the value of the quantity when the optimisation variable is 1.
    pub scale: f64,
    /// True if the variable is the logarithm, for positive quantities of unknown order of magnitude.
    pub logarithm: bool,
}

impl Free {
    /// A free quantity without bounds, with scale 1.
    pub fn new(quantity: Quantity) -> Self {
        Free { quantity, bounds: Interval::FREE, scale: 1.0, logarithm: false }
    }

    /// A control at all nodes.
    pub fn control(control: Control) -> Self {
        Free::new(Quantity::Control(control))
    }

    /// A design variable.
    pub fn design(design: Design) -> Self {
        Free::new(Quantity::Design(design))
    }

    /// The duration of the motion.
    pub fn duration() -> Self {
        Free::new(Quantity::Duration)
    }

    /// Sets bounds, in the unit of the quantity.
    pub fn within(self, least: f64, most: f64) -> Self {
        Free { bounds: Interval::new(least, most), ..self }
    }

    /// Sets the scale: the value of the quantity when the optimisation variable is 1.
    pub fn scaled(self, scale: f64) -> Self {
        Free { scale, ..self }
    }

    /// Makes the variable the logarithm of the quantity.
    pub fn logarithmic(self) -> Self {
        Free { logarithm: true, ..self }
    }

    pub(super) fn to_variable(&self, value: f64) -> f64 {
        if self.logarithm { (value / self.scale).ln() } else { value / self.scale }
    }

    pub(super) fn to_value(&self, x: f64) -> f64 {
        self.scale * if self.logarithm { x.exp() } else { x }
    }

    /// d value / dx.
    pub(super) fn slope(&self, x: f64) -> f64 {
        self.scale * if self.logarithm { x.exp() } else { 1.0 }
    }

    pub(super) fn knots(&self, nodes: usize) -> usize {
        match self.quantity {
            Quantity::Control(_) => nodes,
            Quantity::LinearControl(_, knots) | Quantity::PiecewiseControl(_, knots) | Quantity::SplineControl(_, knots) => {
                knots
            }
            _ => 1,
        }
    }
}

/// An input, which may be free only once: its kind, its number within the kind, and its handle, if it has one.
#[derive(PartialEq, Eq, Hash)]
pub(super) struct Subject {
    kind: u8,
    index: usize,
    handle: Option<Handle>,
}

impl Quantity {
    /// The control, if it is one.
    pub(super) fn control(&self) -> Option<Control> {
        match *self {
            Quantity::Control(control)
            | Quantity::LinearControl(control, _)
            | Quantity::PiecewiseControl(control, _)
            | Quantity::SplineControl(control, _) => Some(control),
            _ => None,
        }
    }

    /// True for an initial coordinate, velocity or momentum.
    pub(super) fn is_initial(&self) -> bool {
        matches!(self, Quantity::Coordinate(_) | Quantity::Rate(_))
    }

    /// The input that is free.
    pub(super) fn subject(&self) -> Subject {
        let handled = |kind, handle: Handle| Subject { kind, index: handle.index, handle: Some(handle) };
        match self {
            Quantity::Control(control)
            | Quantity::LinearControl(control, _)
            | Quantity::PiecewiseControl(control, _)
            | Quantity::SplineControl(control, _) => handled(0, control.0),
            Quantity::Design(design) => handled(1, design.0),
            Quantity::Coordinate(q) => handled(2, q.0),
            Quantity::Rate(q) => handled(3, q.0),
            Quantity::Duration => Subject { kind: 4, index: 0, handle: None },
            Quantity::StepLength(node) => Subject { kind: 5, index: node.wrapping_sub(1), handle: None },
        }
    }

    /// The name of the quantity in a motion with the given number of steps.
    ///
    /// # Errors
    /// A quantity that does not exist or belongs to another scene.
    pub(super) fn name(&self, system: &System, steps: usize) -> Result<String, Error> {
        let counts = [system.k(), system.designs(), system.n(), system.n(), 1, steps];
        let Subject { kind, index, handle } = self.subject();
        if index >= counts[usize::from(kind)] || handle.is_some_and(|handle| !system.owns(handle)) {
            let kinds = ["control", "design variable", "coordinate", "coordinate", "duration", "step"];
            let number = if kind == 5 { index.wrapping_add(1) } else { index };
            return Err(Error::NoSuchInput { input: format!("{} {number}", kinds[usize::from(kind)]) });
        }
        Ok(match kind {
            0 => system.control_name(index).to_string(),
            1 => system.design_name(index).to_string(),
            2 => format!("initial {}", system.coordinate_name(index)),
            3 => format!("initial rate of {}", system.coordinate_name(index)),
            4 => "duration".to_string(),
            _ => format!("length of step {}", index + 1),
        })
    }
}

/// Checks the times of readings, unless the optimiser may move their nodes; these may have been moved before.
pub(super) fn check_reading_times(system: &System, inputs: &Inputs, free: &[Free]) -> Result<(), Error> {
    let moves = |of: &Free| matches!(of.quantity, Quantity::Duration | Quantity::StepLength(_));
    if free.iter().any(moves) { Ok(()) } else { inputs.check_reading_times(system) }
}
