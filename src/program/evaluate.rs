//! Evaluation of a graph node by node, on any number type; used where a program is not worthwhile, for example once per motion.

use num_dual::Dual64;

use super::expression::{Expression, Node};
use super::graph::Graph;
use crate::Scalar;

impl Expression {
    /// The value of an expression, given those of the nodes it is computed from.
    pub(crate) fn value<S: Scalar>(self, at: impl Fn(Node) -> S, parameters: &[S], inputs: &[S]) -> S {
        use Expression::*;
        match self {
            Constant(bits) => S::from(f64::from_bits(bits)),
            Parameter(which) => parameters[which as usize],
            // Only design variables of clones of a scene are not there.
            Input(which) => inputs.get(which as usize).copied().unwrap_or(S::from(f64::NAN)),
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
            Less(x, y) => at(x).less(at(y)),
            Where(condition, x) => at(condition).keep_where(at(x)),
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

/// A node and the expression that replaces it, which uses only earlier nodes.
pub(crate) type Replacement = Option<(Node, Expression)>;

impl Graph {
    /// The values of all nodes for given parameters and inputs.
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

    /// The values of the nodes in `order`, in which one node may be replaced; 0 for all others.
    pub(crate) fn values(&self, order: &[Node], by: Replacement, inputs: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.len()];
        for &node in order {
            values[node.index()] = self.replaced(node, by).value(|node| values[node.index()], &[], inputs);
        }
        values
    }

    /// The derivatives ∂y/∂x of a node y with respect to each node x, at the given values.
    pub(crate) fn slopes(&self, order: &[Node], by: Replacement, values: &[f64], y: Node) -> Vec<f64> {
        let mut slopes = vec![0.0; self.len()];
        slopes[y.index()] = 1.0;
        for &node in order.iter().rev().filter(|node| **node <= y) {
            let (slope, expression) = (slopes[node.index()], self.replaced(node, by));
            for x in expression.distinct_arguments().filter(|_| slope != 0.0) {
                let seeded = |node: Node| Dual64::new(values[node.index()], f64::from(u8::from(node == x)));
                slopes[x.index()] += slope * expression.value(seeded, &[], &[]).eps;
            }
        }
        slopes
    }

    /// Adds the nodes of another graph whose inputs are nodes of this one; returns the new nodes.
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
