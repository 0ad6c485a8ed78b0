//! [`Argument`]: what a formula may depend on, in the numbering of the scene.

use super::cost::CostRows;
use super::element::Element;
use super::typed::Slot;

/// An argument of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Argument {
    Coordinate(usize),
    Velocity(usize),
    Momentum(usize),
    Force(usize),
    Acceleration(usize),
    Reaction(usize),
    Multiplier(usize),
    Control(usize),
    ControlRate(usize),
    Design(usize),
    Time,
}

impl Argument {
    /// What an element's own argument is, and by which factor it is a multiple of it.
    pub(super) fn of(element: &Element, slot: Slot) -> (Self, f64) {
        match slot {
            Slot::Q(i) => (Argument::Coordinate(element.q[i]), 1.0),
            Slot::V(i) => (Argument::Velocity(element.q[i]), 1.0),
            Slot::Sigma(j) => (Argument::Multiplier(element.sigma[j]), 1.0),
            Slot::U(k) => (Argument::Control(element.u[k]), 1.0),
            Slot::T => (Argument::Time, 1.0),
            // A number changes with nothing.
            Slot::B(p) => element.b[p].bound().map_or((Argument::Time, 0.0), |(p, factor)| (Argument::Design(p), factor)),
        }
    }

    /// Adds a derivative with respect to it.
    pub(super) fn add(self, rows: &mut CostRows, x: f64) {
        match self {
            Argument::Coordinate(i) => rows.q[i] += x,
            Argument::Velocity(i) => rows.v[i] += x,
            Argument::Momentum(i) => rows.p_star[i] += x,
            Argument::Force(i) => rows.p_star_dot[i] += x,
            Argument::Acceleration(i) => rows.v_dot[i] += x,
            Argument::Reaction(j) => rows.lambda[j] += x,
            Argument::Multiplier(j) => rows.sigma[j] += x,
            Argument::Control(k) => rows.u[k] += x,
            Argument::ControlRate(k) => rows.u_dot[k] += x,
            Argument::Design(p) => rows.design[p] += x,
            Argument::Time => rows.time += x,
        }
    }
}
