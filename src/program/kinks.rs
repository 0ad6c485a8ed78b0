//! The kinks of a formula: where arguments of |x|, max(x, y), comparisons, or of functions like tanh x that are steep at 0, change their signs.

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;

/// A maximum or minimum that is rounded over the unit length is resolved if at least so many steps cross this length.
const STEPS: f64 = 10.0;

/// A function of the arguments of a formula; the formula has a kink where it is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kink {
    pub(crate) node: Node,
    /// False for a kink; true for functions that are smooth if their argument changes by less than 1 within a step.
    pub(crate) is_smooth: bool,
}

impl Graph {
    /// The kinks of the given nodes, each once. Maxima and minima are smooth, rounded over the unit length, if
    /// the derivatives of the nodes up to `order` are continuous there.
    pub(crate) fn kinks(&mut self, of: &[Node], order: usize) -> Vec<Kink> {
        let mut kinks: Vec<Kink> = Vec::new();
        for node in self.reachable(of.iter().copied()) {
            let Some(kink) = self.kink(node, of, order).filter(|kink| !self.is_fixed(kink.node)) else { continue };
            let opposite = self.function(Function::Negative, kink.node);
            if !kinks.iter().any(|known| [kink.node, opposite].contains(&known.node)) {
                kinks.push(kink);
            }
        }
        kinks
    }

    /// The kink of one operation.
    fn kink(&mut self, node: Node, of: &[Node], order: usize) -> Option<Kink> {
        match self.expression(node) {
            Expression::Of(Function::Abs | Function::Sign, x) => Some(Kink { node: x, is_smooth: false }),
            Expression::Max(x, y) | Expression::Min(x, y) => {
                let is_smooth = [x, y].into_iter().any(|end| self.is_fixed(end) && self.is_rounded(node, end, of, order));
                let (difference, steps) = (self.subtract(x, y), self.constant(if is_smooth { STEPS } else { 1.0 }));
                Some(Kink { node: self.multiply(steps, difference), is_smooth })
            }
            Expression::Less(x, y) => Some(Kink { node: self.subtract(x, y), is_smooth: false }),
            Expression::Of(Function::Tanh | Function::Atan, x) => Some(Kink { node: x, is_smooth: true }),
            Expression::Of(Function::Sqrt, x) => self.rounded_corner(x),
            _ => None,
        }
    }

    /// Whether the derivatives with respect to a node, up to `order`, vanish where it has the value `end`, for all other arguments.
    fn is_rounded(&self, node: Node, end: Node, of: &[Node], order: usize) -> bool {
        let (mut graph, mut slopes) = (self.clone(), of.to_vec());
        let one = graph.constant(1.0);
        (0..order).all(|_| {
            slopes = graph.forward(&slopes, &[(node, one)]);
            graph.vanish_at(&slopes, node, end)
        })
    }

    /// x/√ε of √(x² + ε): a rounded |x|.
    fn rounded_corner(&mut self, sum: Node) -> Option<Kink> {
        let Expression::Add(first, second) = self.expression(sum) else { return None };
        let (fixed, square) = if self.is_fixed(first) { (first, second) } else { (second, first) };
        let x = match self.expression(square) {
            Expression::Multiply(x, y) if x == y => x,
            Expression::IntegerPower(x, 2) => x,
            _ => return None,
        };
        if !self.is_fixed(fixed) {
            return None;
        }
        let width = self.function(Function::Sqrt, fixed);
        Some(Kink { node: self.divide(x, width), is_smooth: true })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinks_are_found_once_and_fixed_arguments_have_none() {
        let mut graph = Graph::default().loose();
        let (x, y, b) = (graph.input(0), graph.input(1), graph.parameter(0));
        let difference = graph.subtract(x, y);
        let (abs, fixed) = (graph.function(Function::Abs, difference), graph.function(Function::Abs, b));
        let larger = graph.put(Expression::Max(y, x));
        let (square, tanh) = (graph.multiply(x, x), graph.function(Function::Tanh, y));
        let sum = graph.add(square, b);
        let root = graph.function(Function::Sqrt, sum);
        let all = [abs, fixed, larger, tanh, root];
        let kinks = graph.kinks(&all, 2);
        let width = graph.function(Function::Sqrt, b);
        let corner = graph.divide(x, width);
        assert_eq!(kinks.iter().map(|kink| kink.is_smooth).collect::<Vec<_>>(), [false, true, true]);
        assert_eq!(kinks.iter().map(|kink| kink.node).collect::<Vec<_>>(), [difference, y, corner]);
    }
    #[test]
    fn maxima_whose_derivatives_vanish_at_their_kinks_are_smooth() {
        let is_smooth = |power: f64, order| {
            let mut graph = Graph::default().loose();
            let (x, y, zero, n) = (graph.input(0), graph.input(1), graph.constant(0.0), graph.constant(power));
            let larger = graph.max(x, zero);
            let power = graph.power(larger, n);
            let product = graph.multiply(power, y);
            graph.kinks(&[product], order)[0].is_smooth
        };
        assert!(!is_smooth(1.0, 1) && !is_smooth(1.5, 2) && !is_smooth(2.0, 2) && !is_smooth(3.0, 3));
        assert!(is_smooth(2.0, 1) && is_smooth(2.5, 2) && is_smooth(3.0, 2) && is_smooth(4.0, 3));
    }
}
