//! [`Symbol`]: a number that records the operations of a formula.

use num_traits::{One, Zero};
use std::cell::RefCell;
use std::fmt;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use super::expression::Node;
use super::function::Function;
use super::graph::Graph;
use crate::Scalar;
use crate::number::{guarded, note_look, take_look};

thread_local! {
    /// The graph of the formula that is being recorded.
    static GRAPH: RefCell<Graph> = RefCell::default();
}

/// A node of the graph of a formula that acts as a number; its value is available to formulas that read it.
#[derive(Clone, Copy)]
pub struct Symbol {
    node: Node,
    value: f64,
}

/// The reason why a formula has no graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// It branches on a value, so the branches not taken are unknown.
    Branches,
    /// It panics while it is recorded.
    Panics,
    /// Its derivatives are too long for a program.
    IsTooLong,
}

/// Records a formula: returns its graph and the nodes of its results.
pub(crate) fn record(formula: impl FnOnce(&mut dyn FnMut(Symbol))) -> Result<(Graph, Vec<Node>), Obstacle> {
    take_look();
    let recorded = record_branch(formula);
    match (recorded, take_look()) {
        (_, true) => Err(Obstacle::Branches),
        (None, false) => Err(Obstacle::Panics),
        (Some(recorded), false) => Ok(recorded),
    }
}

/// As [`record`], for a formula that may branch: records the branch for the symbols' values; `None` if it panics.
pub(crate) fn record_branch(formula: impl FnOnce(&mut dyn FnMut(Symbol))) -> Option<(Graph, Vec<Node>)> {
    GRAPH.set(Graph::default());
    let mut results = Vec::new();
    let done = guarded(|| formula(&mut |result: Symbol| results.push(result.node)));
    let graph = GRAPH.take();
    done.map(|()| (graph, results))
}

impl Symbol {
    /// Input number `which`, with a value.
    pub(crate) fn input(which: usize, value: f64) -> Self {
        Symbol { node: GRAPH.with_borrow_mut(|graph| graph.input(which)), value }
    }

    /// Constant number `which` of an element, with a value.
    pub(crate) fn parameter(which: usize, value: f64) -> Self {
        Symbol { node: GRAPH.with_borrow_mut(|graph| graph.parameter(which)), value }
    }

    /// The value if it is a constant of the formula.
    #[cfg(feature = "files")]
    pub(crate) fn constant(self) -> Option<f64> {
        GRAPH.with_borrow(|graph| graph.value(self.node))
    }

    fn look(&self) -> f64 {
        if GRAPH.with_borrow_mut(|graph| graph.look_at(self.node)) {
            note_look();
        }
        self.value
    }

    fn function(&self, function: Function) -> Self {
        let node = GRAPH.with_borrow_mut(|graph| graph.function(function, self.node));
        Symbol { node, value: function.value(self.value) }
    }

    fn with(&self, other: Symbol, node: fn(&mut Graph, Node, Node) -> Node, value: f64) -> Self {
        Symbol { node: GRAPH.with_borrow_mut(|graph| node(graph, self.node, other.node)), value }
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident $node:ident;)*) => {$(
        impl $operator for Symbol {
            type Output = Symbol;
            fn $method(self, other: Symbol) -> Symbol { self.with(other, Graph::$node, self.value.$method(other.value)) }
        }
        impl $operator<f64> for Symbol {
            type Output = Symbol;
            fn $method(self, other: f64) -> Symbol { self.$method(Symbol::from(other)) }
        }
        impl $assign for Symbol {
            fn $assign_method(&mut self, other: Symbol) { *self = self.$method(other); }
        }
        impl $assign<f64> for Symbol {
            fn $assign_method(&mut self, other: f64) { *self = self.$method(other); }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign add;
    Sub sub SubAssign sub_assign subtract;
    Mul mul MulAssign mul_assign multiply;
    Div div DivAssign div_assign divide;
}

impl Neg for Symbol {
    type Output = Symbol;
    fn neg(self) -> Symbol {
        self.function(Function::Negative)
    }
}

impl From<f64> for Symbol {
    fn from(value: f64) -> Self {
        Symbol { node: GRAPH.with_borrow_mut(|graph| graph.constant(value)), value }
    }
}

impl Zero for Symbol {
    fn zero() -> Self {
        Symbol::from(0.0)
    }
    fn is_zero(&self) -> bool {
        self.look() == 0.0
    }
}

impl One for Symbol {
    fn one() -> Self {
        Symbol::from(1.0)
    }
}

impl Sum for Symbol {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Symbol::zero(), Add::add)
    }
}

impl PartialEq for Symbol {
    fn eq(&self, other: &Self) -> bool {
        self.look() == other.look()
    }
}

impl fmt::Debug for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        // The text shows the value, so the formula could branch on it.
        write!(f, "{}", self.look())
    }
}

macro_rules! functions {
    ($($name:ident $function:ident;)*) => {$(
        fn $name(&self) -> Self { self.function(Function::$function) }
    )*};
}

impl Scalar for Symbol {
    fn re(&self) -> f64 {
        self.look()
    }
    fn powi(&self, n: i32) -> Self {
        let node = GRAPH.with_borrow_mut(|graph| graph.integer_power(self.node, n));
        Symbol { node, value: self.value.powi(n) }
    }
    fn powf(&self, n: f64) -> Self {
        self.with(Symbol::from(n), Graph::power, self.value.powf(n))
    }
    fn sin_cos(&self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn atan2(&self, x: Self) -> Self {
        self.with(x, Graph::atan2, self.value.atan2(x.value))
    }
    fn max(&self, other: Self) -> Self {
        self.with(other, Graph::max, if other.value > self.value { other.value } else { self.value })
    }
    fn min(&self, other: Self) -> Self {
        self.with(other, Graph::min, if other.value < self.value { other.value } else { self.value })
    }
    fn less(&self, other: Self) -> Self {
        self.with(other, Graph::less, f64::from(u8::from(self.value < other.value)))
    }
    fn keep_where(&self, x: Self) -> Self {
        self.with(x, Graph::keep_where, if self.value == 0.0 { 0.0 } else { x.value })
    }
    functions! {
        recip Reciprocal; sqrt Sqrt; exp Exp; exp_m1 ExpM1; ln Ln; ln_1p Ln1p; sin Sin; cos Cos; tan Tan; asin Asin; acos Acos; atan Atan;
        sinh Sinh; cosh Cosh; tanh Tanh; abs Abs; signum Sign;
    }
}
