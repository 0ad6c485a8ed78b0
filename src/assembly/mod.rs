//! The assembly of a start: from a guess q̂, v̂ and held coordinates and velocities to q₀ = q̂ + w and v₀ that satisfy all constraints.
//!
//! ```text
//!   𝓛_v(q₀, w, ν) − 𝓛_v(q₀, 0, 0) + E κ = 0      Φ(q₀, t₀) = 0             Eᵀ w = 0
//!   𝓛_v(q₀, v₀, μ) − 𝓛_v(q₀, v̂, 0) + E κ = 0     dΦ/dt(q₀, v₀, t₀) = 0     Eᵀ (v₀ − v̂) = 0
//! ```
//!
//! E selects held coordinates. Without it w and v₀ − v̂ are the smallest changes in the metric of M. Newton's method solves both systems; its matrix
//! is K(0) = [𝓛_vv Φ_qᵀ; Φ_q 0] bordered by E and, for w, a term that grows with w ([`Tangent`]). Far from the guess, other steps lead to a point
//! from which it converges (`far.rs`). Constraints that depend on each other get a small compliance in K(0), not in the equations.
//! `adjoint/assembly.rs` differentiates the solution, and `adjoint/second_order/assembly.rs` differentiates it twice.

mod assembler;
mod bordered;
mod coordinates;
mod equations;
mod far;
mod retraction;
mod tangent;

pub(crate) use assembler::{Assembler, factor_state};
pub(crate) use retraction::{Columns, Retraction};
pub(crate) use tangent::Tangent;
