//! [`Fingerprint`]: a number type that records only how a number was computed, as a hash value.
//!
//! The results of compiling a scene are valid as long as its formulas do not change. A formula that reads something besides its arguments
//! (a static, a cell) may be different in the next run. Every run therefore evaluates the formulas with hash values of operations,
//! operands and constants: equal formulas have equal hash values, and different ones have different values.

use num_traits::{One, Zero};
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::Scalar;
use crate::number::note_look;

/// The hash value of an expression.
#[derive(Clone, Copy)]
pub struct Fingerprint(u64);

/// Odd, with random-looking digits: 2⁶⁴ over the golden ratio.
const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;

impl Fingerprint {
    /// The fingerprint of an empty list.
    pub const NONE: Fingerprint = Fingerprint(0);

    /// The fingerprint of the input with number `index`.
    pub fn input(index: usize) -> Self {
        Fingerprint(0x517c_c1b7_2722_0a95).then(index as u64)
    }

    /// Appends an expression to those joined so far.
    pub fn join(&mut self, other: Fingerprint) {
        *self = self.then(other.0);
    }

    /// The hash value, which also depends on whether the formula read the value of a number (`looked`).
    pub fn value(self, looked: bool) -> u64 {
        self.then(u64::from(looked)).0
    }

    #[inline]
    fn then(self, x: u64) -> Self {
        Fingerprint((self.0.rotate_left(23) ^ x).wrapping_mul(MULTIPLIER))
    }

    /// A function of one number.
    #[inline]
    fn function(self, which: u64) -> Self {
        self.then(which)
    }

    fn look(&self) -> f64 {
        note_look();
        0.0
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident $number:literal;)*) => {$(
        impl $operator for Fingerprint {
            type Output = Self;
            #[inline]
            fn $method(self, other: Self) -> Self { self.function($number).then(other.0) }
        }
        impl $operator<f64> for Fingerprint {
            type Output = Self;
            #[inline]
            fn $method(self, other: f64) -> Self { self.$method(Fingerprint::from(other)) }
        }
        impl $assign for Fingerprint {
            fn $assign_method(&mut self, other: Self) { *self = self.$method(other); }
        }
        impl $assign<f64> for Fingerprint {
            fn $assign_method(&mut self, other: f64) { *self = self.$method(other); }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign 1;
    Sub sub SubAssign sub_assign 2;
    Mul mul MulAssign mul_assign 3;
    Div div DivAssign div_assign 4;
}

impl Neg for Fingerprint {
    type Output = Self;
    fn neg(self) -> Self {
        self.function(5)
    }
}

impl From<f64> for Fingerprint {
    #[inline]
    fn from(value: f64) -> Self {
        Fingerprint::NONE.then(value.to_bits())
    }
}

impl Zero for Fingerprint {
    fn zero() -> Self {
        Fingerprint::from(0.0)
    }
    fn is_zero(&self) -> bool {
        self.look() == 0.0
    }
}

impl One for Fingerprint {
    fn one() -> Self {
        Fingerprint::from(1.0)
    }
}

impl PartialEq for Fingerprint {
    fn eq(&self, other: &Self) -> bool {
        self.look() == other.look()
    }
}

impl std::fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}", self.look())
    }
}

impl Sum for Fingerprint {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Fingerprint::zero(), Add::add)
    }
}

macro_rules! functions {
    ($($name:ident $number:literal;)*) => {$(
        fn $name(&self) -> Self { self.function($number) }
    )*};
}

impl Scalar for Fingerprint {
    fn re(&self) -> f64 {
        self.look()
    }
    fn powi(&self, n: i32) -> Self {
        self.function(6).then(n as u64)
    }
    fn powf(&self, n: f64) -> Self {
        self.function(7).then(n.to_bits())
    }
    fn sin_cos(&self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn atan2(&self, x: Self) -> Self {
        self.function(8).then(x.0)
    }
    fn hypot(&self, y: Self) -> Self {
        self.function(9).then(y.0)
    }
    fn max(&self, other: Self) -> Self {
        self.function(26).then(other.0)
    }
    fn min(&self, other: Self) -> Self {
        self.function(27).then(other.0)
    }
    fn less(&self, other: Self) -> Self {
        self.function(29).then(other.0)
    }
    fn keep_where(&self, x: Self) -> Self {
        self.function(30).then(x.0)
    }
    functions! {
        abs 25; recip 10; sqrt 11; exp 12; exp_m1 13; ln 14; ln_1p 15; sin 16; cos 17; tan 18; asin 19; acos 20; atan 21; sinh 22; cosh 23;
        tanh 24; signum 28;
    }
}

#[cfg(test)]
mod tests {
    use super::Fingerprint;
    use crate::Scalar;

    fn of(formula: impl Fn(Fingerprint, Fingerprint) -> Fingerprint) -> u64 {
        formula(Fingerprint::input(0), Fingerprint::input(1)).value(false)
    }

    #[test]
    fn formulas_have_different_fingerprints_unless_they_are_the_same() {
        let formulas: [fn(Fingerprint, Fingerprint) -> Fingerprint; 24] = [
            |x, _| x,
            |_, y| y,
            |x, y| x + y,
            |x, y| y + x,
            |x, y| x - y,
            |x, y| x * y,
            |x, y| x / y,
            |x, y| x * 2.0 + y,
            |x, y| x * 3.0 + y,
            |x, y| x + y * 0.0,
            |x, _| x.sin(),
            |x, _| x.cos(),
            |x, _| x.powi(2),
            |x, _| x.powf(2.0),
            |x, _| x.abs(),
            |x, _| x.signum(),
            |x, y| x.pow(y),
            |x, y| x.max(y),
            |x, y| x.min(y),
            |x, y| x.less(y),
            |x, y| x.keep_where(y),
            |x, _| x.max(Fingerprint::from(2.0)),
            |x, _| x.max(Fingerprint::from(3.0)),
            |x, y| x.hypot(y),
        ];
        for (i, f) in formulas.iter().enumerate() {
            for (j, g) in formulas.iter().enumerate() {
                assert_eq!(of(f) == of(g), i == j, "{i} and {j}");
            }
        }
    }
}
