//! Public functions and command lines with good and bad input, and the structure of the library.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod circles;
mod cli;
mod clones;
mod public;
mod rooms;
mod sources;
