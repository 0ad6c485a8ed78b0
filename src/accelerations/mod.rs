//! Accelerations v̇ and reactions λ at a node, and the sums of the costs of a motion, which may depend on them.

mod evaluation;
mod events;
mod of_costs;
mod state;
mod sums;

pub(crate) use evaluation::Accelerations;
pub(crate) use events::EventFunctions;
pub(crate) use of_costs::AccelerationsOfCosts;
pub(crate) use sums::{CostSum, check_sums};
