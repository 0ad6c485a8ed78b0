//! A graph on any numbers, node by node: what a program is not made for, since it is asked once a motion.

use num_dual::Dual64;

use super::expression::{Expression, Node};
use super::graph::Graph;
use crate::Scalar;

impl Expression {
    /// Its value, given those of the nodes that it is made of.
    pub(crate) fn value<S: Scalar>(self, at: impl Fn(Node) -> S, parameters: &[S], inputs: &[S]) -> S {
        use Expression::*;
        match self {
            Constant(bits) => S::from(f64::from_bits(bits)),
            Parameter(which) => parameters[which as usize],
            Input(which) => inputs[which as usize],
            Of(function, x) => function.value(at(x)),
            Add(x, y) => at(x) + at(y),
            Subtract(x, y) => at(x) - at(y),
            Multiply(x, y) => at(x) * at(y),
            Divide(x, y) => at(x) / at(y),
            IntegerPower(x, n) => at(x).powi(n),
            Power(x, n) | SlopePower(x, n) => at(x).powf(at(n).re()),
            Atan2(y, x) => at(y).atan2(at(x)),
            Max(x, y) => at(x).max(at(y)),
            Min(x, y) => at(x).min(at(y)),
            Less(x, y) => S::from(if at(x).re() < at(y).re() { 1.0 } else { 0.0 }),
            Where(condition, x) => {
                if at(condition).re() == 0.0 {
                    S::zero()
                } else {
                    at(x)
                }
            }
            Vanishing(x, y) => {
                if at(y).re() == 0.0 {
                    S::zero()
                } else {
                    at(x) * at(y)
                }
            }
        }
    }
}

/// A node and what it is replaced by, which is made of nodes before it.
pub(crate) type Replacement = Option<(Node, Expression)>;

impl Graph {
    /// The values of all nodes, for given parameters and inputs.
    pub(crate) fn evaluate<S: Scalar>(&self, parameters: &[S], inputs: &[S]) -> Vec<S> {
        let mut values: Vec<S> = Vec::with_capacity(self.len());
        for expression in self.expressions() {
            values.push(expression.value(|node| values[node.index()], parameters, inputs));
        }
        values
    }

    fn replaced(&self, node: Node, by: Replacement) -> Expression {
        by.filter(|(which, _)| *which == node).map_or(self.expression(node), |(_, other)| other)
    }

    /// The values of some nodes, which follow what they are made of, where one may be replaced; 0 for all others.
    pub(crate) fn values(&self, order: &[Node], by: Replacement, inputs: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.len()];
        for &node in order {
            values[node.index()] = self.replaced(node, by).value(|node| values[node.index()], &[], inputs);
        }
        values
    }

    /// ∂y/∂x of a node y by each of these nodes x, at such values.
    pub(crate) fn slopes(&self, order: &[Node], by: Replacement, values: &[f64], y: Node) -> Vec<f64> {
        let mut slopes = vec![0.0; self.len()];
        slopes[y.index()] = 1.0;
        for &node in order.iter().rev().filter(|node| **node <= y) {
            let (slope, expression) = (slopes[node.index()], self.replaced(node, by));
            let mut last = None;
            for x in expression.arguments().filter(|_| slope != 0.0) {
                let seeded = |node: Node| Dual64::new(values[node.index()], f64::from(u8::from(node == x)));
                // A square has one argument.
                if last != Some(x) {
                    slopes[x.index()] += slope * expression.value(seeded, &[], &[]).eps;
                }
                last = Some(x);
            }
        }
        slopes
    }

    /// Adds the nodes of another graph, whose inputs are nodes of this one; returns where they came to stand.
    pub(crate) fn import(&mut self, other: &Graph, inputs: &[Node]) -> Vec<Node> {
        let mut nodes: Vec<Node> = Vec::with_capacity(other.len());
        for expression in other.expressions() {
            nodes.push(match expression {
                Expression::Parameter(which) | Expression::Input(which) => inputs[which as usize],
                expression => self.make(expression.map(|x| nodes[x.index()])),
            });
        }
        nodes
    }
}
