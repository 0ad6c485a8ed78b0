//! Numbers with one derivative, and hyper-dual numbers: derivatives along two directions and the mixed one.

use nalgebra::SVector;
use num_dual::{Derivative, DualSVec, DualSVec64};

/// A number with one derivative or with none. num-dual's `Dual64` cannot distinguish a zero derivative from an absent one, but the
/// difference matters: the square root of a constant zero has the derivative zero, while the square root of a variable that happens to be
/// zero has no finite derivative.
pub type Slope = DualSVec64<1>;

/// A number with a derivative; a zero derivative counts as absent.
pub fn with_slope(re: f64, slope: f64) -> Slope {
    Slope::new(re, if slope == 0.0 { Derivative::none() } else { Derivative::some(SVector::from([slope])) })
}

/// The derivative of a number, zero if absent.
#[inline]
pub fn slope(x: &Slope) -> f64 {
    x.eps.0.map_or(0.0, |eps| eps[0])
}

/// A hyper-dual number: a value, the derivatives along two directions and the mixed second derivative (ε₁ belongs to the inner dual number,
/// ε₂ to the outer).
///
/// Create one with `Hyper::from(x)` and [`Real::add_to_part`](crate::Real::add_to_part), and read it with
/// [`Real::part`](crate::Real::part):
///
/// ```
/// use hamiltonian_adjoint::{Hyper, Real, Scalar};
///
/// let (mut x, mut y) = (Hyper::from(2.0), Hyper::from(0.5));
/// x.add_to_part(1, 1.0);
/// y.add_to_part(2, 1.0);
/// let product = x * x * Scalar::sin(&y);
/// assert!((product.part(3) - 2.0 * 2.0 * 0.5f64.cos()).abs() < 1e-15); // ∂²/∂x∂y
/// ```
pub type Hyper = DualSVec<Slope, 1>;

/// A hyper-dual number from its parts; zero derivatives count as absent.
pub fn hyper(re: f64, eps1: f64, eps2: f64, eps1eps2: f64) -> Hyper {
    let is_none = eps2 == 0.0 && eps1eps2 == 0.0;
    let eps = if is_none { Derivative::none() } else { Derivative::some(SVector::from([with_slope(eps2, eps1eps2)])) };
    Hyper::new(with_slope(re, eps1), eps)
}

/// The value and the derivatives along ε₁, ε₂ and both.
#[inline]
pub fn hyper_parts(x: &Hyper) -> [f64; 4] {
    let [eps2, mixed] = x.eps.0.map_or([0.0; 2], |eps| [eps[0].re, slope(&eps[0])]);
    [x.re.re, slope(&x.re), eps2, mixed]
}
