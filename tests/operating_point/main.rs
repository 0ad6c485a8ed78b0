//! The linearised motion about a state, and equilibria.

#[path = "../common/mod.rs"]
mod common;

mod cases;
mod equilibrium;
mod held;
mod inverse;
mod linear;
mod refused;
mod relative_degree;
mod stability;
