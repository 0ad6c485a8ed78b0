//! [`Argument`]: what a formula may depend on, in the numbering of the scene.

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

/// Removes duplicates.
pub(in crate::system) fn distinct(mut arguments: Vec<Argument>) -> Vec<Argument> {
    arguments.sort_unstable();
    arguments.dedup();
    arguments
}
