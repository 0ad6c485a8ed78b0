//! A node of a graph in mathematical notation.

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;

impl Graph {
    /// A node in mathematical notation, with the names of its inputs; abbreviated below `depth`.
    pub(crate) fn text(&self, node: Node, names: &[String], depth: usize) -> String {
        use Expression::*;
        let of = |x: Node| self.text(x, names, depth - 1);
        match self.expression(node) {
            Constant(bits) => f64::from_bits(bits).to_string(),
            Parameter(k) | Input(k) => names[k as usize].clone(),
            _ if depth == 0 => "…".into(),
            Of(Function::Negative, x) => format!("−{}", of(x)),
            Of(Function::Reciprocal, x) => format!("1/{}", of(x)),
            Of(Function::Abs, x) => format!("|{}|", of(x)),
            Of(function, x) => format!("{}({})", function.name(), of(x)),
            Add(x, y) => format!("({} + {})", of(x), of(y)),
            Subtract(x, y) => format!("({} − {})", of(x), of(y)),
            Multiply(x, y) if x == y => format!("{}²", of(x)),
            Multiply(x, y) | Vanishing(x, y) => format!("{}·{}", of(x), of(y)),
            Divide(x, y) => format!("{}/{}", of(x), of(y)),
            IntegerPower(x, n) => format!("{}^{n}", of(x)),
            Power(x, n) | SlopePower(x, n) => format!("{}^{}", of(x), of(n)),
            Atan2(y, x) => format!("atan2({}, {})", of(y), of(x)),
            Max(x, y) => format!("max({}, {})", of(x), of(y)),
            Min(x, y) => format!("min({}, {})", of(x), of(y)),
            Less(x, y) => format!("({} < {})", of(x), of(y)),
            Where(_, x) => of(x),
        }
    }
}
