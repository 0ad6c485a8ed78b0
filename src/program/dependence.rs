//! The dependences between the nodes of a [`Graph`], and their consequences for derivatives.

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;

impl Graph {
    /// The given nodes and all nodes on which they depend, in an order in which they can be computed.
    pub(crate) fn reachable(&self, from: impl IntoIterator<Item = Node>) -> Vec<Node> {
        self.reachable_through(from, |_| true)
    }

    /// The same, but only the arguments of `open` nodes are included.
    pub(super) fn reachable_through(&self, from: impl IntoIterator<Item = Node>, open: impl Fn(Node) -> bool) -> Vec<Node> {
        let mut reached = vec![false; self.len()];
        from.into_iter().for_each(|node| reached[node.index()] = true);
        for node in (0..self.len() as u32).rev().map(Node) {
            if reached[node.index()] && open(node) {
                self.expression(node).arguments().for_each(|x| reached[x.index()] = true);
            }
        }
        (0..self.len() as u32).map(Node).filter(|node| reached[node.index()]).collect()
    }

    /// For every node, whether the given nodes depend on the sign of its zero.
    pub(super) fn sees_signs(&self, nodes: &[Node]) -> Vec<bool> {
        use Expression::*;
        let mut seen = vec![false; self.len()];
        for node in self.reachable(nodes.iter().copied()).into_iter().rev() {
            let is_seen = seen[node.index()];
            let [first, second] = match self.expression(node) {
                Atan2(..) => [true; 2],
                Divide(..) => [is_seen, true],
                Of(Function::Reciprocal, _) => [true; 2],
                IntegerPower(_, n) => [n % 2 != 0 && (is_seen || n < 0); 2],
                Power(_, n) | SlopePower(_, n) => [is_seen || self.value(n) < Some(0.0), false],
                Of(Function::Exp | Function::Cos | Function::Cosh | Function::Abs | Function::Sign, _) | Less(..) => {
                    [false; 2]
                }
                Multiply(x, y) => [is_seen && x != y; 2],
                _ => [is_seen; 2],
            };
            for (x, is_seen) in self.expression(node).arguments().zip([first, second]) {
                seen[x.index()] |= is_seen;
            }
        }
        seen
    }

    /// Whether any of the nodes depends on inputs by a sign, a comparison or an angle; derivatives may not show this: the angle of (x, x) is a step.
    pub(crate) fn is_piecewise(&self, nodes: impl IntoIterator<Item = Node>) -> bool {
        let is_step = |node| {
            matches!(self.expression(node), Expression::Of(Function::Sign, _) | Expression::Less(..) | Expression::Atan2(..))
        };
        self.reachable(nodes).into_iter().any(|node| is_step(node) && !self.is_fixed(node))
    }

    /// Whether any of the nodes loses digits if its products are expanded, as (x − r)² for x close to r: it multiplies sums with each other, or a
    /// sum of exact numbers with a quantity that varies.
    pub(crate) fn multiplies_sums(&self, nodes: impl IntoIterator<Item = Node>) -> bool {
        // For every node, whether it contains a sum of varying terms, and whether it contains one of exact numbers.
        let mut sums = vec![[false; 2]; self.len()];
        self.reachable(nodes).into_iter().filter(|&node| !self.is_fixed(node)).any(|node| {
            let of = |x: Node| sums[x.index()];
            let (own, loses) = match self.expression(node) {
                Expression::Add(x, y) | Expression::Subtract(x, y) => {
                    let is_exact = self.is_exact(x) && self.is_exact(y);
                    ([true, is_exact || of(x)[1] || of(y)[1]], false)
                }
                Expression::Of(Function::Negative, x) => (of(x), false),
                Expression::Multiply(x, y) if self.is_fixed(x) || self.is_fixed(y) => {
                    (of(if self.is_fixed(x) { y } else { x }), false)
                }
                Expression::Multiply(x, y) => ([false; 2], of(x)[1] || of(y)[1] || (of(x)[0] && of(y)[0])),
                other => ([false; 2], other.arguments().any(|x| of(x)[0])),
            };
            sums[node.index()] = own;
            loses
        })
    }

    /// Whether a node is free of rounding errors.
    fn is_exact(&self, node: Node) -> bool {
        match self.expression(node) {
            Expression::Input(_) => true,
            Expression::Of(Function::Negative, x) => self.is_exact(x),
            _ => self.is_fixed(node),
        }
    }

    /// Whether any of the nodes may be undefined where derivatives by the first inputs are defined: logarithms, and terms without these inputs.
    pub(crate) fn is_partly_defined(&self, nodes: &[Node], inputs: usize) -> bool {
        let mut moves = vec![false; self.len()];
        let mut is_partial = |node: Node| {
            let expression = self.expression(node);
            let is_first = expression.input().is_some_and(|which| which < inputs);
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

    /// The inputs on which a node depends.
    pub(crate) fn inputs_of(&self, node: Node) -> Vec<usize> {
        self.reachable([node]).into_iter().filter_map(|node| self.expression(node).input()).collect()
    }

    /// The inputs and fixed nodes from which the given nodes are computed at every point.
    pub(super) fn edge(&self, of: &[Node]) -> Vec<Node> {
        let mut needed = self.reachable_through(of.iter().copied(), |node| !self.is_fixed(node));
        needed.retain(|&node| self.is_fixed(node) || self.expression(node).input().is_some());
        needed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a function of x, y, a parameter r and a number loses digits if it is expanded.
    fn loses(formula: fn(&mut Graph, [Node; 4]) -> Node) -> bool {
        let mut graph = Graph::default();
        let (x, y, r, c) = (graph.input(0), graph.input(1), graph.parameter(0), graph.constant(1.5));
        let result = formula(&mut graph, [x, y, r, c]);
        graph.multiplies_sums([result])
    }

    #[test]
    fn squares_of_differences_lose_digits_and_sums_of_products_do_not() {
        // c (x − r)², (x − y) x, (c x − y) (y − x).
        assert!(loses(|graph, [x, _, r, c]| {
            let difference = graph.subtract(x, r);
            let square = graph.multiply(difference, difference);
            graph.multiply(c, square)
        }));
        assert!(loses(|graph, [x, y, ..]| {
            let difference = graph.subtract(x, y);
            graph.multiply(difference, x)
        }));
        assert!(loses(|graph, [x, y, _, c]| {
            let [cx, difference] = [graph.multiply(c, x), graph.subtract(y, x)];
            let sum = graph.subtract(cx, y);
            graph.multiply(sum, difference)
        }));
        // c x y + r y², x (c x + r y).
        assert!(!loses(|graph, [x, y, r, c]| {
            let [xy, yy] = [graph.multiply(x, y), graph.multiply(y, y)];
            let [first, second] = [graph.multiply(c, xy), graph.multiply(r, yy)];
            graph.add(first, second)
        }));
        assert!(!loses(|graph, [x, y, r, c]| {
            let [first, second] = [graph.multiply(c, x), graph.multiply(r, y)];
            let sum = graph.add(first, second);
            graph.multiply(x, sum)
        }));
    }
}
