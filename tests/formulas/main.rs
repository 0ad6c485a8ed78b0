//! Recorded formulas: what they say is constant, absent or sparse is so, and what needs no evaluation is not evaluated.

#[path = "../common/files.rs"]
mod files;
#[path = "../scenes/mod.rs"]
mod scenes;

mod calls;
mod deep;
mod skipped;
mod structure;
mod work;
