//! Costs: their programs, their values and derivatives at a node, and how they are summed.

mod cost_factors;
mod cost_formula;
mod cost_program;
mod cost_second_order;
mod cost_use;
mod costs;
mod placed_cost;
mod rows;
mod suspect;
mod terms;
mod weights;

pub(crate) use cost_factors::CostFactors;
pub(crate) use cost_formula::CostMemory;
pub(crate) use cost_second_order::CostSecondOrder;
pub(crate) use cost_use::Depends;
pub(in crate::system) use cost_use::Term;
pub(in crate::system) use costs::Costs;
pub(crate) use placed_cost::PlacedCost;
pub(crate) use rows::CostRows;
pub(in crate::system) use suspect::Suspect;
pub(in crate::system) use terms::Terms;
pub(crate) use weights::{Beside, GivenWeights, Weights};
