//! Numbers that formulas run on: plain and complex ones, and those that find out what a formula depends on.

mod boundary;
mod complex;
mod fingerprint;
mod lanes;
mod real;
mod scalar;
mod sincos;
pub mod trace;

pub use complex::Cx;
pub(crate) use fingerprint::Fingerprint;
pub(crate) use lanes::{add, all_finite, dot, larger, largest};
pub use real::{Family, Real};
pub use scalar::{Arithmetic, Scalar};
pub(crate) use sincos::{Known, sin_cos_lanes};
