//! [`Expression`]: how one node of a graph is made of others.

use super::function::Function;

/// A node, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Node(pub(super) u32);

impl Node {
    /// Its place among the values of all nodes.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// How a node is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Expression {
    /// A number, by its bits.
    Constant(u64),
    /// A number that is fixed while a motion is computed: a constant of the element.
    Parameter(u32),
    /// An argument that varies along a motion.
    Input(u32),
    Of(Function, Node),
    Add(Node, Node),
    Subtract(Node, Node),
    Multiply(Node, Node),
    Divide(Node, Node),
    /// xⁿ for an integer n.
    IntegerPower(Node, i32),
    /// xⁿ for a fixed n.
    Power(Node, Node),
    /// The same in the slope of a higher power: where its own slope is infinite, what vanishes does so beside it.
    SlopePower(Node, Node),
    /// The angle of the point (x, y), of y and x.
    Atan2(Node, Node),
    Max(Node, Node),
    Min(Node, Node),
    /// 1 where the first is less than the second, 0 elsewhere.
    Less(Node, Node),
    /// The second where the first is not 0, and 0 elsewhere, whatever the second is there.
    Where(Node, Node),
    /// The product, and 0 where the second vanishes, whatever the first is there.
    Vanishing(Node, Node),
}

impl Expression {
    /// The nodes that it is made of.
    pub(crate) fn arguments(self) -> impl DoubleEndedIterator<Item = Node> {
        use Expression::*;
        let (first, second) = match self {
            Constant(_) | Parameter(_) | Input(_) => (None, None),
            Of(_, x) | IntegerPower(x, _) => (Some(x), None),
            Add(x, y) | Subtract(x, y) | Multiply(x, y) | Divide(x, y) => (Some(x), Some(y)),
            Power(x, y) | SlopePower(x, y) => (Some(x), Some(y)),
            Atan2(x, y) | Max(x, y) | Min(x, y) | Less(x, y) | Where(x, y) | Vanishing(x, y) => (Some(x), Some(y)),
        };
        first.into_iter().chain(second)
    }

    /// The same of other nodes.
    pub(super) fn map(self, f: impl Fn(Node) -> Node) -> Self {
        use Expression::*;
        match self {
            Constant(_) | Parameter(_) | Input(_) => self,
            Of(function, x) => Of(function, f(x)),
            IntegerPower(x, n) => IntegerPower(f(x), n),
            Add(x, y) => Add(f(x), f(y)),
            Subtract(x, y) => Subtract(f(x), f(y)),
            Multiply(x, y) => Multiply(f(x), f(y)),
            Divide(x, y) => Divide(f(x), f(y)),
            Power(x, y) => Power(f(x), f(y)),
            SlopePower(x, y) => SlopePower(f(x), f(y)),
            Atan2(x, y) => Atan2(f(x), f(y)),
            Max(x, y) => Max(f(x), f(y)),
            Min(x, y) => Min(f(x), f(y)),
            Less(x, y) => Less(f(x), f(y)),
            Where(x, y) => Where(f(x), f(y)),
            Vanishing(x, y) => Vanishing(f(x), f(y)),
        }
    }
}
