//! The adjoint sweep: the discrete adjoint equations, the gradient, and checks of its reliability.

mod accuracy;
mod assembly;
mod backward;
mod cost_node;
mod costs;
mod event;
mod gradient;
mod grid_phase;
mod grid_phase_warning;
mod growth;
mod located;
mod record;
mod resolution;
mod second_order;
mod stage;
mod sweep;

pub use gradient::{AdjointVariables, Gradient};
pub(crate) use grid_phase::GridPhase;
pub(crate) use located::Located;
pub(crate) use second_order::{SecondOrderSweep, check as check_direction};
pub(crate) use sweep::AdjointSweep;
