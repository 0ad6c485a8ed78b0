//! [`Template`]: a recorded formula without its numbers, shared by all elements with this formula.

use super::expression::{Expression, Node};
use super::graph::Graph;

/// The nodes of a formula, renumbered, and its results; numbers that may differ between such elements are parameters.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Template {
    expressions: Vec<Expression>,
    results: Vec<Node>,
    /// The number of parameters, including the numbers in the formula.
    pub(crate) parameters: usize,
}

/// Whether a number is part of the template: multiples of ½ up to 4, which may simplify it, and numbers that are not finite.
fn is_structural(value: f64) -> bool {
    value.abs() <= 4.0 && (2.0 * value).fract() == 0.0 || !value.is_finite()
}

impl Template {
    /// The template of a formula with the given number of parameters, and the numbers that became additional parameters.
    pub(crate) fn new(graph: &Graph, results: &[Node], parameters: usize) -> (Self, Vec<f64>) {
        let (graph, results) = graph.loosened(results);
        let reachable = graph.reachable(results.iter().copied());
        let mut is_exponent = vec![false; graph.len()];
        for &node in &reachable {
            if let Expression::Power(_, n) = graph.expression(node) {
                is_exponent[n.0 as usize] = true;
            }
        }
        let (mut expressions, mut numbers) = (Vec::with_capacity(reachable.len()), Vec::new());
        let mut renumbered = vec![Node(u32::MAX); graph.len()];
        for node in reachable {
            renumbered[node.0 as usize] = Node(expressions.len() as u32);
            expressions.push(match graph.value(node) {
                Some(value) if !is_structural(value) && !is_exponent[node.0 as usize] => {
                    numbers.push(value);
                    Expression::Parameter((parameters + numbers.len() - 1) as u32)
                }
                _ => graph.expression(node).map(|x| renumbered[x.0 as usize]),
            });
        }
        let results = results.iter().map(|node| renumbered[node.0 as usize]).collect();
        (Template { expressions, results, parameters: parameters + numbers.len() }, numbers)
    }

    /// For each of `inputs` inputs, whether the formula depends on it.
    pub(crate) fn depends(&self, inputs: usize) -> Vec<bool> {
        let mut depends = vec![false; inputs];
        self.expressions.iter().filter_map(|of| of.input()).for_each(|which| depends[which] = true);
        depends
    }

    /// The template as a graph to which derivatives can be added, and the results in it.
    pub(crate) fn graph(&self) -> (Graph, Vec<Node>) {
        let mut graph = Graph::default().loose();
        self.expressions.iter().for_each(|expression| _ = graph.put(*expression));
        graph.keep_signs(&self.results);
        (graph, self.results.clone())
    }
}
