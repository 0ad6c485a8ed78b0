//! How one state follows from those before it: the equations of a step, and Newton's method for them.

mod evaluation;
mod newton;
mod predict;
mod sizes;
mod step;

pub(crate) use evaluation::Evaluation;
pub(crate) use newton::{Miss, NOISE, Newton, SMALL, STILL};
pub(crate) use predict::Predictor;
pub(crate) use sizes::UnitWeights;
pub(crate) use step::{StepFailure, Unknowns};
