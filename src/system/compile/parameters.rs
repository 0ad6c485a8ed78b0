//! The values of parameters: the design variables b, followed by the expressions of them that serve as parameters of elements.
//!
//! Elements, their derivatives and the sums of the adjoint sweep use only these values z(b). They are computed when a motion begins; after the
//! adjoint sweep, dJ/db = (∂z/∂b)ᵀ dJ/dz.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::OnceLock;

use crate::error::quoted;
use crate::model::Param;
use crate::program::{Graph, Node};
use crate::{Error, Scalar};

pub(crate) struct Parameters {
    designs: usize,
    /// The expressions in use as nodes of the graph, and the index of each among them.
    nodes: Vec<Node>,
    places: HashMap<Node, usize>,
    graph: Graph,
    /// The graph of Σ wⱼ ∂zⱼ/∂b over the expressions z, with w as further inputs. The order of its sums does not depend on that in which the expressions
    /// were recorded.
    pulled_back: (Graph, Vec<Node>),
    /// The expressions in use as nodes of this graph.
    canonical: Vec<Node>,
    /// The derivatives of z along a direction of b, then those of Σ wⱼ ∂zⱼ/∂b along a direction of b and w, with the directions as further inputs;
    /// created when first needed.
    along: OnceLock<(Graph, Vec<Node>)>,
}

impl Parameters {
    /// Parameters of a scene with this number of design variables and this graph of expressions; no expression is in use yet.
    pub(in crate::system) fn new(designs: usize, graph: Graph) -> Self {
        let (nodes, places, canonical) = (Vec::new(), HashMap::new(), Vec::new());
        Parameters { designs, nodes, places, graph, pulled_back: Default::default(), canonical, along: OnceLock::new() }
    }

    /// The same parameter, referring to its index among the values.
    pub(in crate::system) fn resolve(&mut self, param: Param, gravity: &[Param; 3]) -> Param {
        let (designs, nodes, places) = (self.designs, &mut self.nodes, &mut self.places);
        param.resolve(gravity, &mut |node| {
            let place = places.entry(node).or_insert_with(|| {
                nodes.push(node);
                nodes.len() - 1
            });
            designs + *place
        })
    }

    /// Differentiates the expressions in use.
    pub(in crate::system) fn differentiate(&mut self) {
        let (graph, canonical) = self.graph.canonical(&self.nodes);
        let mut graph = graph.loose();
        let weighted: Vec<_> = canonical.iter().enumerate().map(|(j, y)| (*y, graph.input(self.designs + j))).collect();
        let inputs: Vec<Node> = (0..self.designs).map(|p| graph.input(p)).collect();
        let nodes = if self.nodes.is_empty() { Vec::new() } else { graph.reverse(&weighted, &inputs) };
        (self.pulled_back, self.canonical) = ((graph, nodes), canonical);
    }

    fn tangent(&self) -> &(Graph, Vec<Node>) {
        self.along.get_or_init(|| {
            let ((mut graph, nodes), len) = (self.pulled_back.clone(), self.len());
            let directions: Vec<_> = (0..len).map(|i| (graph.input(i), graph.input(len + i))).collect();
            let changes = graph.forward(&[&self.canonical[..], &nodes].concat(), &directions);
            (graph, changes)
        })
    }

    /// The number of values.
    pub(crate) fn len(&self) -> usize {
        self.designs + self.nodes.len()
    }

    /// z(b).
    pub(crate) fn values<'a, S: Scalar>(&self, design: &'a [S]) -> Cow<'a, [S]> {
        if self.nodes.is_empty() {
            return Cow::Borrowed(design);
        }
        let all = self.graph.evaluate(&[], design);
        design.iter().copied().chain(self.nodes.iter().map(|node| all[node.index()])).collect()
    }

    /// True unless the parameter is an expression that was made after the scene was compiled.
    pub(crate) fn has(&self, param: Param) -> bool {
        let mut node = None;
        param.resolve(&[0.0.into(); 3], &mut |of| *node.insert(of.index()));
        node.is_none_or(|node| node < self.graph.len())
    }

    /// The value of a parameter before `resolve`, which need not be used by any element.
    pub(crate) fn value_of(&self, param: Param, values: &[f64]) -> f64 {
        if let Some(number) = param.constant() {
            return number;
        }
        let designs = &values[..self.designs];
        param.present_value(designs, &self.graph.evaluate(&[], designs))
    }

    /// (∂z/∂b)ᵀ w at b.
    pub(crate) fn pull_back(&self, design: &[f64], w: &[f64], gradient: &mut [f64]) {
        gradient.copy_from_slice(&w[..self.designs]);
        let (graph, nodes) = &self.pulled_back;
        if nodes.is_empty() {
            return;
        }
        let all = graph.evaluate(&[], &[design, &w[self.designs..]].concat());
        gradient.iter_mut().zip(nodes).for_each(|(sum, node)| *sum += all[node.index()]);
    }

    // Graphs are used instead of dual numbers, which yield 0 · ∞ for √max(b, 0) at b < 0.

    /// The derivative of z(b) along a direction of b.
    pub(crate) fn along(&self, design: &[f64], direction: &[f64]) -> Vec<f64> {
        let zeros = vec![0.0; self.nodes.len()];
        let (graph, nodes) = self.tangent();
        let all = graph.evaluate(&[], &[design, &zeros, direction, &zeros].concat());
        direction.iter().copied().chain(nodes[..self.nodes.len()].iter().map(|node| all[node.index()])).collect()
    }

    /// The derivative of (∂z/∂b)ᵀ w along a direction of b and w.
    pub(crate) fn pull_back_along(&self, [design, w]: [&[f64]; 2], [direction, w_dot]: [&[f64]; 2], gradient: &mut [f64]) {
        gradient.copy_from_slice(&w_dot[..self.designs]);
        let (graph, nodes) = self.tangent();
        let all = graph.evaluate(&[], &[design, &w[self.designs..], direction, &w_dot[self.designs..]].concat());
        gradient.iter_mut().zip(&nodes[self.nodes.len()..]).for_each(|(sum, node)| *sum += all[node.index()]);
    }

    /// The name of a value, composed of the names of design variables.
    pub(in crate::system) fn name(&self, place: usize, designs: &[String]) -> String {
        let Some(expression) = place.checked_sub(self.designs) else { return quoted(&designs[place]) };
        let inputs = self.graph.inputs_of(self.nodes[expression]);
        let list: Vec<String> = inputs.into_iter().map(|p| quoted(&designs[p])).collect();
        format!("an expression of {}", list.join(", "))
    }

    /// Checks that all expressions are finite.
    pub(in crate::system) fn check(&self, values: &[f64], designs: &[String]) -> Result<(), Error> {
        match values.iter().enumerate().skip(self.designs).find(|(_, value)| !value.is_finite()) {
            Some((place, &value)) => Err(Error::NotFinite { what: self.name(place, designs), value }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scenes::CartPendulum;
    use crate::{Grid, Inputs, Settings, Solver};

    #[test]
    fn what_only_directions_need_is_made_when_one_is_asked_for() -> Result<(), crate::Error> {
        let system = CartPendulum::default().scene().compile()?;
        let inputs = Inputs::at_rest(&system, Grid::uniform(2, 0.01));
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs)?;
        solver.gradient()?;
        assert!(system.parameters().along.get().is_none());
        solver.hessian_product(&inputs.no_change())?;
        assert!(system.parameters().along.get().is_some());
        Ok(())
    }
}
