//! Verification of derivatives: hand-derived blocks and gradients against independent references.
//!
//! | hand-derived quantity | check |
//! |---|---|
//! | Φ_q, (Φ_q v)_q, (Φ_qᵀσ)_q, … of a constraint | [`constraint`] |
//! | M, T_q, (M v)_q, … | [`kinetic_energy`] |
//! | V_q, V_qq, … | [`potential_energy`] |
//! | Q_q, Q_v, Q_u, Q_b, … | [`force`] |
//! | h_q, h_u, S_q, … | [`cost`] |
//! | a block of ∂f_i/∂y_i, ∂f_i/∂y_{i−1}, ∂f_i/∂u_i (Eq. 10), or f_i itself | [`step`](step()) |
//! | the Jacobian or the values of any other function | [`function`](function()) |
//! | a gradient dJ/du, dJ/db, …; or that of the library | [`gradient`](gradient()) |
//! | a product of the Hessian with a direction; or that of the library | [`hessian`](hessian()) |
//!
//! With the feature `files`, derivatives may come from a program in another language, line by line (`Pipe`) or in a file (`Answers`).
//!
//! Each check compares at random points over decades of magnitude, and at points that show every branch and narrow feature of the
//! formula. The references are dual numbers, complex step and central differences with Ridders' extrapolation. The result is a report:
//! `println!("{report}")` for people, its fields for machines, `report.assert_passed()` for tests. Errors are relative to the sizes of their
//! row and column at the point, so units do not matter. `docs/checking-derivatives.md` describes which mistakes each check can find.

mod agreement;
#[cfg(feature = "files")]
mod arguments;
mod block;
mod compare;
mod derivative;
mod diagnosis;
mod direct;
mod draw;
mod element;
mod features;
mod formula;
mod function;
mod gradient;
mod matrix;
#[cfg(feature = "files")]
mod pipe;
mod place;
mod plan;
mod point;
mod reference;
mod report;
mod ridders;
mod scale;
mod search;
mod setting;
mod step;
#[cfg(feature = "files")]
mod worksheet;

pub use crate::number::Random;
#[cfg(feature = "files")]
pub use arguments::Arguments;
pub use derivative::{Input, central_differences, complex_step, tangent};
pub use direct::{Sensitivity, direct_differentiation};
pub use element::{ElementCheck, constraint, cost, force, kinetic_energy, potential_energy};
pub use formula::Function;
pub use function::{FunctionCheck, function};
pub use gradient::{
    DirectionReport, GradientCheck, GradientReport, HessianCheck, HessianReport, HessianRow, Identity, Part, Remainder,
    Taylor, gradient, hessian,
};
pub use matrix::Matrix;
#[cfg(feature = "files")]
pub use pipe::Pipe;
pub use point::Point;
pub use report::{BlockReport, Diagnosis, Entry, Mistake, Report, Verdict};
pub use step::{State, StepCheck, StepPoint, Terms, step};
#[cfg(feature = "files")]
pub use worksheet::Answers;
