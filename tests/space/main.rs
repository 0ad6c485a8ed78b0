//! Rigid bodies in space: trees in the coordinates of their joints.

#[path = "../common/mod.rs"]
mod common;

mod axis;
mod bad_input;
mod cuts;
#[path = "../scenes/hinges.rs"]
mod hinges;
mod markers;
mod planar_loops;
mod random;
mod trees;
mod truth;
