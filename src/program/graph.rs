//! [`Graph`]: a formula as an expression graph.
//!
//! An operation on the same arguments is always the same node. Operations are simplified when they are recorded
//! ([`simplify`](super::simplify)). Arguments precede the operations that use them, so the nodes can be computed in
//! their order.
//!
//! While a formula is recorded, zeros keep their signs: atan2(0, −1) is π, and atan2(−0, −1) is −π. Then nodes whose sign no function depends on are
//! created again, and derivatives are added, with rules that hold except for the sign of a zero: 0 x = 0, x + 0 = x, 0 − x = −x.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::expression::{Expression, Node};
use super::function::Function;

/// One or more formulas with their derivatives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    expressions: Vec<Expression>,
    /// Whether a node depends on constants and parameters alone.
    fixed: Vec<bool>,
    /// True for a node whose value keeps the sign of a zero.
    signed: Vec<bool>,
    pub(super) numbers: Map<Expression, Node>,
    /// For kept values and sums of them: the condition without which they are 0.
    pub(super) conditions: Map<Node, Node>,
    /// True if nodes are made without regard to the signs of zeros.
    pub(super) is_loose: bool,
    /// Nodes whose values the formula read while it was recorded.
    looked_at: Vec<Node>,
}

/// A fast hash of a few small numbers. Keys are internal, so nobody can choose them to collide.
#[derive(Clone, Debug, Default)]
pub(super) struct Mixer(u64);

/// A map whose keys are small numbers.
pub(super) type Map<K, V> = HashMap<K, V, BuildHasherDefault<Mixer>>;

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 29
    }
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(u64::from(byte)));
    }
    fn write_u32(&mut self, x: u32) {
        self.write_u64(u64::from(x));
    }
    fn write_u64(&mut self, x: u64) {
        // Odd, with irregular binary digits: 2⁶⁴ divided by the golden ratio.
        self.0 = (self.0.rotate_left(23) ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
    fn write_isize(&mut self, x: isize) {
        self.write_u64(x as u64);
    }
}

impl Graph {
    /// The graph for derivatives, which do not depend on the signs of zeros.
    pub(crate) fn loose(self) -> Self {
        Graph { is_loose: true, ..self }
    }

    /// The graph of some results, in which nodes whose sign no function depends on are created again; also returns the results in it.
    pub(super) fn loosened(&self, results: &[Node]) -> (Self, Vec<Node>) {
        let seen = self.sees_signs(results);
        let (graph, map) = self.remade(results.iter().copied(), |node| !seen[node.index()]);
        (graph, results.iter().map(|node| map[node.index()]).collect())
    }

    /// The graph of some results alone, in which constants precede the first node that needs them; also returns the results in it.
    #[cfg(feature = "files")]
    pub(crate) fn tidied(&self, results: &[Node]) -> (Self, Vec<Node>) {
        let (graph, map) = self.remade(results.iter().copied(), |_| false);
        (graph, results.iter().map(|node| map[node.index()]).collect())
    }

    /// The graph without the signs of zeros, on which derivatives do not depend; keeps the values read, and returns the results in it.
    pub(crate) fn without_signs(&self, results: &[Node]) -> (Self, Vec<Node>) {
        let (mut graph, map) = self.remade(results.iter().chain(&self.looked_at).copied(), |_| true);
        graph.looked_at = self.looked_at.iter().map(|node| map[node.index()]).collect();
        (graph, results.iter().map(|node| map[node.index()]).collect())
    }

    /// Creates the given nodes and their arguments again, with or without the signs of zeros, and maps old nodes to new ones.
    fn remade(&self, of: impl Iterator<Item = Node>, is_loose: impl Fn(Node) -> bool) -> (Self, Vec<Node>) {
        let (mut graph, mut map) = (Graph::default(), vec![Node(u32::MAX); self.len()]);
        for node in self.with_late_constants(self.reachable(of)) {
            graph.is_loose = is_loose(node);
            map[node.index()] = graph.make(self.expression(node).map(|x| map[x.index()]));
        }
        (graph, map)
    }

    /// The nodes in an order in which constants precede the first node that needs them, wherever they were recorded, so that formulas with the same
    /// operations are alike.
    fn with_late_constants(&self, nodes: Vec<Node>) -> Vec<Node> {
        let is_constant = |node: &Node| self.value(*node).is_some();
        let (constants, operations): (Vec<Node>, Vec<Node>) = nodes.into_iter().partition(is_constant);
        let mut is_placed = vec![false; self.len()];
        let mut place = |node: &Node| !std::mem::replace(&mut is_placed[node.index()], true);
        let mut ordered = Vec::with_capacity(constants.len() + operations.len());
        for node in operations {
            ordered.extend(self.expression(node).arguments().filter(is_constant).filter(&mut place));
            ordered.push(node);
        }
        // Results may be constants.
        ordered.extend(constants.into_iter().filter(place));
        ordered
    }

    /// Whether nodes are 0 for all arguments if `node` has the value `end`, an argument of it.
    pub(super) fn vanish_at(&self, of: &[Node], node: Node, end: Node) -> bool {
        let (mut graph, mut map) = (Graph::default().loose(), vec![Node(u32::MAX); self.len()]);
        for x in self.reachable(of.iter().copied().chain([end])) {
            let value = if x == node { end } else { x };
            map[x.index()] = graph.make(self.expression(value).map(|x| map[x.index()]));
        }
        of.iter().all(|x| graph.is_zero(map[x.index()]))
    }

    /// Keeps the signs of zeros in exactly those nodes whose sign the results depend on.
    pub(super) fn keep_signs(&mut self, results: &[Node]) {
        self.signed = self.sees_signs(results);
    }

    /// Whether the sign of a zero is kept in a node.
    pub(super) fn is_signed(&self, node: Node) -> bool {
        self.signed[node.index()]
    }

    pub(crate) fn len(&self) -> usize {
        self.expressions.len()
    }

    /// The nodes whose values the formula read, in order.
    pub(crate) fn looked_at(&self) -> &[Node] {
        &self.looked_at
    }

    /// Records that the formula read the value of a node; returns whether this value can vary.
    pub(super) fn look_at(&mut self, node: Node) -> bool {
        let varies = self.value(node).is_none();
        if varies {
            self.looked_at.push(node);
        }
        varies
    }

    pub(crate) fn expressions(&self) -> impl Iterator<Item = Expression> {
        self.expressions.iter().copied()
    }

    pub(crate) fn expression(&self, node: Node) -> Expression {
        self.expressions[node.0 as usize]
    }

    /// For every node, whether it depends on constants and parameters only.
    pub(super) fn fixed(&self) -> Vec<bool> {
        self.fixed.clone()
    }

    /// Whether the node depends on constants and parameters only.
    pub(crate) fn is_fixed(&self, node: Node) -> bool {
        self.fixed[node.0 as usize]
    }

    /// The value of the node if it is a number.
    pub(crate) fn value(&self, node: Node) -> Option<f64> {
        match self.expression(node) {
            Expression::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(crate) fn is_zero(&self, node: Node) -> bool {
        self.value(node) == Some(0.0)
    }

    pub(super) fn put(&mut self, expression: Expression) -> Node {
        let next = Node(self.expressions.len() as u32);
        let node = *self.numbers.entry(expression).or_insert(next);
        if node == next {
            let fixed = match expression {
                Expression::Input(_) => false,
                _ => expression.arguments().all(|x| self.is_fixed(x)),
            };
            self.expressions.push(expression);
            self.fixed.push(fixed);
            self.signed.push(false);
        }
        self.signed[node.index()] |= !self.is_loose;
        node
    }

    pub(crate) fn constant(&mut self, x: f64) -> Node {
        // All NaN are one constant, whatever their bits.
        let x = if x.is_nan() { f64::NAN } else { x };
        self.put(Expression::Constant(if self.is_loose { x + 0.0 } else { x }.to_bits()))
    }

    pub(crate) fn parameter(&mut self, which: usize) -> Node {
        self.put(Expression::Parameter(which as u32))
    }

    pub(crate) fn input(&mut self, which: usize) -> Node {
        self.put(Expression::Input(which as u32))
    }

    /// The node whose negative this is.
    pub(crate) fn negated(&self, node: Node) -> Option<Node> {
        match self.expression(node) {
            Expression::Of(Function::Negative, x) => Some(x),
            _ => None,
        }
    }

    /// Whether one of two nodes is the negative of the other.
    pub(crate) fn are_opposite(&self, x: Node, y: Node) -> bool {
        self.negated(x) == Some(y) || self.negated(y) == Some(x)
    }

    /// The fixed factor of a product, and the other factor.
    pub(super) fn fixed_factor(&self, node: Node) -> Option<(Node, Node)> {
        match self.expression(node) {
            Expression::Multiply(x, y) if self.is_fixed(x) && !self.is_fixed(y) => Some((x, y)),
            _ => None,
        }
    }

    /// The numerical factor of a product, and the other factor.
    pub(crate) fn number_times(&self, node: Node) -> Option<(f64, Node)> {
        let (factor, other) = self.fixed_factor(node)?;
        Some((self.value(factor)?, other))
    }
}
