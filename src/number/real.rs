//! [`Real`]: the number types with which a whole simulation can be computed.

use num_dual::{Dual64, DualNum};

use super::{Cx, Hyper, Scalar, hyper, hyper_parts};

/// A family of values with one member for each [`Real`] number type.
#[doc(hidden)]
pub trait Family {
    type Of<R: Real>;
    fn real(self) -> Self::Of<f64>;
    fn complex(self) -> Self::Of<Cx>;
    fn dual(self) -> Self::Of<Dual64>;
    fn hyper(self) -> Self::Of<Hyper>;
}

/// A number type with which a whole simulation can be computed: `f64`, [`Cx`] (complex step), `Dual64` (tangent), or [`Hyper`] (two
/// tangents and the mixed second derivative).
///
/// A `Real` can be nested in num-dual's types, since the residual of a step contains derivatives itself. The matrix of Newton's method is always
/// real. The same factors are used for the real part and all derivative parts, because the matrix determines only how fast the iteration
/// converges, not its limit.
pub trait Real: DualNum<Primitive = f64> + Copy + Scalar + Send + Sync {
    /// Number of real numbers of which a value consists.
    const PARTS: usize;
    /// Part `k`: 0 is the real value, 1 the imaginary or derivative part. For hyper-dual numbers, 1 and 2 are the derivatives along the two
    /// directions, and 3 is the mixed one.
    fn part(&self, k: usize) -> f64;
    /// Adds `x` to part `k`.
    fn add_to_part(&mut self, k: usize, x: f64);
    /// The member of a family for this type.
    #[doc(hidden)]
    fn of<F: Family>(family: F) -> F::Of<Self>;
}

impl Real for f64 {
    const PARTS: usize = 1;
    #[inline]
    fn part(&self, _: usize) -> f64 {
        *self
    }
    #[inline]
    fn add_to_part(&mut self, _: usize, x: f64) {
        *self += x;
    }
    fn of<F: Family>(family: F) -> F::Of<Self> {
        family.real()
    }
}

impl Real for Cx {
    const PARTS: usize = 2;
    fn part(&self, k: usize) -> f64 {
        if k == 0 { self.0.re } else { self.0.im }
    }
    fn add_to_part(&mut self, k: usize, x: f64) {
        *(if k == 0 { &mut self.0.re } else { &mut self.0.im }) += x;
    }
    fn of<F: Family>(family: F) -> F::Of<Self> {
        family.complex()
    }
}

impl Real for Dual64 {
    const PARTS: usize = 2;
    fn part(&self, k: usize) -> f64 {
        if k == 0 { self.re } else { self.eps }
    }
    fn add_to_part(&mut self, k: usize, x: f64) {
        *(if k == 0 { &mut self.re } else { &mut self.eps }) += x;
    }
    fn of<F: Family>(family: F) -> F::Of<Self> {
        family.dual()
    }
}

impl Real for Hyper {
    const PARTS: usize = 4;
    fn part(&self, k: usize) -> f64 {
        hyper_parts(self)[k]
    }
    fn add_to_part(&mut self, k: usize, x: f64) {
        let mut parts = hyper_parts(self);
        parts[k] += x;
        let [re, eps1, eps2, mixed] = parts;
        *self = hyper(re, eps1, eps2, mixed);
    }
    fn of<F: Family>(family: F) -> F::Of<Self> {
        family.hyper()
    }
}
