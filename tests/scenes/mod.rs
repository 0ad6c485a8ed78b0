//! Scenes that several test files, benchmarks and programs share.
#![allow(dead_code)]

pub mod assembly;
pub mod by_hand;
pub mod elements;
pub mod formulas;
pub mod mechanisms;
pub mod pairs;
pub mod pantograph;
pub mod pieces;
pub mod points;
pub mod ready_parts;
pub mod relative;
pub mod resolved;
pub mod seven_bodies;
pub mod sled;
pub mod strings;
pub mod structures;
pub mod varying;
