//! Motions: schemes, grids, orders, restarts, halved steps, what they keep and what they warn of.

#[path = "../common/mod.rs"]
mod common;
#[path = "../scenes/mod.rs"]
mod scenes;

mod adapt;
mod bad_run;
mod composed_restarts;
mod compositions;
mod condition;
mod conservation;
mod convergence;
mod corrected;
mod event_truth;
mod events;
mod hard_steps;
mod impact_truth;
mod kinks;
mod restart;
mod schemes;
mod smooth;
mod warnings;
