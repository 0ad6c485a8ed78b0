//! [`Trace`]: a number that records what a formula depends on, and how.
//!
//! A scene evaluates each element once with it when it is compiled. A formula of degree one (a linear constraint, a linear force)
//! or two (a constant mass, a linear spring's energy) gives constant blocks, evaluated once and never again; and of a nonlinear one
//! only the coordinates that enter nonlinearly need dual numbers at every iteration. A formula that is a sum of
//! multiples of q_i, sin q_i and cos q_i (most planar joints) needs none at all: its derivatives are its own coefficients.

use num_traits::{One, Zero};
use std::cell::Cell;
use std::fmt;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::Scalar;

/// The degree of a formula that is no polynomial of degree at most two.
const BEYOND: u8 = 3;

thread_local! {
    /// Whether a formula has asked for the value of a number that depends on its inputs (to branch on it).
    static LOOKED: Cell<bool> = const { Cell::new(false) };
}

/// A number that remembers its inputs (one bit each), those that it is not linear in, and its degree as a polynomial.
#[derive(Clone, Copy)]
pub struct Trace {
    value: f64,
    /// The value is the same in every run: not an input and not a design variable.
    known: bool,
    inputs: u128,
    bent: u128,
    degree: u8,
    /// A sum of constants and of multiples of single inputs and of their sines and cosines.
    sinusoidal: bool,
    /// One input with the factor 1 or −1, plus a constant.
    angle: bool,
    /// Its rate of change when all shifted inputs grow at the rate 1; not a number where that is no constant.
    rate: f64,
    /// Whether it depends on the marked input, and the inputs that its derivative by that one depends on or may.
    marked: bool,
    partners: u128,
}

/// What a formula depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Structure {
    /// The inputs that it depends on, one bit each.
    pub inputs: u128,
    /// The inputs in which it is not linear (or which multiply another input).
    pub bent: u128,
    /// 0, 1 or 2 for a polynomial of that degree, 3 for anything else.
    pub degree: u8,
    /// Whether it is a sum of multiples of x_i, sin x_i and cos x_i over its inputs x_i.
    pub sinusoidal: bool,
    /// Whether it stays the same if all [shifted](Trace::shifted) inputs grow by the same amount.
    pub unmoved: bool,
}

impl Structure {
    /// The number of inputs that can be told apart.
    pub const MOST_INPUTS: usize = 128;

    /// What is assumed of a formula that could not be traced: everything.
    pub const UNKNOWN: Structure =
        Structure { inputs: u128::MAX, bent: u128::MAX, degree: BEYOND, sinusoidal: false, unmoved: false };

    /// Whether it depends on input `i`.
    pub fn depends_on(&self, i: usize) -> bool {
        self.inputs & bits(i) == bits(i)
    }

    /// Whether it is other than linear in input `i`.
    pub fn is_bent_in(&self, i: usize) -> bool {
        self.bent & bits(i) == bits(i)
    }

    /// Runs a formula and joins what its results depend on.
    ///
    /// If the formula branches on a traced value, nothing is known of the branch it did not take: [`Structure::UNKNOWN`]. Nor is it of one
    /// that panics, since it is not defined at the values of the trace.
    pub fn of<I: IntoIterator<Item = Trace>>(formula: impl FnOnce() -> I) -> Structure {
        LOOKED.set(false);
        let none = Structure { inputs: 0, bent: 0, degree: 0, sinusoidal: true, unmoved: true };
        let found = guarded(formula).map(|results| {
            results.into_iter().fold(none, |all, x| Structure {
                inputs: all.inputs | x.inputs,
                bent: all.bent | x.bent,
                degree: all.degree.max(x.degree),
                sinusoidal: all.sinusoidal && x.sinusoidal,
                unmoved: all.unmoved && x.rate == 0.0,
            })
        });
        if LOOKED.take() { Structure::UNKNOWN } else { found.unwrap_or(Structure::UNKNOWN) }
    }
}

/// What a formula gives where it may not be defined: nothing if it panics.
pub(crate) fn guarded<T>(formula: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(formula)).ok()
}

/// Notes that a formula has asked for a value that is not known before a run.
pub(crate) fn note_look() {
    LOOKED.set(true);
}

/// Whether a formula has asked for such a value since this was called last.
pub(crate) fn take_look() -> bool {
    LOOKED.take()
}

/// The bit of an input; all of them, if it is one that cannot be told apart.
fn bits(input: usize) -> u128 {
    if input < Structure::MOST_INPUTS { 1 << input } else { u128::MAX }
}

impl Trace {
    /// Input number `index`, with a value for formulas that look at it.
    pub fn input(value: f64, index: usize) -> Self {
        Trace { known: false, inputs: bits(index), degree: 1, angle: true, ..Trace::from(value) }
    }

    /// An input as one of those that are shifted together.
    pub fn shifted(self) -> Self {
        Trace { rate: 1.0, ..self }
    }

    /// An input as the one whose products with others are looked for.
    pub fn marked(self) -> Self {
        Trace { marked: true, ..self }
    }

    /// The inputs that it depends on, one bit each.
    pub fn inputs(&self) -> u128 {
        self.inputs
    }

    /// The inputs x_j for which ∂²/∂x_i ∂x_j is other than zero by structure, x_i being the marked input; one bit each.
    pub fn partners(&self) -> u128 {
        self.partners
    }

    /// A constant of the run whose value may be another in the next run (a design variable).
    pub fn unknown_constant(value: f64) -> Self {
        Trace { known: false, ..Trace::from(value) }
    }

    fn is_known_zero(&self) -> bool {
        self.known && self.value == 0.0
    }

    fn look(&self) -> f64 {
        if !self.known {
            LOOKED.set(true);
        }
        self.value
    }

    /// f(self) for a function that is not a polynomial.
    fn beyond(self, f: impl Fn(f64) -> f64) -> Self {
        let constant = self.degree == 0;
        let degree = if constant { 0 } else { BEYOND };
        let rate = if self.rate == 0.0 { 0.0 } else { f64::NAN };
        let partners = if self.marked { self.inputs } else { 0 };
        Trace { value: f(self.value), degree, bent: self.inputs, sinusoidal: constant, angle: false, rate, partners, ..self }
    }

    /// Sine or cosine.
    fn wave(self, f: impl Fn(f64) -> f64) -> Self {
        Trace { sinusoidal: self.degree == 0 || self.angle, ..self.beyond(f) }
    }

    /// Whether it is a constant whose value is always 1 or −1.
    fn keeps_angle(&self) -> bool {
        self.known && self.value.abs() == 1.0
    }

    /// The other factor's inputs, if this one depends on the marked input.
    fn crossed(&self, other: &Trace) -> u128 {
        if self.marked { other.inputs } else { 0 }
    }

    /// The rate of the product with a number of this rate: a constant that is not known may be any.
    fn times_rate(&self, rate: f64) -> f64 {
        match (self.known, rate == 0.0) {
            (_, true) => 0.0,
            (true, false) => self.value * rate,
            (false, false) => f64::NAN,
        }
    }
}

impl Add for Trace {
    type Output = Trace;
    fn add(self, other: Trace) -> Trace {
        Trace {
            value: self.value + other.value,
            known: self.known && other.known,
            inputs: self.inputs | other.inputs,
            bent: self.bent | other.bent,
            degree: self.degree.max(other.degree),
            sinusoidal: self.sinusoidal && other.sinusoidal,
            angle: self.angle && other.degree == 0 || self.degree == 0 && other.angle,
            rate: self.rate + other.rate,
            marked: self.marked || other.marked,
            partners: self.partners | other.partners,
        }
    }
}

impl Mul for Trace {
    type Output = Trace;
    fn mul(self, other: Trace) -> Trace {
        // A known zero (an arm of no length, say) removes the other factor from the formula.
        if self.is_known_zero() || other.is_known_zero() {
            return Trace::zero();
        }
        let product = self.degree > 0 && other.degree > 0;
        let inputs = self.inputs | other.inputs;
        Trace {
            value: self.value * other.value,
            known: self.known && other.known,
            inputs,
            bent: if product { inputs } else { self.bent | other.bent },
            degree: (self.degree + other.degree).min(BEYOND),
            sinusoidal: !product && self.sinusoidal && other.sinusoidal,
            angle: self.angle && other.keeps_angle() || self.keeps_angle() && other.angle,
            rate: self.times_rate(other.rate) + other.times_rate(self.rate),
            marked: self.marked || other.marked,
            partners: self.partners | other.partners | self.crossed(&other) | other.crossed(&self),
        }
    }
}

impl Neg for Trace {
    type Output = Trace;
    fn neg(self) -> Trace {
        Trace { value: -self.value, rate: -self.rate, ..self }
    }
}

impl Sub for Trace {
    type Output = Trace;
    fn sub(self, other: Trace) -> Trace {
        self + -other
    }
}

impl Div for Trace {
    type Output = Trace;
    // A quotient depends on its parts as the product with the reciprocal does.
    #[expect(clippy::suspicious_arithmetic_impl)]
    fn div(self, other: Trace) -> Trace {
        self * other.beyond(f64::recip)
    }
}

macro_rules! with_constants {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident;)*) => {$(
        impl $operator<f64> for Trace {
            type Output = Trace;
            fn $method(self, other: f64) -> Trace { self.$method(Trace::from(other)) }
        }
        impl $assign for Trace {
            fn $assign_method(&mut self, other: Trace) { *self = self.$method(other); }
        }
        impl $assign<f64> for Trace {
            fn $assign_method(&mut self, other: f64) { *self = self.$method(other); }
        }
    )*};
}

with_constants! {
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
}

impl From<f64> for Trace {
    fn from(value: f64) -> Self {
        Trace {
            value,
            known: true,
            inputs: 0,
            bent: 0,
            degree: 0,
            sinusoidal: true,
            angle: false,
            rate: 0.0,
            marked: false,
            partners: 0,
        }
    }
}

impl fmt::Debug for Trace {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        // A text that shows the value lets a formula branch on it.
        write!(f, "{}", self.look())
    }
}

impl Zero for Trace {
    fn zero() -> Self {
        Trace::from(0.0)
    }
    fn is_zero(&self) -> bool {
        self.look() == 0.0
    }
}

impl One for Trace {
    fn one() -> Self {
        Trace::from(1.0)
    }
}

impl PartialEq for Trace {
    fn eq(&self, other: &Self) -> bool {
        self.look() == other.look()
    }
}

impl Sum for Trace {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Trace::zero(), Add::add)
    }
}

impl Scalar for Trace {
    fn re(&self) -> f64 {
        self.look()
    }
    fn recip(&self) -> Self {
        self.beyond(f64::recip)
    }
    fn powi(&self, n: i32) -> Self {
        match n {
            0 => Trace::one(),
            1 => *self,
            2 => *self * *self,
            _ => self.beyond(|x| x.powi(n)),
        }
    }
    fn powf(&self, n: f64) -> Self {
        self.beyond(|x| x.powf(n))
    }
    fn sqrt(&self) -> Self {
        self.beyond(f64::sqrt)
    }
    fn exp(&self) -> Self {
        self.beyond(f64::exp)
    }
    fn exp_m1(&self) -> Self {
        self.beyond(f64::exp_m1)
    }
    fn ln(&self) -> Self {
        self.beyond(f64::ln)
    }
    fn ln_1p(&self) -> Self {
        self.beyond(f64::ln_1p)
    }
    fn sin_cos(&self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn sin(&self) -> Self {
        self.wave(f64::sin)
    }
    fn cos(&self) -> Self {
        self.wave(f64::cos)
    }
    fn tan(&self) -> Self {
        self.beyond(f64::tan)
    }
    fn asin(&self) -> Self {
        self.beyond(f64::asin)
    }
    fn acos(&self) -> Self {
        self.beyond(f64::acos)
    }
    fn atan(&self) -> Self {
        self.beyond(f64::atan)
    }
    fn sinh(&self) -> Self {
        self.beyond(f64::sinh)
    }
    fn cosh(&self) -> Self {
        self.beyond(f64::cosh)
    }
    // These two are smooth functions that only choose between equal formulas: no reason to look.
    fn tanh(&self) -> Self {
        self.beyond(f64::tanh)
    }
    fn atan2(&self, x: Self) -> Self {
        // Rates that cancel in a sum do not cancel here.
        let rate = if self.rate == 0.0 && x.rate == 0.0 { 0.0 } else { f64::NAN };
        let both = Trace { rate, ..*self + x };
        both.beyond(|_| self.value.atan2(x.value))
    }
}

#[cfg(test)]
mod tests {
    use super::{BEYOND, Structure, Trace};
    use crate::Scalar;

    fn of(formula: impl Fn(Trace, Trace) -> Trace) -> Structure {
        Structure::of(|| [formula(Trace::input(0.3, 0), Trace::input(0.7, 1))])
    }

    /// Inputs, bent inputs, degree.
    fn parts(formula: impl Fn(Trace, Trace) -> Trace) -> (u128, u128, u8) {
        let Structure { inputs, bent, degree, .. } = of(formula);
        (inputs, bent, degree)
    }

    #[test]
    fn degrees_and_bent_inputs_are_those_of_the_formula() {
        assert_eq!(parts(|x, y| x * 2.0 - y / 3.0 + 1.0), (3, 0, 1));
        assert_eq!(parts(|x, y| x * x + y), (3, 1, 2));
        assert_eq!(parts(|x, y| x * y), (3, 3, 2));
        assert_eq!(parts(|x, y| x.sin() + y), (3, 1, BEYOND));
        assert_eq!(parts(|x, y| x / y), (3, 3, BEYOND));
        assert_eq!(parts(|x, y| x * x * y), (3, 3, BEYOND));
        assert_eq!(parts(|_, y| y.powi(2)), (2, 2, 2));
    }

    #[test]
    fn sums_of_sines_are_recognised_and_nothing_else_is_taken_for_one() {
        let sinusoidal = |formula: fn(Trace, Trace) -> Trace| of(formula).sinusoidal;
        assert!(sinusoidal(|x, y| x.sin() * 0.5 - (-y + 0.3).cos() * 2.0 + x * 4.0 + 1.0));
        assert!(!sinusoidal(|x, y| x.sin() * y));
        assert!(!sinusoidal(|x, _| (x * 2.0).sin()));
        assert!(!sinusoidal(|x, y| (x + y).sin()));
        assert!(!sinusoidal(|x, _| x.sin().sin()));
        assert!(!sinusoidal(|x, _| x.sin() * x.cos()));
        assert!(!sinusoidal(|x, _| x.exp()));
        // A design variable of value 1 may have another value in the next run.
        assert!(!sinusoidal(|x, _| (x * Trace::unknown_constant(1.0)).sin()));
    }

    #[test]
    fn a_known_zero_removes_what_it_multiplies_and_a_design_variable_does_not() {
        assert_eq!(parts(|x, y| x.cos() * 0.0 + y), (2, 0, 1));
        let bound = Trace::unknown_constant(0.0);
        assert_eq!(parts(|x, y| x.cos() * bound + y), (3, 1, BEYOND));
    }

    #[test]
    fn what_depends_on_differences_alone_is_unmoved_and_nothing_else() {
        let unmoved = |formula: fn(Trace, Trace) -> Trace| {
            Structure::of(|| [formula(Trace::input(0.3, 0).shifted(), Trace::input(0.7, 1).shifted())]).unmoved
        };
        assert!(unmoved(|x, y| (x - y).sin() + (y * 2.0 - x * 2.0).exp()));
        assert!(unmoved(|x, y| (y - x) * (y - x) * Trace::unknown_constant(0.4)));
        assert!(!unmoved(|x, y| x + y));
        assert!(!unmoved(|x, y| x * 2.0 - y));
        assert!(!unmoved(|x, y| x * x - y * y));
        assert!(!unmoved(|x, y| x.sin() - x.sin() + y - y.cos()));
        assert!(!unmoved(|x, y| x * Trace::unknown_constant(1.0) - y));
        assert!(!unmoved(|x, y| x * (x - y)));
        assert!(!unmoved(|x, y| x.atan2(-y)));
        assert!(!unmoved(|x, y| if x.re() > y.re() { x - y } else { y - x }));
    }

    #[test]
    fn a_formula_that_branches_is_taken_for_unknown() {
        assert_eq!(of(|x, y| if x.re() > 0.0 { y } else { x * y }), Structure::UNKNOWN);
        assert_eq!(of(|x, y| x.abs() + y), Structure::UNKNOWN);
    }
}
