//! Elements: ready ones and a user's own, their parameters, and what holds at one state.

#[path = "../common/mod.rs"]
mod common;
#[path = "../scenes/mod.rs"]
mod scenes;

mod bad_models;
mod contacts;
mod edges;
mod forces;
mod friction;
mod lists;
mod mass_matrix;
mod mechanics;
mod parameters;
mod parts;
mod scalar;
