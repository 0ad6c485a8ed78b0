//! What the nodes of a [`Graph`] depend on, and what follows from it for their derivatives.

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;

impl Graph {
    /// The nodes that some depend on, these included, in an order in which they can be computed.
    pub(crate) fn reachable(&self, from: impl IntoIterator<Item = Node>) -> Vec<Node> {
        let mut reached = vec![false; self.len()];
        from.into_iter().for_each(|node| reached[node.0 as usize] = true);
        for i in (0..self.len()).rev() {
            if reached[i] {
                self.expression(Node(i as u32)).arguments().for_each(|x| reached[x.0 as usize] = true);
            }
        }
        (0..self.len()).filter(|&i| reached[i]).map(|i| Node(i as u32)).collect()
    }

    /// Whether any of these depends on inputs by a sign, a comparison or an angle, of which derivatives may show nothing: that of (x, x) steps.
    pub(crate) fn is_piecewise(&self, nodes: impl IntoIterator<Item = Node>) -> bool {
        let is_step = |node| {
            matches!(self.expression(node), Expression::Of(Function::Sign, _) | Expression::Less(..) | Expression::Atan2(..))
        };
        self.reachable(nodes).into_iter().any(|node| is_step(node) && !self.is_fixed(node))
    }

    /// Whether any of these may be undefined where its derivatives by the first inputs are not: logarithms, and what does not depend on these.
    pub(crate) fn is_partly_defined(&self, nodes: &[Node], inputs: usize) -> bool {
        let mut moves = vec![false; self.len()];
        let mut is_partial = |node: Node| {
            let expression = self.expression(node);
            let is_first = matches!(expression, Expression::Input(which) if (which as usize) < inputs);
            moves[node.index()] = is_first || expression.arguments().any(|x| moves[x.index()]);
            match expression {
                Expression::Constant(bits) => !f64::from_bits(bits).is_finite(),
                Expression::Of(Function::Ln | Function::Ln1p, _) => true,
                Expression::Of(Function::Sqrt | Function::Asin | Function::Acos | Function::Reciprocal, x) => {
                    !moves[x.index()]
                }
                Expression::IntegerPower(x, n) => n < 0 && !moves[x.index()],
                Expression::Power(..) | Expression::Divide(..) => !moves[node.index()],
                _ => false,
            }
        };
        self.reachable(nodes.iter().copied()).into_iter().any(&mut is_partial)
    }

    /// The inputs that a node depends on.
    pub(crate) fn inputs_of(&self, node: Node) -> Vec<usize> {
        let nodes = self.reachable([node]);
        let inputs = nodes.into_iter().filter_map(|node| match self.expression(node) {
            Expression::Input(which) => Some(which as usize),
            _ => None,
        });
        inputs.collect()
    }

    /// What some nodes are made of at every point: inputs, and nodes that are fixed.
    pub(super) fn edge(&self, of: &[Node]) -> Vec<Node> {
        let node = |i: usize| Node(i as u32);
        let mut needed = vec![false; self.len()];
        of.iter().for_each(|node| needed[node.index()] = true);
        for i in (0..self.len()).rev().filter(|&i| !self.is_fixed(node(i))) {
            if needed[i] {
                self.expression(node(i)).arguments().for_each(|x| needed[x.index()] = true);
            }
        }
        let is_input = |node| matches!(self.expression(node), Expression::Input(_));
        let needed = (0..self.len()).filter(|&i| needed[i]).map(node);
        needed.filter(|&node| self.is_fixed(node) || is_input(node)).collect()
    }
}
