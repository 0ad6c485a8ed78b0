//! Accelerations v̇ and reactions λ at a node, and the sums of the costs of a motion, which may depend on them.

mod evaluation;
mod events;
mod state;
mod sums;

pub(crate) use evaluation::{Accelerations, AccelerationsOfCosts};
pub(crate) use events::EventFunctions;
pub(crate) use sums::{CostSum, check_sums};
