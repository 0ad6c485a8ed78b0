//! Constraints that depend on each other: rank, compliances, and the choice of the equations that are left out.

mod breaking;
mod circuits;
mod closeness;
mod compliances;
mod dependent;
mod pivots;
mod rank;
mod relax;
mod selection;

pub(crate) use closeness::UNDETERMINED;
pub(crate) use compliances::{COMPLIANCE, SUSPICIOUS, apparent_masses, compliances, flexibilities, masses, sufficient};
pub(crate) use dependent::{Dependence, Dependent, Losses};
pub(crate) use pivots::pivots;
pub(crate) use rank::{RANK, Scaled, can_be_met, decomposition, is_singular, mass_matrix, near_singular, null_space};
