//! The node problem: the velocities and multipliers of one node, from what a scheme knows of it beforehand.

mod convergence;
mod damped;
mod evaluation;
mod factors;
mod linear_part;
mod newton;
mod predict;
mod sizes;
mod step;
mod transposed;

#[cfg(test)]
mod tests;

pub(crate) use convergence::NOISE;
pub(crate) use evaluation::Evaluation;
pub(crate) use newton::{Miss, Newton, SMALL, STILL};
pub(crate) use predict::Predictor;
pub(crate) use sizes::UnitWeights;
pub(crate) use step::{StepFailure, Unknowns};
