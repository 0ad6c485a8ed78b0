//! Prescribed motions of driven joints.

use nalgebra::SVector;

use crate::Scalar;

/// A prescribed function of time, in the unit of what it prescribes: rad, m, N, N m.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no motion with this many parameters",
    note = "implement `Motion<P>` with P the number of parameters that are given"
)]
pub trait Motion<const P: usize>: Send + Sync + 'static {
    /// The value at time t (s) for the parameters b.
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, P>) -> S;
}

/// The same at all times; `b = [value]`.
#[derive(Clone, Copy, Debug)]
pub struct Constant;

impl Motion<1> for Constant {
    fn value<S: Scalar>(&self, _t: S, b: &SVector<S, 1>) -> S {
        b[0]
    }
}

/// φ₀ + ω t, b = [φ₀, ω].
#[derive(Clone, Copy, Debug)]
pub struct ConstantSpeed;

impl Motion<2> for ConstantSpeed {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 2>) -> S {
        b[0] + b[1] * t
    }
}

/// φ₀ + A sin(ω t + ψ), b = [φ₀, A, ω, ψ].
#[derive(Clone, Copy, Debug)]
pub struct Harmonic;

impl Motion<4> for Harmonic {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 4>) -> S {
        b[0] + b[1] * (b[2] * t + b[3]).sin()
    }
}
