//! [`Expression`]: the operation and the arguments of one node of a graph.

use super::function::Function;

/// A node, identified by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Node(pub(super) u32);

impl Node {
    /// The index of the node in a list of the values of all nodes.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// The operation that computes a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Expression {
    /// A number, by its bits.
    Constant(u64),
    /// A quantity that is constant while a motion is computed: a constant of the element.
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
    /// xⁿ for a fixed n in the slope of a higher power; products of its slope with a factor that vanishes are 0, even if the slope is infinite.
    SlopePower(Node, Node),
    /// The angle of the point (x, y); the arguments are y and x.
    Atan2(Node, Node),
    Max(Node, Node),
    Min(Node, Node),
    /// 1 if the first is less than the second, 0 otherwise.
    Less(Node, Node),
    /// The second if the first is not 0, otherwise 0, whatever the second is.
    Where(Node, Node),
    /// The product, but 0 where the second vanishes, whatever the first is.
    Vanishing(Node, Node),
}

impl Expression {
    /// The index of the input, if the expression is one.
    pub(crate) fn input(self) -> Option<usize> {
        if let Expression::Input(which) = self { Some(which as usize) } else { None }
    }

    /// The arguments of the expression.
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

    /// The arguments, without duplicates: a square has one.
    pub(crate) fn distinct_arguments(self) -> impl Iterator<Item = Node> {
        let mut last = None;
        self.arguments().filter(move |&x| last.replace(x) != Some(x))
    }

    /// The same operation with other arguments.
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
