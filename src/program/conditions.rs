//! Values kept where a condition holds and 0 elsewhere: the derivatives of maxima and minima, even if infinite on the side that is cut off.
//!
//! A condition is a node that is 1 or 0. Sums and fixed multiples of kept values also have conditions. Products of kept values with a slope are cut
//! off after the multiplication, because the slope may be infinite or NaN where the condition fails, like that of √max(x, 0) for x < 0.

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;

impl Graph {
    /// x where a condition holds, and 0 elsewhere.
    pub(crate) fn keep_where(&mut self, condition: Node, x: Node) -> Node {
        match self.value(condition) {
            Some(0.0) => return self.constant(0.0),
            Some(_) => return x,
            None if self.is_zero(x) => return x,
            None => {}
        }
        let both = self.condition(x).map_or(condition, |other| self.joined(condition, other, true));
        let node = self.put(Expression::Where(condition, x));
        self.conditions.insert(node, both);
        node
    }

    /// The kept values of two nodes with a common condition, which is also returned, so that their sum can be cut off by one condition.
    pub(super) fn both_where(&self, x: Node, y: Node) -> Option<(Node, [Node; 2])> {
        match (self.expression(x), self.expression(y)) {
            (Expression::Where(condition, x), Expression::Where(other, y)) if condition == other => {
                Some((condition, [x, y]))
            }
            _ => None,
        }
    }

    /// Records a condition for a sum if both of its terms have conditions.
    pub(super) fn note_condition(&mut self, sum: Node, terms: [Node; 2]) {
        if let [Some(first), Some(second)] = terms.map(|term| self.condition(term)) {
            let either = self.joined(first, second, false);
            self.conditions.insert(sum, either);
        }
    }

    /// The condition that both of two conditions hold (their product), or that at least one does (their maximum).
    fn joined(&mut self, x: Node, y: Node, is_both: bool) -> Node {
        use Expression::{Max, Multiply};
        for (x, y) in [(x, y), (y, x)] {
            match self.expression(y) {
                _ if x == y => return x,
                Multiply(first, second) if [first, second].contains(&x) => return if is_both { y } else { x },
                Max(first, second) if [first, second].contains(&x) => return if is_both { x } else { y },
                _ => {}
            }
        }
        if is_both { self.multiply(x, y) } else { self.put(Max(x.min(y), x.max(y))) }
    }

    /// The condition without which a node is 0: for kept values, fixed multiples of these, and sums of such nodes.
    pub(super) fn condition(&self, node: Node) -> Option<Node> {
        match self.expression(node) {
            Expression::Of(Function::Negative, x) => self.condition(x),
            Expression::Multiply(factor, x) if self.is_fixed(factor) => self.condition(x),
            _ => self.conditions.get(&node).copied(),
        }
    }

    /// A node that has a condition, without the condition.
    pub(super) fn unconditional(&mut self, node: Node) -> Node {
        match self.expression(node) {
            Expression::Where(_, x) => self.unconditional(x),
            Expression::Of(Function::Negative, x) => {
                let x = self.unconditional(x);
                self.function(Function::Negative, x)
            }
            Expression::Multiply(factor, x) if self.condition(x).is_some() => {
                let x = self.unconditional(x);
                self.multiply(factor, x)
            }
            _ => node,
        }
    }

    /// x, kept where it is not 0, so that its products with infinite slopes are 0 where it vanishes.
    pub(crate) fn unless_zero(&mut self, x: Node) -> Node {
        let zero = self.constant(0.0);
        let (below, above) = (self.less(x, zero), self.less(zero, x));
        let moves = self.add(below, above);
        self.keep_where(moves, x)
    }
}
