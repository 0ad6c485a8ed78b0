//! [`Graph`]: a formula as an expression graph.
//!
//! An operation on the same arguments is always the same node. Operations are simplified when they are recorded:
//! constants are folded, signs and fixed factors move outwards. Arguments precede the operations that use them, so
//! the nodes can be computed in their order.
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
    numbers: Map<Expression, Node>,
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

    /// The graph without the signs of zeros, on which derivatives do not depend; keeps the values read, and returns the results in it.
    pub(crate) fn without_signs(&self, results: &[Node]) -> (Self, Vec<Node>) {
        let (mut graph, map) = self.remade(results.iter().chain(&self.looked_at).copied(), |_| true);
        graph.looked_at = self.looked_at.iter().map(|node| map[node.index()]).collect();
        (graph, results.iter().map(|node| map[node.index()]).collect())
    }

    /// Creates the given nodes and their arguments again, with or without the signs of zeros, and maps old nodes to new ones.
    fn remade(&self, of: impl Iterator<Item = Node>, is_loose: impl Fn(Node) -> bool) -> (Self, Vec<Node>) {
        let (mut graph, mut map) = (Graph::default(), vec![Node(u32::MAX); self.len()]);
        for node in self.reachable(of) {
            graph.is_loose = is_loose(node);
            map[node.index()] = graph.make(self.expression(node).map(|x| map[x.index()]));
        }
        (graph, map)
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

    /// Creates the node of an expression, simplified.
    pub(super) fn make(&mut self, expression: Expression) -> Node {
        use Expression::*;
        match expression {
            Constant(_) | Parameter(_) | Input(_) => self.put(expression),
            Of(function, x) => self.function(function, x),
            Add(x, y) => self.add(x, y),
            Subtract(x, y) => self.subtract(x, y),
            Multiply(x, y) => self.multiply(x, y),
            Divide(x, y) => self.divide(x, y),
            IntegerPower(x, n) => self.integer_power(x, n),
            Power(x, n) => self.power(x, n),
            SlopePower(x, n) => self.slope_power(x, n),
            Atan2(y, x) => self.atan2(y, x),
            Max(x, y) => self.max(x, y),
            Min(x, y) => self.min(x, y),
            Less(x, y) => self.less(x, y),
            Where(condition, x) => self.keep_where(condition, x),
            Vanishing(x, y) => self.vanishing(x, y),
        }
    }

    pub(crate) fn constant(&mut self, x: f64) -> Node {
        self.put(Expression::Constant(if self.is_loose { x + 0.0 } else { x }.to_bits()))
    }

    /// Whether x + number is x. If signs of zeros matter, 0 is excluded, because −0 + 0 is 0.
    fn adds_nothing(&self, number: f64) -> bool {
        number == 0.0 && (self.is_loose || number.is_sign_negative())
    }

    pub(crate) fn parameter(&mut self, which: usize) -> Node {
        self.put(Expression::Parameter(which as u32))
    }

    pub(crate) fn input(&mut self, which: usize) -> Node {
        self.put(Expression::Input(which as u32))
    }

    /// The node whose negative this is.
    fn negated(&self, node: Node) -> Option<Node> {
        match self.expression(node) {
            Expression::Of(Function::Negative, x) => Some(x),
            _ => None,
        }
    }

    /// Whether the node is the negative of another node.
    pub(crate) fn is_negative(&self, node: Node) -> bool {
        self.negated(node).is_some()
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

    fn negative(&mut self, x: Node) -> Node {
        self.function(Function::Negative, x)
    }

    pub(crate) fn add(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x + y),
            (Some(number), None) if self.adds_nothing(number) => return y,
            (None, Some(number)) if self.adds_nothing(number) => return x,
            _ => {}
        }
        if x == y {
            let two = self.constant(2.0);
            return self.multiply(two, x);
        }
        if let Some(y) = self.negated(y) {
            return self.subtract(x, y);
        }
        if let Some(x) = self.negated(x) {
            return self.subtract(y, x);
        }
        if let Some((condition, [x, y])) = self.both_where(x, y) {
            let sum = self.add(x, y);
            return self.keep_where(condition, sum);
        }
        let sum = self.put(Expression::Add(x.min(y), x.max(y)));
        self.note_condition(sum, [x, y]);
        sum
    }

    pub(crate) fn subtract(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x - y),
            (Some(number), None) if self.adds_nothing(number) => return self.negative(y),
            (None, Some(number)) if self.adds_nothing(-number) => return x,
            _ => {}
        }
        if x == y {
            return self.constant(0.0);
        }
        if let Some(y) = self.negated(y) {
            return self.add(x, y);
        }
        if let Some(x) = self.negated(x).filter(|_| self.is_loose) {
            let sum = self.add(x, y);
            return self.negative(sum);
        }
        if let Some((condition, [x, y])) = self.both_where(x, y) {
            let difference = self.subtract(x, y);
            return self.keep_where(condition, difference);
        }
        if let Some(&difference) = self.numbers.get(&Expression::Subtract(y, x)).filter(|_| self.is_loose) {
            return self.negative(difference);
        }
        let difference = self.put(Expression::Subtract(x, y));
        self.note_condition(difference, [x, y]);
        difference
    }

    pub(crate) fn multiply(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x * y),
            (Some(0.0), None) | (None, Some(0.0)) if self.is_loose => return self.constant(0.0),
            (Some(number), None) | (None, Some(number)) if number == 1.0 || number < 0.0 || self.adds_nothing(number) => {
                let other = if self.value(x).is_some() { y } else { x };
                if number == 1.0 {
                    return other;
                }
                // Signs move outwards, so that products with x and −x are one node.
                let size = self.constant(-number);
                let product = self.multiply(size, other);
                return self.negative(product);
            }
            _ => {}
        }
        if let Some(x) = self.negated(x) {
            let product = self.multiply(x, y);
            return self.negative(product);
        }
        if let Some(y) = self.negated(y) {
            let product = self.multiply(x, y);
            return self.negative(product);
        }
        // Fixed factors are collected in front, so that they are multiplied once.
        if let Some((factor, y)) = self.fixed_factor(y) {
            let rest = if self.is_fixed(x) { (self.multiply(x, factor), y) } else { (factor, self.multiply(x, y)) };
            return self.multiply(rest.0, rest.1);
        }
        if let Some((factor, x)) = self.fixed_factor(x) {
            let rest = if self.is_fixed(y) { (self.multiply(factor, y), x) } else { (factor, self.multiply(x, y)) };
            return self.multiply(rest.0, rest.1);
        }
        let (x, y) = if self.is_fixed(x) == self.is_fixed(y) {
            (x.min(y), x.max(y))
        } else if self.is_fixed(x) {
            (x, y)
        } else {
            (y, x)
        };
        self.put(Expression::Multiply(x, y))
    }

    pub(crate) fn divide(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x / y),
            (Some(0.0), None) if self.is_loose => return x,
            (Some(1.0), None) => return self.function(Function::Reciprocal, y),
            _ => {}
        }
        if self.is_fixed(y) {
            let reciprocal = self.function(Function::Reciprocal, y);
            return self.multiply(reciprocal, x);
        }
        if let Some(x) = self.negated(x) {
            let quotient = self.divide(x, y);
            return self.negative(quotient);
        }
        if let Some(y) = self.negated(y) {
            let quotient = self.divide(x, y);
            return self.negative(quotient);
        }
        self.put(Expression::Divide(x, y))
    }

    pub(crate) fn function(&mut self, function: Function, x: Node) -> Node {
        if let Some(value) = self.value(x) {
            return self.constant(function.value(value));
        }
        match (function, self.expression(x)) {
            (Function::Negative, Expression::Of(Function::Negative, x)) => return x,
            (_, Expression::Of(Function::Negative, x)) if function.is_odd() => {
                let y = self.function(function, x);
                return self.negative(y);
            }
            (_, Expression::Of(Function::Negative, x)) if function.is_even() => return self.function(function, x),
            _ => {}
        }
        self.put(Expression::Of(function, x))
    }

    pub(crate) fn integer_power(&mut self, x: Node, n: i32) -> Node {
        if let Some(value) = self.value(x) {
            return self.constant(value.powi(n));
        }
        match n {
            0 => self.constant(1.0),
            1 => x,
            2 => self.multiply(x, x),
            3 => {
                let square = self.multiply(x, x);
                self.multiply(square, x)
            }
            -1 => self.function(Function::Reciprocal, x),
            _ => self.put(Expression::IntegerPower(x, n)),
        }
    }

    pub(crate) fn power(&mut self, x: Node, n: Node) -> Node {
        match (self.value(x), self.value(n)) {
            (Some(x), Some(n)) => self.constant(x.powf(n)),
            (_, Some(0.0)) => self.constant(1.0),
            (_, Some(1.0)) => x,
            _ => self.put(Expression::Power(x, n)),
        }
    }

    /// xⁿ in the slope of a higher power.
    pub(super) fn slope_power(&mut self, x: Node, n: Node) -> Node {
        match self.value(n) {
            Some(0.0 | 1.0) => self.power(x, n),
            _ => self.put(Expression::SlopePower(x, n)),
        }
    }

    pub(crate) fn atan2(&mut self, y: Node, x: Node) -> Node {
        match (self.value(y), self.value(x)) {
            (Some(y), Some(x)) => self.constant(y.atan2(x)),
            _ => self.put(Expression::Atan2(y, x)),
        }
    }

    pub(crate) fn max(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => self.constant(if y > x { y } else { x }),
            _ => self.put(Expression::Max(x, y)),
        }
    }

    pub(crate) fn min(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => self.constant(if y < x { y } else { x }),
            _ => self.put(Expression::Min(x, y)),
        }
    }

    pub(super) fn less(&mut self, x: Node, y: Node) -> Node {
        self.put(Expression::Less(x, y))
    }

    /// x y, which is 0 where y is, even if x is infinite.
    pub(super) fn vanishing(&mut self, x: Node, y: Node) -> Node {
        if self.value(x).or(self.value(y)).is_some() { self.multiply(x, y) } else { self.put(Expression::Vanishing(x, y)) }
    }
}
