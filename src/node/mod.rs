//! The node problem: velocities and multipliers of one node, from the known part of the scheme.

mod convergence;
mod correction;
mod damped;
mod evaluation;
mod factors;
mod lengths;
mod line;
mod linear_part;
mod linearisation;
mod lost_digits;
mod newton;
mod phi_along;
mod predict;
mod projection;
mod second_order_programs;
mod sizes;
mod solved;
mod step;
mod transposed;

#[cfg(test)]
mod tests;

pub(crate) use correction::{SETTLED, Shrinking, Size, add_correction, diverged, overflow};
pub(crate) use evaluation::Evaluation;
pub(crate) use lengths::Lengths;
pub(crate) use linearisation::Linearisation;
pub(crate) use lost_digits::warn_of_lost_digits;
pub(crate) use newton::{Miss, Newton, SMALL, STILL};
pub(crate) use phi_along::{ALONG, PhiAlong};
pub(crate) use predict::Predictor;
pub(crate) use projection::{MOST_CORRECTIONS_OF_PROJECTION, Point, Projection};
pub(crate) use second_order_programs::SecondOrderPrograms;
pub(crate) use sizes::UnitWeights;
pub(crate) use solved::SolvedMotion;
pub(crate) use step::{StepFailure, Unknowns};
