//! [`Argument`]: an argument that a formula may depend on, in the scene's numbering.

use super::cost::CostRows;
use super::cost_shape::Of;
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
    /// The scene's argument for an argument of an element, and the factor between the two.
    pub(super) fn of(element: &Element, slot: Slot) -> (Self, f64) {
        match slot {
            Slot::Q(i) => (Argument::Coordinate(element.q[i]), 1.0),
            Slot::V(i) => (Argument::Velocity(element.q[i]), 1.0),
            Slot::Sigma(j) => (Argument::Multiplier(element.sigma[j]), 1.0),
            Slot::U(k) => (Argument::Control(element.u[k]), 1.0),
            Slot::T => (Argument::Time, 1.0),
            // A plain number has no derivative.
            Slot::B(p) => element.b[p].bound().map_or((Argument::Time, 0.0), |(p, factor)| (Argument::Design(p), factor)),
        }
    }

    /// The scene's argument for an argument of a cost.
    pub(super) fn of_cost((list, place): (Of, usize)) -> Self {
        let of = match list {
            Of::Q => Argument::Coordinate,
            Of::V => Argument::Velocity,
            Of::PStar => Argument::Momentum,
            Of::PStarDot => Argument::Force,
            Of::VDot => Argument::Acceleration,
            Of::Sigma => Argument::Multiplier,
            Of::Lambda => Argument::Reaction,
            Of::U => Argument::Control,
            Of::UDot => Argument::ControlRate,
            Of::Time => return Argument::Time,
        };
        of(place)
    }

    /// Adds a derivative with respect to this argument.
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

/// Trial values of an argument, used to find out whether it causes a value that is not finite.
const OTHERS: [f64; 6] = [0.5, 1.0, 2.0, -0.5, 1e3, -1e3];

/// The arguments that cause a formula not to be finite: those for which some trial value makes it finite, or all if there are none.
pub(super) fn to_blame<K: Copy>(all: Vec<(K, Argument)>, has_number: impl Fn(K, f64) -> bool) -> Vec<Argument> {
    let is_to_blame = |(key, _): &&(K, Argument)| OTHERS.iter().any(|&other| has_number(*key, other));
    let found: Vec<&(K, Argument)> = all.iter().filter(is_to_blame).collect();
    let found = if found.is_empty() { all.iter().collect() } else { found };
    distinct(found.into_iter().map(|(_, argument)| *argument).collect())
}

/// Sorts the arguments and removes duplicates.
pub(super) fn distinct(mut arguments: Vec<Argument>) -> Vec<Argument> {
    arguments.sort_unstable();
    arguments.dedup();
    arguments
}
