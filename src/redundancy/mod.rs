//! Constraints that depend on each other: rank, compliances, and the choice of the equations that are left out.

mod breaking;
mod circuits;
mod compliances;
mod rank;

pub(crate) use breaking::designs;
pub(crate) use circuits::{Circuits, left_out};
pub(crate) use compliances::{
    COMPLIANCE, CONTRADICTION, Relaxed, apparent_masses, compliances, flexibilities, masses, of_loops, refuse_gaps,
    root_flexibility, softest,
};
pub(crate) use rank::{RANK, Scaled, can_be_met, is_singular, mass_matrix, near_singular, null_space};
