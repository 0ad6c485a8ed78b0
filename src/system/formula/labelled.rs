//! [`Labelled`]: a program with labelled results, and the derivatives of labelled nodes.

use std::sync::Arc;

use super::shape::{Shape, Slot};
use crate::program::{Graph, Kernel, Node, Template};

/// A program, and for each of its results a label.
#[derive(Clone, Debug)]
pub struct Labelled<T> {
    pub kernel: Arc<Kernel>,
    pub of: Vec<T>,
}

impl<T> Labelled<T> {
    /// Compiles the nodes that do not vanish; `None` if the program is too long.
    pub fn new(graph: &mut Graph, parameters: usize, all: impl IntoIterator<Item = (T, Node)>) -> Option<Self> {
        let (of, nodes) = without_zeros(graph, all);
        Some(Labelled { kernel: Arc::new(Kernel::new(graph, parameters, &nodes)?), of })
    }
}

impl Labelled<(usize, Option<Slot>)> {
    /// The program for the value h of a recorded formula and its gradient with respect to these variables (order 0) and, with two orders, also for
    /// their changes along a direction (order 1). A result is labelled with its order and the argument of a derivative.
    ///
    /// The parameters are those of the formula, followed by the factors of the constants.
    pub fn gradient(template: &Template, shape: Shape, variables: &[Slot], orders: usize) -> Option<Self> {
        let (mut graph, values) = template.graph();
        let along = tangents(&mut graph, (shape, template.parameters), variables);
        let (one, mut value, mut all) = (graph.constant(1.0), values[0], Vec::new());
        for order in 0..orders {
            if order > 0 {
                value = graph.forward(&[value], &along)[0];
            }
            all.push(((order, None), value));
            let slopes = gradient(&mut graph, shape, &[(value, one)], variables);
            all.extend(slopes.into_iter().map(|(slot, slope)| ((order, Some(slot)), slope)));
        }
        Labelled::new(&mut graph, template.parameters + shape.p, all)
    }
}

/// The derivatives of a weighted sum of nodes.
pub fn gradient(graph: &mut Graph, shape: Shape, weighted: &[(Node, Node)], variables: &[Slot]) -> Vec<(Slot, Node)> {
    let arguments = shape.nodes(graph, variables);
    variables.iter().copied().zip(graph.reverse(weighted, &arguments)).collect()
}

/// The changes of nodes along a direction.
pub fn changes<T>(graph: &mut Graph, all: impl IntoIterator<Item = (T, Node)>, along: &[(Node, Node)]) -> Vec<(T, Node)> {
    let (of, nodes): (Vec<T>, Vec<Node>) = all.into_iter().unzip();
    of.into_iter().zip(graph.forward(&nodes, along)).collect()
}

/// Removes the results that vanish; returns the labels and the nodes of the others.
pub fn without_zeros<T>(graph: &Graph, all: impl IntoIterator<Item = (T, Node)>) -> (Vec<T>, Vec<Node>) {
    all.into_iter().filter(|(_, node)| !graph.is_zero(*node)).unzip()
}

/// Arguments with their rates; the rate of a constant is that of its design variable or expression, times the factor of the constant. These factors
/// are parameters, after those of the formula.
///
/// The initial time is fixed, so terms with a zero rate of t are dropped: a load may have an infinite slope there, such as √t at t = 0.
pub(in crate::system) fn tangents(
    graph: &mut Graph,
    (shape, parameters): (Shape, usize),
    slots: &[Slot],
) -> Vec<(Node, Node)> {
    let mut tangent = |&slot: &Slot| {
        let rate = graph.input(shape.rate(slot));
        let rate = match slot {
            Slot::T => graph.unless_zero(rate),
            Slot::B(p) => {
                let factor = graph.parameter(parameters + p);
                graph.multiply(factor, rate)
            }
            _ => rate,
        };
        (shape.node(graph, slot), rate)
    };
    slots.iter().map(&mut tangent).collect()
}
