//! The number types: model code uses [`Scalar`], and simulations run with [`Real`](super::real::Real).

use nalgebra::{SMatrix, Scalar as MatrixEntry};
use num_dual::DualNum;
use num_traits::{One, Zero};
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use super::boundary;

/// The arithmetic of a number with itself and with constants.
pub trait Arithmetic<Rhs = Self>:
    Sized
    + Add<Rhs, Output = Self>
    + Sub<Rhs, Output = Self>
    + Mul<Rhs, Output = Self>
    + Div<Rhs, Output = Self>
    + AddAssign<Rhs>
    + SubAssign<Rhs>
    + MulAssign<Rhs>
    + DivAssign<Rhs>
{
}

impl<T, Rhs> Arithmetic<Rhs> for T where
    T: Add<Rhs, Output = T>
        + Sub<Rhs, Output = T>
        + Mul<Rhs, Output = T>
        + Div<Rhs, Output = T>
        + AddAssign<Rhs>
        + SubAssign<Rhs>
        + MulAssign<Rhs>
        + DivAssign<Rhs>
{
}

/// A number in a model formula: a real value, possibly with derivatives or an imaginary part.
///
/// A model formula is written once, `fn phi<S: Scalar>(…)`, and evaluated with
///
/// | type | for |
/// |---|---|
/// | `f64` | values |
/// | num-dual's dual numbers (`DualSVec64<N>`, `Dual2SVec<…>`, …) | Jacobian blocks |
/// | [`Cx`](crate::Cx), alone or inside a dual number | complex step |
/// | a number type that records the operations | the programs to which a scene is compiled |
///
/// Scale a vector by a number of its own type: `vector * S::from(0.3)`.
///
/// A `Scalar` has the arithmetic operators (constants on the right: `x * 2.0`, not `2.0 * x`) and the functions below. It is deliberately not
/// a nalgebra `ComplexField`: `norm`, `dotc` and `adjoint` conjugate or take absolute values, which would invalidate a complex step, so
/// they do not compile in a formula; `dot`, `+`, `*` and `transpose` do.
pub trait Scalar:
    MatrixEntry + Copy + Zero + One + Sum + From<f64> + Neg<Output = Self> + Arithmetic + Arithmetic<f64>
{
    /// The real value, without derivatives: for branching and diagnostics only.
    ///
    /// A formula that computes with this value loses its derivative.
    fn re(&self) -> f64;
    /// 1/x.
    fn recip(&self) -> Self;
    /// xⁿ for an integer n.
    fn powi(&self, n: i32) -> Self;
    /// xⁿ for a real constant n; x ≥ 0 unless n is an integer. At x = 0 the derivatives of order below n exist.
    fn powf(&self, n: f64) -> Self;
    /// √x, with an infinite derivative at 0.
    fn sqrt(&self) -> Self;
    /// eˣ.
    fn exp(&self) -> Self;
    /// eˣ − 1 without cancellation near 0.
    fn exp_m1(&self) -> Self;
    /// The natural logarithm.
    fn ln(&self) -> Self;
    /// ln(1 + x) without cancellation near 0.
    fn ln_1p(&self) -> Self;
    /// Sine and cosine together.
    fn sin_cos(&self) -> (Self, Self);
    /// Sine.
    fn sin(&self) -> Self;
    /// Cosine.
    fn cos(&self) -> Self;
    /// Tangent.
    fn tan(&self) -> Self;
    /// Arcsine, |x| ≤ 1, with an infinite derivative at ±1.
    fn asin(&self) -> Self;
    /// Arccosine, |x| ≤ 1, with an infinite derivative at ±1.
    fn acos(&self) -> Self;
    /// Arctangent.
    fn atan(&self) -> Self;
    /// Hyperbolic sine.
    fn sinh(&self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(&self) -> Self;

    /// Hyperbolic tangent, finite for every x.
    fn tanh(&self) -> Self {
        // num-dual's sinh/cosh is ∞/∞ for large x; e^(−2|x|) never overflows.
        let negative = self.re() < 0.0;
        let x = if negative { -*self } else { *self };
        let e = (x * -2.0).exp_m1();
        let t = -e / (e + 2.0);
        if negative { -t } else { t }
    }

    /// The angle of the point (x, y), where `self` is y; exact derivatives in all four quadrants.
    fn atan2(&self, x: Self) -> Self {
        use std::f64::consts::{FRAC_PI_2, PI};
        let y = *self;
        if x.re() == 0.0 && y.re() == 0.0 {
            // At the origin neither the angle nor the distance has a derivative. Subtracting the distance keeps an angle of −0.
            return -(-y.hypot(x) - y.re().atan2(x.re()));
        }
        if x.re().is_infinite() && y.re().is_infinite() {
            return Self::from(y.re().atan2(x.re()));
        }
        // Divides by the larger of the two, so that x = 0 is an ordinary point.
        if x.re().abs() >= y.re().abs() {
            let turn = if x.re() >= 0.0 { -0.0 } else { PI.copysign(y.re()) };
            (y / x).atan() + turn
        } else {
            -(x / y).atan() + FRAC_PI_2.copysign(y.re())
        }
    }

    /// |x| by the sign of the real value; |−0| is 0.
    fn abs(&self) -> Self {
        if self.re() < 0.0 { -*self } else { *self + 0.0 }
    }

    /// The larger of two numbers, compared by their real values; `self` if either is NaN.
    fn max(&self, other: Self) -> Self {
        if other.re() > self.re() { other } else { *self }
    }

    /// The smaller of two numbers, compared by their real values; `self` if either is NaN.
    fn min(&self, other: Self) -> Self {
        if other.re() < self.re() { other } else { *self }
    }

    /// `x` if `self` is less than `other`, and `y` otherwise: a branch of which both sides are recorded, so that the formula is compiled to a program.
    /// The derivatives are those of the side that is taken.
    fn if_less(&self, other: Self, x: Self, y: Self) -> Self {
        let less = self.less(other);
        less.keep_where(x) + (Self::one() - less).keep_where(y)
    }

    /// 1 if `self` is less than `other`, and 0 otherwise; the derivative is zero.
    fn less(&self, other: Self) -> Self {
        Self::from(if self.re() < other.re() { 1.0 } else { 0.0 })
    }

    /// `x` if the condition `self` is not 0, and 0 otherwise, whatever `x` is.
    fn keep_where(&self, x: Self) -> Self {
        if self.re() == 0.0 { Self::zero() } else { x }
    }

    /// The number limited to an interval, `x.clamp(-1.0, 1.0)`. The derivative is that of x inside and at the bounds, and that of the bound
    /// outside. If the upper bound is below the lower one, the result is the upper bound.
    fn clamp(&self, low: impl Into<Self>, high: impl Into<Self>) -> Self {
        self.max(low.into()).min(high.into())
    }

    /// −1 for negative real values and 1 otherwise, also at ±0; the derivative is zero.
    fn signum(&self) -> Self {
        Self::from(if self.re() < 0.0 { -1.0 } else { 1.0 })
    }

    /// xⁿ for a variable exponent n, x > 0; use [`powf`](Self::powf) for a constant one.
    fn pow(&self, n: Self) -> Self {
        (self.ln() * n).exp()
    }

    /// The matrix R of a rotation by this angle (rad) in the plane: `phi.rotation() * s` is the vector s of a body's frame in the inertial frame.
    fn rotation(&self) -> SMatrix<Self, 2, 2> {
        let (sin, cos) = self.sin_cos();
        SMatrix::from([[cos, sin], [-sin, cos]])
    }

    /// √(x² + y²), not differentiable at the origin.
    fn hypot(&self, y: Self) -> Self {
        (*self * *self + y * y).sqrt()
    }
}

impl<T: DualNum<Primitive = f64> + Copy> Scalar for T {
    #[inline]
    fn re(&self) -> f64 {
        num_dual::DualStruct::re(self)
    }
    #[inline]
    fn recip(&self) -> Self {
        DualNum::recip(self)
    }
    #[inline]
    fn powi(&self, n: i32) -> Self {
        let re = Scalar::re(self);
        let is_plain = T::NDERIV == 0 || (0..=3).contains(&n) || boundary::is_in_range(re, f64::from(n), T::NDERIV);
        if is_plain || n > 0 && (re == 0.0 || !re.is_finite()) {
            return DualNum::powi(self, n);
        }
        boundary::powi_out_of_range(self, re, n)
    }
    #[inline]
    fn powf(&self, n: f64) -> Self {
        let re = Scalar::re(self);
        if T::NDERIV == 0 || n == 0.0 || re.is_finite() && re != 0.0 && boundary::is_in_range(re, n, T::NDERIV) {
            DualNum::powf(self, n)
        } else if n.fract() == 0.0 && n.abs() <= f64::from(i32::MAX) {
            Scalar::powi(self, n as i32)
        } else if re == 0.0 {
            // All functions that are infinite at 0 have the same derivatives there.
            let x = Scalar::abs(self);
            if n > 0.0 { boundary::power_of_zero(&x, n) } else { Scalar::recip(&x) }
        } else if re.is_finite() {
            boundary::powf_out_of_range(self, re, n)
        } else {
            (Scalar::abs(self).ln() * n).exp()
        }
    }
    #[inline]
    fn sqrt(&self) -> Self {
        let re = Scalar::re(self);
        if T::NDERIV == 0 || re != 0.0 {
            return DualNum::sqrt(self);
        }
        let root = boundary::sqrt_of_zero(self);
        // √−0 = −0.
        if re.is_sign_negative() { -(T::zero() - root) } else { root }
    }
    #[inline]
    fn exp(&self) -> Self {
        DualNum::exp(self)
    }
    #[inline]
    fn exp_m1(&self) -> Self {
        DualNum::exp_m1(self)
    }
    #[inline]
    fn ln(&self) -> Self {
        DualNum::ln(self)
    }
    #[inline]
    fn ln_1p(&self) -> Self {
        DualNum::ln_1p(self)
    }
    #[inline]
    fn sin_cos(&self) -> (Self, Self) {
        DualNum::sin_cos(self)
    }
    #[inline]
    fn sin(&self) -> Self {
        DualNum::sin(self)
    }
    #[inline]
    fn cos(&self) -> Self {
        DualNum::cos(self)
    }
    #[inline]
    fn tan(&self) -> Self {
        DualNum::tan(self)
    }
    #[inline]
    fn asin(&self) -> Self {
        DualNum::asin(self)
    }
    #[inline]
    fn acos(&self) -> Self {
        DualNum::acos(self)
    }
    #[inline]
    fn atan(&self) -> Self {
        DualNum::atan(self)
    }
    #[inline]
    fn sinh(&self) -> Self {
        DualNum::sinh(self)
    }
    #[inline]
    fn cosh(&self) -> Self {
        DualNum::cosh(self)
    }
}
