//! [`Cx`]: a complex number that may stand wherever a dual number may, also inside one.

use num_complex::Complex64;
use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use std::cmp::Ordering;
use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

/// A complex number for the complex step, f′(x) = Im f(x + i h)/h with h ≈ 1e-30.
///
/// Comparisons use the real part, as in num-dual, so that a formula takes the same branch as for real numbers. Functions whose num-complex
/// version loses a tiny imaginary part (atan, asin, acos) or overflows (tanh) are replaced by formulas that do not. A function without a
/// real value (√x of x < 0) has no value here either.
#[derive(Clone, Copy, Debug)]
pub struct Cx(pub Complex64);

impl Cx {
    /// re + i im.
    pub fn new(re: f64, im: f64) -> Self {
        Cx(Complex64::new(re, im))
    }

    /// This, but not a number where the real function has no value: a formula may choose between numbers by that.
    fn unless(self, is_undefined: bool) -> Self {
        if is_undefined { Cx::new(f64::NAN, f64::NAN) } else { self }
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident;)*) => {$(
        impl $operator for Cx {
            type Output = Cx;
            #[inline]
            fn $method(self, other: Cx) -> Cx { Cx(self.0.$method(other.0)) }
        }
        impl $operator<&Cx> for Cx {
            type Output = Cx;
            #[inline]
            fn $method(self, other: &Cx) -> Cx { Cx(self.0.$method(other.0)) }
        }
        impl $operator<f64> for Cx {
            type Output = Cx;
            #[inline]
            fn $method(self, other: f64) -> Cx { Cx(self.0.$method(other)) }
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
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
    Rem rem RemAssign rem_assign;
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
        Cx(self.0.inv())
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

/// ln(1 + z), accurate where |z| is small: the real part by ln|1 + z|² = ln_1p(2x + x² + y²).
fn ln_1p(z: Complex64) -> Complex64 {
    let (x, y) = (z.re, z.im);
    Complex64::new(0.5 * (2.0 * x + x * x + y * y).ln_1p(), y.atan2(1.0 + x))
}

/// eᶻ − 1 = e^x (cos y − 1 + i sin y) + (e^x − 1), with cos y − 1 = −2 sin²(y/2).
fn exp_m1(z: Complex64) -> Complex64 {
    let (growth, half) = (z.re.exp(), (0.5 * z.im).sin());
    Complex64::new(z.re.exp_m1() - growth * 2.0 * half * half, growth * z.im.sin())
}

/// atan z; the imaginary part ¼ ln(|z + i|²/|z − i|²) by ln_1p keeps a tiny Im z to all digits.
fn atan(z: Complex64) -> Complex64 {
    let (x, y) = (z.re, z.im);
    let below = x * x + (1.0 - y) * (1.0 - y);
    Complex64::new(0.5 * (2.0 * x).atan2((1.0 - y) * (1.0 + y) - x * x), 0.25 * (4.0 * y / below).ln_1p())
}

/// tanh z = (t (1 + v²) + i v (1 − t²))/(1 + t² v²) with t = tanh x, v = tan y: finite for every real part.
fn tanh(z: Complex64) -> Complex64 {
    let (t, v) = (z.re.tanh(), z.im.tan());
    Complex64::new(t * (1.0 + v * v), v * (1.0 - t * t)) / (1.0 + t * t * v * v)
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
        // Complex division by zero is NaN in both parts.
        if self.0.is_zero() { Cx::from(self.0.re.recip()) } else { Cx(self.0.inv()) }
    }
    fn powi(&self, n: i32) -> Self {
        Cx(self.0.powi(n))
    }
    fn powf(&self, n: f64) -> Self {
        // In polar form the angle of a negative number would be rounded, by far more than a complex step.
        if self.0.re < 0.0 && n.fract() == 0.0 && n.abs() <= f64::from(i32::MAX) {
            return self.powi(n as i32);
        }
        Cx(self.0.powf(n)).unless(self.0.re < 0.0)
    }
    fn sqrt(&self) -> Self {
        Cx(self.0.sqrt()).unless(self.0.re < 0.0)
    }
    fn cbrt(&self) -> Self {
        // The real branch, as f64's: num-complex returns the principal root of a negative number.
        if self.0.re < 0.0 { Cx(-(-self.0).cbrt()) } else { Cx(self.0.cbrt()) }
    }
    fn exp(&self) -> Self {
        Cx(self.0.exp())
    }
    fn exp2(&self) -> Self {
        Cx(self.0.exp2())
    }
    fn exp_m1(&self) -> Self {
        Cx(exp_m1(self.0))
    }
    fn ln(&self) -> Self {
        Cx(self.0.ln()).unless(self.0.re < 0.0)
    }
    fn log(&self, base: f64) -> Self {
        Cx(self.0.log(base)).unless(self.0.re < 0.0)
    }
    fn log2(&self) -> Self {
        Cx(self.0.log2()).unless(self.0.re < 0.0)
    }
    fn log10(&self) -> Self {
        Cx(self.0.log10()).unless(self.0.re < 0.0)
    }
    fn ln_1p(&self) -> Self {
        Cx(ln_1p(self.0)).unless(self.0.re < -1.0)
    }
    fn sin(&self) -> Self {
        Cx(self.0.sin())
    }
    fn cos(&self) -> Self {
        Cx(self.0.cos())
    }
    fn tan(&self) -> Self {
        self.sin() / self.cos()
    }
    fn sin_cos(&self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn asin(&self) -> Self {
        // asin z = atan(z/√(1 − z²)); num-complex's formula cancels.
        let z = self.0;
        if z.re.abs() == 1.0 && z.im == 0.0 {
            return Cx::from(z.re.asin());
        }
        Cx(atan(z / ((1.0 - z) * (1.0 + z)).sqrt())).unless(z.re.abs() > 1.0)
    }
    fn acos(&self) -> Self {
        -self.asin() + std::f64::consts::FRAC_PI_2
    }
    fn atan(&self) -> Self {
        Cx(atan(self.0))
    }
    fn atan2(&self, x: Self) -> Self {
        crate::Scalar::atan2(self, x)
    }
    fn sinh(&self) -> Self {
        Cx(self.0.sinh())
    }
    fn cosh(&self) -> Self {
        Cx(self.0.cosh())
    }
    fn tanh(&self) -> Self {
        Cx(tanh(self.0))
    }
    fn asinh(&self) -> Self {
        // Odd, and without cancellation on the positive side: ln(1 + x + x²/(1 + √(1 + x²))).
        let x = if self.0.re < 0.0 { -self.0 } else { self.0 };
        let y = ln_1p(x + x * x / (1.0 + (1.0 + x * x).sqrt()));
        Cx(if self.0.re < 0.0 { -y } else { y })
    }
    fn acosh(&self) -> Self {
        Cx((self.0 + ((self.0 - 1.0) * (self.0 + 1.0)).sqrt()).ln()).unless(self.0.re < 1.0)
    }
    fn atanh(&self) -> Self {
        Cx(0.5 * (ln_1p(self.0) - ln_1p(-self.0))).unless(self.0.re.abs() > 1.0)
    }
    fn sph_j0(&self) -> Self {
        if self.0.norm() < 1e-4 { Cx(1.0 - self.0 * self.0 / 6.0) } else { self.sin() / *self }
    }
    fn sph_j1(&self) -> Self {
        if self.0.norm() < 1e-4 {
            return Cx(self.0 / 3.0);
        }
        let (s, c) = self.sin_cos();
        (s / *self - c) / *self
    }
    fn sph_j2(&self) -> Self {
        self.sph_j1() * 3.0 / *self - self.sph_j0()
    }
}
