//! [`Cx`]: a complex number that can be used like a dual number, also inside one.

use num_complex::Complex64;
use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use std::cmp::Ordering;
use std::f64::consts::{LN_2, LN_10};
use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

/// A complex number for the complex step, f′(x) = Im f(x + i h)/h with h ≈ 1e-30.
///
/// Comparisons use the real part, as in num-dual. The real part of every result is what `f64` computes from the real parts alone, without
/// the terms of order h²: a formula takes the same branch as for real numbers, also if values are infinite or NaN. The imaginary part is
/// that of the complex function, by formulas that are accurate for tiny imaginary parts (atan, asin, acos) and do not overflow (tanh). A
/// function of a number without an imaginary part has none either.
#[derive(Clone, Copy, Debug)]
pub struct Cx(pub Complex64);

impl Cx {
    /// re + i im.
    pub fn new(re: f64, im: f64) -> Self {
        Cx(Complex64::new(re, im))
    }

    /// The value of a function from its real and imaginary parts; the latter is not computed if the argument has none or the value is NaN.
    fn function(self, re: f64, im: impl FnOnce(Complex64) -> f64) -> Self {
        Cx::new(re, if self.0.im == 0.0 || re.is_nan() { part(re, self.0.im) } else { im(self.0) })
    }
}

/// x y for an imaginary part y; zero if y is zero.
#[inline]
fn part(x: f64, y: f64) -> f64 {
    if y == 0.0 { 0.0 } else { x * y }
}

/// If the slope vanishes, the imaginary part is of order h²: the root of such a product has no derivative, unlike that of a constant.
fn product(x: Complex64, y: Complex64) -> Complex64 {
    let im = part(x.re, y.im) + part(y.re, x.im);
    Complex64::new(x.re * y.re, if im == 0.0 { x.im * y.im } else { im })
}

fn quotient(x: Complex64, y: Complex64) -> Complex64 {
    let re = x.re / y.re;
    let im = x.im - part(re, y.im);
    Complex64::new(re, if im == 0.0 { 0.0 } else { im / y.re })
}

fn remainder(x: Complex64, y: Complex64) -> Complex64 {
    Complex64::new(x.re % y.re, x.im - part((x.re / y.re).trunc(), y.im))
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident $function:expr;)*) => {$(
        impl $operator for Cx {
            type Output = Cx;
            #[inline]
            fn $method(self, other: Cx) -> Cx { Cx($function(self.0, other.0)) }
        }
        impl $operator<&Cx> for Cx {
            type Output = Cx;
            #[inline]
            fn $method(self, other: &Cx) -> Cx { self.$method(*other) }
        }
        impl $operator<f64> for Cx {
            type Output = Cx;
            #[inline]
            fn $method(self, other: f64) -> Cx { self.$method(Cx::from(other)) }
        }
        impl $assign for Cx {
            #[inline]
            fn $assign_method(&mut self, other: Cx) { *self = self.$method(other); }
        }
        impl $assign<f64> for Cx {
            #[inline]
            fn $assign_method(&mut self, other: f64) { *self = self.$method(other); }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign Complex64::add;
    Sub sub SubAssign sub_assign Complex64::sub;
    Mul mul MulAssign mul_assign product;
    Div div DivAssign div_assign quotient;
    Rem rem RemAssign rem_assign remainder;
}

impl Neg for Cx {
    type Output = Cx;
    #[inline]
    fn neg(self) -> Cx {
        Cx(-self.0)
    }
}

impl Zero for Cx {
    fn zero() -> Self {
        Cx::new(0.0, 0.0)
    }
    fn is_zero(&self) -> bool {
        self.0.is_zero()
    }
}

impl One for Cx {
    fn one() -> Self {
        Cx::new(1.0, 0.0)
    }
}

impl Num for Cx {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Cx::from)
    }
}

impl Signed for Cx {
    fn abs(&self) -> Self {
        if self.0.re < 0.0 { -*self } else { *self }
    }
    fn abs_sub(&self, other: &Self) -> Self {
        if self > other { *self - *other } else { Cx::zero() }
    }
    fn signum(&self) -> Self {
        Cx::from(self.0.re.signum())
    }
    fn is_positive(&self) -> bool {
        self.0.re > 0.0
    }
    fn is_negative(&self) -> bool {
        self.0.re < 0.0
    }
}

impl Inv for Cx {
    type Output = Cx;
    fn inv(self) -> Cx {
        Cx::one() / self
    }
}

impl Sum for Cx {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Cx::zero(), Add::add)
    }
}

impl Product for Cx {
    fn product<I: Iterator<Item = Self>>(factors: I) -> Self {
        factors.fold(Cx::one(), Mul::mul)
    }
}

impl From<f64> for Cx {
    #[inline]
    fn from(re: f64) -> Self {
        Cx::new(re, 0.0)
    }
}

impl FromPrimitive for Cx {
    fn from_i64(n: i64) -> Option<Self> {
        f64::from_i64(n).map(Cx::from)
    }
    fn from_u64(n: u64) -> Option<Self> {
        f64::from_u64(n).map(Cx::from)
    }
    fn from_f64(x: f64) -> Option<Self> {
        Some(Cx::from(x))
    }
}

impl PartialEq for Cx {
    fn eq(&self, other: &Self) -> bool {
        self.0.re == other.0.re
    }
}

impl PartialEq<f64> for Cx {
    fn eq(&self, other: &f64) -> bool {
        self.0.re == *other
    }
}

impl PartialOrd for Cx {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.0.re.partial_cmp(&other.0.re)
    }
}

impl PartialOrd<f64> for Cx {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.0.re.partial_cmp(other)
    }
}

impl fmt::Display for Cx {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl DualStruct for Cx {
    type Real = f64;
    type Inner = f64;
    fn re(&self) -> f64 {
        self.0.re
    }
    fn from_inner(inner: &f64) -> Self {
        Cx::from(*inner)
    }
}

impl Mappable<Cx> for Cx {
    type Output<O> = O;
    fn map_dual<M: FnOnce(Cx) -> O, O>(self, f: M) -> O {
        f(self)
    }
}

/// Im ln(1 + z).
fn ln_1p(z: Complex64) -> f64 {
    z.im.atan2(1.0 + z.re)
}

/// Im atan z = ¼ ln(|z + i|²/|z − i|²) by ln_1p, which keeps a tiny Im z to all digits.
fn atan(z: Complex64) -> f64 {
    0.25 * (4.0 * z.im / (z.re * z.re + (1.0 - z.im) * (1.0 - z.im))).ln_1p()
}

/// Im asin z by asin z = atan(z/√(1 − z²)); num-complex's formula cancels.
fn asin(z: Complex64) -> f64 {
    atan(z / ((1.0 - z) * (1.0 + z)).sqrt())
}

/// Im tanh z = v (1 − t²)/(1 + t² v²) with t = tanh x, v = tan y: finite for every real part.
fn tanh(z: Complex64) -> f64 {
    let (t, v) = (z.re.tanh(), z.im.tan());
    v * (1.0 - t * t) / (1.0 + t * t * v * v)
}

impl DualNum for Cx {
    type Primitive = f64;
    const NDERIV: usize = 0;
    type InnerDual = f64;

    fn from_re(re: f64) -> Self {
        Cx::from(re)
    }
    fn scale(self, factor: &f64) -> Self {
        self * *factor
    }
    fn recip(&self) -> Self {
        self.inv()
    }
    fn powi(&self, n: i32) -> Self {
        self.function(self.0.re.powi(n), |z| if z.re == 0.0 && n > 1 { z.im.powi(n) } else { z.powi(n).im })
    }
    fn powf(&self, n: f64) -> Self {
        // In polar form the rounding error of the angle of a negative number would exceed a complex step by far.
        self.function(self.0.re.powf(n), |z| if z.re < 0.0 { z.powi(n as i32).im } else { z.powf(n).im })
    }
    fn sqrt(&self) -> Self {
        let re = self.0.re.sqrt();
        self.function(re, |z| z.im / (2.0 * re))
    }
    fn cbrt(&self) -> Self {
        // The real branch: num-complex returns the principal root of a negative number.
        self.function(self.0.re.cbrt(), |z| if z.re < 0.0 { -(-z).cbrt().im } else { z.cbrt().im })
    }
    fn exp(&self) -> Self {
        let re = self.0.re.exp();
        self.function(re, |z| re * z.im.sin())
    }
    fn exp2(&self) -> Self {
        let re = self.0.re.exp2();
        self.function(re, |z| re * (z.im * LN_2).sin())
    }
    fn exp_m1(&self) -> Self {
        self.function(self.0.re.exp_m1(), |z| z.re.exp() * z.im.sin())
    }
    fn ln(&self) -> Self {
        self.function(self.0.re.ln(), Complex64::arg)
    }
    fn log(&self, base: f64) -> Self {
        self.function(self.0.re.log(base), |z| z.arg() / base.ln())
    }
    fn log2(&self) -> Self {
        self.function(self.0.re.log2(), |z| z.arg() / LN_2)
    }
    fn log10(&self) -> Self {
        self.function(self.0.re.log10(), |z| z.arg() / LN_10)
    }
    fn ln_1p(&self) -> Self {
        self.function(self.0.re.ln_1p(), ln_1p)
    }
    fn sin(&self) -> Self {
        self.sin_cos().0
    }
    fn cos(&self) -> Self {
        self.sin_cos().1
    }
    fn tan(&self) -> Self {
        let (sin, cos) = self.sin_cos();
        self.function(self.0.re.tan(), |_| (sin / cos).0.im)
    }
    fn sin_cos(&self) -> (Self, Self) {
        let (sin, cos) = self.0.re.sin_cos();
        (self.function(sin, |z| cos * z.im.sinh()), self.function(cos, |z| -sin * z.im.sinh()))
    }
    fn asin(&self) -> Self {
        self.function(self.0.re.asin(), asin)
    }
    fn acos(&self) -> Self {
        self.function(self.0.re.acos(), |z| -asin(z))
    }
    fn atan(&self) -> Self {
        self.function(self.0.re.atan(), atan)
    }
    fn atan2(&self, x: Self) -> Self {
        crate::Scalar::atan2(self, x)
    }
    fn sinh(&self) -> Self {
        self.function(self.0.re.sinh(), |z| z.re.cosh() * z.im.sin())
    }
    fn cosh(&self) -> Self {
        self.function(self.0.re.cosh(), |z| z.re.sinh() * z.im.sin())
    }
    fn tanh(&self) -> Self {
        self.function(self.0.re.tanh(), tanh)
    }
    fn asinh(&self) -> Self {
        // Odd, and without cancellation on the positive side: ln(1 + x + x²/(1 + √(1 + x²))).
        let positive = |x: Complex64| ln_1p(x + x * x / (1.0 + (1.0 + x * x).sqrt()));
        self.function(self.0.re.asinh(), |z| if z.re < 0.0 { -positive(-z) } else { positive(z) })
    }
    fn acosh(&self) -> Self {
        self.function(self.0.re.acosh(), |z| (z + ((z - 1.0) * (z + 1.0)).sqrt()).arg())
    }
    fn atanh(&self) -> Self {
        self.function(self.0.re.atanh(), |z| 0.5 * (ln_1p(z) - ln_1p(-z)))
    }
    fn sph_j0(&self) -> Self {
        let value = if self.0.norm() < 1e-4 { Cx(1.0 - self.0 * self.0 / 6.0) } else { self.sin() / *self };
        self.function(self.0.re.sph_j0(), |_| value.0.im)
    }
    fn sph_j1(&self) -> Self {
        let (s, c) = self.sin_cos();
        let value = if self.0.norm() < 1e-4 { Cx(self.0 / 3.0) } else { (s / *self - c) / *self };
        self.function(self.0.re.sph_j1(), |_| value.0.im)
    }
    fn sph_j2(&self) -> Self {
        let value = self.sph_j1() * 3.0 / *self - self.sph_j0();
        self.function(self.0.re.sph_j2(), |_| value.0.im)
    }
}
