//! [`Branches`]: derivatives of an element without a program, from the graphs of the branches that its formula takes along a motion.
//!
//! A formula that branches on values is recorded along the branch of the current state, and the graph of this branch contains all derivatives
//! there. The graph is evaluated node by node.

use crate::Error;
use crate::program::{Graph, Node, Template};
use crate::system::cost::CostRows;
use crate::system::formula::{Argument, Element, Layout, NodeView, PlacedElement, changes_along};

/// The number of branches that are kept; a formula may take a different branch at every state.
const MOST: usize = 32;

/// The branches that were encountered last.
pub(in crate::system) struct Branches {
    pub(in crate::system) element: usize,
    bound: Vec<bool>,
    known: Vec<Branch>,
}

/// Directional derivatives of the derivatives of c·f + e·g on one branch, and the argument and factor of each.
struct Branch {
    template: Template,
    graph: Graph,
    changes: Vec<Node>,
    of: Vec<(Argument, f64)>,
}

impl Branches {
    pub(in crate::system) fn new(element: usize, bound: &[bool]) -> Self {
        Branches { element, bound: bound.to_vec(), known: Vec::new() }
    }

    /// Adds the directional derivatives at a state; `point` contains its arguments and the direction.
    ///
    /// # Errors
    /// The formula panics while it is recorded.
    pub(in crate::system) fn pull_back(
        &mut self,
        (element, item): (&Element, &PlacedElement),
        at: &NodeView<f64>,
        (layout, point): (&Layout, &[f64]),
        rows: &mut CostRows,
    ) -> Result<(), Error> {
        let Some((template, numbers)) = item.record_branch(at) else {
            let of = format!("costs on accelerations or reactions where the formula of `{}` panics", element.name);
            return Err(Error::NoSecondDerivatives { of });
        };
        let shape = element.formula.shape;
        let recorded = Element { numbers, ..element.clone() };
        let parameters = recorded.with_factors(at.design);
        let argument = |which: usize| point.get(layout.source(&element.to, shape.place(which))).copied().unwrap_or(0.0);
        let arguments: Vec<f64> = (0..shape.len()).map(argument).collect();
        let branch = self.branch(element, template);
        let values = branch.graph.evaluate(&parameters, &arguments);
        for (&(argument, factor), node) in branch.of.iter().zip(&branch.changes) {
            rows.add(argument, factor * values[node.index()]);
        }
        Ok(())
    }

    fn branch(&mut self, element: &Element, template: Template) -> &Branch {
        let known = self.known.iter().position(|branch| branch.template == template);
        let which = known.unwrap_or_else(|| {
            if self.known.len() == MOST {
                self.known.remove(0);
            }
            let (graph, changes) = changes_along(element.kind(), element.formula.shape, &template, &self.bound);
            let (of, changes) = changes.into_iter().map(|(slot, node)| (element.to.argument(slot), node)).unzip();
            self.known.push(Branch { template, graph, changes, of });
            self.known.len() - 1
        });
        &self.known[which]
    }
}
