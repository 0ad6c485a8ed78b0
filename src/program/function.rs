//! Functions of one argument: their values and differentiation rules.

use super::expression::Node;
use super::graph::Graph;
use crate::Scalar;

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Function {
    Negative,
    Reciprocal,
    Sqrt,
    Exp,
    ExpM1,
    Ln,
    Ln1p,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Abs,
    /// −1 for numbers below zero, 1 for all others: the derivative of |x|.
    Sign,
}

impl Function {
    /// The functions that files write as a name and an argument.
    #[cfg(feature = "files")]
    pub(crate) const NAMED: [Function; 16] = {
        use Function::*;
        [Sqrt, Exp, ExpM1, Ln, Ln1p, Sin, Cos, Tan, Asin, Acos, Atan, Sinh, Cosh, Tanh, Abs, Sign]
    };

    /// The value of the function, for any number type.
    #[inline]
    pub(crate) fn value<S: Scalar>(self, x: S) -> S {
        match self {
            Function::Negative => -x,
            Function::Reciprocal => x.recip(),
            Function::Sqrt => x.sqrt(),
            Function::Exp => x.exp(),
            Function::ExpM1 => x.exp_m1(),
            Function::Ln => x.ln(),
            Function::Ln1p => x.ln_1p(),
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.tan(),
            Function::Asin => x.asin(),
            Function::Acos => x.acos(),
            Function::Atan => x.atan(),
            Function::Sinh => x.sinh(),
            Function::Cosh => x.cosh(),
            Function::Tanh => x.tanh(),
            Function::Abs => x.abs(),
            Function::Sign => S::from(if x.re() < 0.0 { -1.0 } else { 1.0 }),
        }
    }

    /// Whether f(−x) = −f(x).
    pub(super) fn is_odd(self) -> bool {
        use Function::{Asin, Atan, Reciprocal, Sin, Sinh, Tan, Tanh};
        matches!(self, Reciprocal | Sin | Tan | Asin | Atan | Sinh | Tanh)
    }

    /// Whether f(−x) = f(x).
    pub(super) fn is_even(self) -> bool {
        matches!(self, Function::Cos | Function::Cosh | Function::Abs)
    }

    /// The derivative f′(x), given y = f(x); `None` if it vanishes everywhere.
    pub(super) fn derivative(self, graph: &mut Graph, x: Node, y: Node) -> Option<Node> {
        let one = graph.constant(1.0);
        Some(match self {
            Function::Negative => graph.constant(-1.0),
            Function::Reciprocal => {
                let square = graph.multiply(y, y);
                graph.function(Function::Negative, square)
            }
            Function::Sqrt => {
                let (half, reciprocal) = (graph.constant(0.5), graph.function(Function::Reciprocal, y));
                graph.multiply(half, reciprocal)
            }
            Function::Exp => y,
            Function::ExpM1 => graph.add(y, one),
            Function::Ln => graph.function(Function::Reciprocal, x),
            Function::Ln1p => {
                let sum = graph.add(x, one);
                graph.function(Function::Reciprocal, sum)
            }
            Function::Sin => graph.function(Function::Cos, x),
            Function::Cos => {
                let sine = graph.function(Function::Sin, x);
                graph.function(Function::Negative, sine)
            }
            Function::Tan => {
                let square = graph.multiply(y, y);
                graph.add(one, square)
            }
            Function::Asin | Function::Acos => {
                // 1 − x² would lose digits near the ends of the interval.
                let (above, below) = (graph.add(one, x), graph.subtract(one, x));
                let rest = graph.multiply(above, below);
                let root = graph.function(Function::Sqrt, rest);
                let slope = graph.function(Function::Reciprocal, root);
                if self == Function::Asin { slope } else { graph.function(Function::Negative, slope) }
            }
            Function::Atan => {
                let square = graph.multiply(x, x);
                let sum = graph.add(one, square);
                graph.function(Function::Reciprocal, sum)
            }
            Function::Sinh => graph.function(Function::Cosh, x),
            Function::Cosh => graph.function(Function::Sinh, x),
            Function::Tanh => {
                // 4 e/(1 + e)² with e = exp(−2 |x|): 1 − y² would lose all digits for y close to 1, and cosh x overflows.
                let (minus_two, four) = (graph.constant(-2.0), graph.constant(4.0));
                let size = graph.function(Function::Abs, x);
                let exponent = graph.multiply(minus_two, size);
                let e = graph.function(Function::Exp, exponent);
                let sum = graph.add(one, e);
                let reciprocal = graph.function(Function::Reciprocal, sum);
                let (square, above) = (graph.multiply(reciprocal, reciprocal), graph.multiply(four, e));
                graph.multiply(above, square)
            }
            Function::Abs => graph.function(Function::Sign, x),
            Function::Sign => return None,
        })
    }

    /// The name of the function in programs, messages and formulas of files.
    pub(crate) fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}
