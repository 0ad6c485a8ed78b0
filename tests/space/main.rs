//! Rigid bodies in space: trees in the coordinates of their joints.

#[path = "../common/mod.rs"]
mod common;

mod axis;
mod markers;
mod trees;
mod truth;
