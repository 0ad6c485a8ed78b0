//! Costs: their programs, their values and derivatives at a node, and how they are summed.

mod cost_factors;
mod cost_programs;
mod cost_use;
mod costs;
mod placed_cost;
mod quadratic_form;
mod rows;
mod terms;
mod weights;

pub(crate) use cost_factors::{CostFactors, EVENTS};
pub(crate) use cost_programs::CostPrograms;
pub(crate) use cost_use::Depends;
pub(in crate::system) use cost_use::Term;
pub(in crate::system) use costs::{Along, Costs, Suspect};
pub(crate) use placed_cost::PlacedCost;
pub(crate) use rows::CostRows;
pub(in crate::system) use terms::Terms;
pub(crate) use weights::{Beside, GivenWeights, Occurring, Weights};
