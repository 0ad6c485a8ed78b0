//! A graph on any numbers, node by node: what a program is not made for, since it is asked once a motion.

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

impl Graph {
    /// The values of all nodes, for given parameters and inputs.
    pub(crate) fn evaluate<S: Scalar>(&self, parameters: &[S], inputs: &[S]) -> Vec<S> {
        let mut values: Vec<S> = Vec::with_capacity(self.len());
        for expression in self.expressions() {
            values.push(expression.value(|node| values[node.index()], parameters, inputs));
        }
        values
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
