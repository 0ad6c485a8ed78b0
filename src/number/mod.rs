//! Number types for formulas: plain and complex numbers, and types that detect on what a formula depends.

mod boundary;
mod branch_detection;
mod complex;
mod exp;
mod fingerprint;
mod hyper;
mod lanes;
mod random;
mod real;
mod scalar;
mod sincos;
mod strided;

pub(crate) use branch_detection::{guarded, note_look, take_look};
pub use complex::Cx;
pub(crate) use exp::exp_lanes;
pub(crate) use fingerprint::Fingerprint;
pub use hyper::Hyper;
pub(crate) use hyper::{Slope, hyper, hyper_parts, slope, with_slope};
pub(crate) use lanes::{
    add, add_dot, all_finite, by_fours, copy_singly, dot, larger, largest, minus_product, plus_product, singly, take, total,
};
pub use random::Random;
pub use real::{Family, Real};
pub use scalar::{Arithmetic, Scalar};
pub(crate) use sincos::{Known, sin_cos_lanes};
pub(crate) use strided::{Strided, StridedDifference};
