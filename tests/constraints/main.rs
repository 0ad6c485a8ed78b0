//! Joints, loops, dependent constraints and assembled starts.

#[path = "../common/mod.rs"]
mod common;
#[path = "../scenes/mod.rs"]
mod scenes;

mod assembly;
mod closed_forms;
mod flat;
mod joints;
mod left_out;
mod loops;
mod massless;
mod massless_coordinates;
mod natural_coordinates;
mod redundant;
