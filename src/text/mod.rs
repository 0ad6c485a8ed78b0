//! Formulas as text: `0.5 * mass * v[cart.x] ^ 2`.
//!
//! A formula consists of numbers, names, `+ - * / ^`, parentheses and functions (`sin(x)`, `atan2(y, x)`, `pow(x, 2.5)`, …), which are evaluated from left to
//! right. `if(x < y, a, b)` is a if x < y, and b otherwise. A name that is not a word is written in backticks. An entry of a list has its index or its name in brackets: `q[0]`, `q[cart.x]`.
//!
//! Parts of a long formula precede it. `$1` is the first part; a text contains its parts, each followed by a semicolon: `mass * length; $1 * $1 / 12`.

mod reader;
mod writer;

pub(crate) use reader::{Mistake, Name, Reader};
pub(crate) use writer::{Parts, Text, quoted, write};

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::Scalar;
use crate::program::{Function, Graph, Node, Symbol};

/// The value of a part of a formula that is read: a parameter, or a symbol that records the formula.
pub(crate) trait Term:
    Copy + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Its value if it is a constant.
    fn constant(self) -> Option<f64>;
    /// xⁿ for an integer n.
    fn integer_power(self, n: i32) -> Self;
    /// xⁿ.
    fn power(self, n: f64) -> Self;
    fn function(self, function: Function) -> Self;
    fn of_two(self, function: OfTwo, other: Self) -> Self;

    /// x if `self` < `other`, and y otherwise.
    fn if_less(self, other: Self, x: Self, y: Self) -> Self {
        let less = self.of_two(OfTwo::Less, other);
        let not_less = Self::from(1.0) - less;
        less.of_two(OfTwo::Where, x) + not_less.of_two(OfTwo::Where, y)
    }
}

impl Term for Symbol {
    fn constant(self) -> Option<f64> {
        Symbol::constant(self)
    }
    fn integer_power(self, n: i32) -> Self {
        self.powi(n)
    }
    fn power(self, n: f64) -> Self {
        self.powf(n)
    }
    fn function(self, function: Function) -> Self {
        function.value(self)
    }
    fn of_two(self, function: OfTwo, other: Self) -> Self {
        function.value(self, other)
    }
}

/// A function of two arguments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OfTwo {
    /// The angle of the point (x, y); the arguments are y and x.
    Atan2,
    Max,
    Min,
    /// 1 if the first is less than the second, 0 otherwise.
    Less,
    /// The second if the first is not 0, otherwise 0, whatever the second is.
    Where,
}

impl OfTwo {
    pub(crate) const ALL: [(&'static str, OfTwo); 5] =
        [("atan2", OfTwo::Atan2), ("max", OfTwo::Max), ("min", OfTwo::Min), ("less", OfTwo::Less), ("where", OfTwo::Where)];

    pub(crate) fn value<S: Scalar>(self, x: S, y: S) -> S {
        match self {
            OfTwo::Atan2 => x.atan2(y),
            OfTwo::Max => x.max(y),
            OfTwo::Min => x.min(y),
            OfTwo::Less => x.less(y),
            OfTwo::Where => x.keep_where(y),
        }
    }

    pub(crate) fn node(self, graph: &mut Graph, x: Node, y: Node) -> Node {
        match self {
            OfTwo::Atan2 => graph.atan2(x, y),
            OfTwo::Max => graph.max(x, y),
            OfTwo::Min => graph.min(x, y),
            OfTwo::Less => graph.less(x, y),
            OfTwo::Where => graph.keep_where(x, y),
        }
    }
}

/// True if a name needs no backticks in a formula.
fn is_word(name: &str) -> bool {
    name.chars().all(|c| c.is_alphanumeric() || c == '_') && name.starts_with(|c: char| !c.is_numeric())
}
