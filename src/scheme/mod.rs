//! Schemes: tables, the known part of a node problem, and its transpose in the adjoint equations.
//!
//! Stage s of a step of length Δt from node n is at t_n + c_s Δt, and with ẋ = (v, ṗ*) for x = (q, p*)
//!
//! ```text
//!   x_s = x̄ + h ẋ_s,     h = Δt a_ss,     x̄ = x_n + Δt Σ_{j<s} a_sj ẋ_j        (stage 0: node n; the last stage: node n + 1)
//! ```
//!
//! Only (x̄, h) depends on the scheme; the remaining problem is the same for all schemes (`node/`). The transposed equations carry the adjoint
//! variables a_s and b_s back to node n as
//!
//! ```text
//!   A = Σ a_r,    α = Δt Σ a_r0 a_r,        and to stage s > 0:   A = 0,    α = Δt Σ_{r>s} a_rs a_r        (B, β with b_r)
//! ```

mod estimate;
mod parts;
mod table;
mod tables;

pub(crate) use estimate::local_error;
pub(crate) use parts::{Carried, StageAdjoint, carried_part, known_part};
pub use table::Scheme;
