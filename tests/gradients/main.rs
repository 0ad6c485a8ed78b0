//! Costs and their derivatives of first and second order, also of long motions, against other ways to them.

#[path = "../common/mod.rs"]
mod common;
#[path = "../scenes/mod.rs"]
mod scenes;

mod cost_arguments;
mod costs;
mod grid_phase;
mod impacts;
mod impacts_crossed;
mod located;
mod long;
mod long_chain;
mod many;
mod outputs;
mod paper;
mod paper_system;
mod second_order;
mod timed;
mod units;
mod zero_steps;
