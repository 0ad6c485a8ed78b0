//! The forward sweep: the consistent start, then one step after another.

mod adapt;
mod checkpoint;
mod coarse;
mod contacts;
mod continuation;
mod drift;
mod events;
mod failure;
mod given_start;
mod locate;
mod monitor;
mod restart;
mod restarting;
mod run;
mod samples;
mod start;
mod step;
mod stepper;
mod sweep;
mod unresolved_steps;
mod window;

pub(crate) use adapt::check_new_grid;
pub(crate) use checkpoint::Checkpoint;
pub(crate) use stepper::Stepper;
pub(crate) use sweep::ForwardSweep;
pub(crate) use window::HISTORY;
