//! The arguments of formulas, numbered consecutively.

use crate::program::{Graph, Node};

/// An argument of a formula, by its number within the element or the cost, or [within the scene](Argument).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Slot {
    Q(usize),
    V(usize),
    // Of costs alone, as u̇.
    PStar(usize),
    PStarDot(usize),
    VDot(usize),
    Lambda(usize),
    Sigma(usize),
    U(usize),
    UDot(usize),
    /// A constant; in the scene, a design variable or an expression of design variables.
    B(usize),
    T,
}

/// An argument in the numbering of the scene.
pub type Argument = Slot;

/// The number of lists of arguments: one for each variant of [`Slot`], in their order.
pub const LISTS: usize = 11;

impl Slot {
    /// The arguments of each list.
    pub const ALL: [fn(usize) -> Slot; LISTS] = [
        Slot::Q,
        Slot::V,
        Slot::PStar,
        Slot::PStarDot,
        Slot::VDot,
        Slot::Lambda,
        Slot::Sigma,
        Slot::U,
        Slot::UDot,
        Slot::B,
        |_| Slot::T,
    ];

    /// The number of its list, and its place there.
    #[inline]
    pub const fn place(self) -> (usize, usize) {
        match self {
            Slot::Q(i) => (0, i),
            Slot::V(i) => (1, i),
            Slot::PStar(i) => (2, i),
            Slot::PStarDot(i) => (3, i),
            Slot::VDot(i) => (4, i),
            Slot::Lambda(j) => (5, j),
            Slot::Sigma(j) => (6, j),
            Slot::U(k) => (7, k),
            Slot::UDot(k) => (8, k),
            Slot::B(p) => (9, p),
            Slot::T => (10, 0),
        }
    }
}

/// Removes duplicates.
pub fn distinct(mut arguments: Vec<Argument>) -> Vec<Argument> {
    arguments.sort_unstable();
    arguments.dedup();
    arguments
}

/// An argument of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Of(Slot),
    /// The adjoint variables c, d and e.
    C(usize),
    D(usize),
    E(usize),
    /// The rate of an argument.
    Rate(Slot),
}

/// The numbers of coordinates, equations, controls and constants of an element, a cost, or a scene.
///
/// The arguments are numbered in this order: q, v, p*, ṗ*, v̇ (n each), λ, σ (m), u, u̇ (k), the constants (p), t; then c (n), d (n), e (m) of the adjoint;
/// then the rates of all arguments, in the same order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Shape {
    pub n: usize,
    pub m: usize,
    pub k: usize,
    pub p: usize,
}

impl Shape {
    /// The lengths of the lists of arguments.
    pub const fn lengths(self) -> [usize; LISTS] {
        let Shape { n, m, k, p } = self;
        [n, n, n, n, n, m, m, k, k, p, 1]
    }

    /// The numbers of the first arguments of the lists.
    const fn firsts(self) -> [usize; LISTS] {
        let Shape { n, m, k, p } = self;
        let (lambda, u) = (5 * n, 5 * n + 2 * m);
        [0, n, 2 * n, 3 * n, 4 * n, lambda, lambda + m, u, u + k, u + 2 * k, u + 2 * k + p]
    }

    pub const fn c(self) -> usize {
        5 * self.n + 2 * self.m + 2 * self.k + self.p + 1
    }
    pub const fn d(self) -> usize {
        self.c() + self.n
    }
    pub const fn e(self) -> usize {
        self.d() + self.n
    }
    pub const fn rates(self) -> usize {
        self.e() + self.m
    }
    /// The number of all arguments.
    pub const fn len(self) -> usize {
        self.rates() + self.c()
    }

    /// The number of an argument of the formula itself.
    pub fn number(self, slot: Slot) -> usize {
        let (list, i) = slot.place();
        self.firsts()[list] + i
    }

    /// The number of the rate of an argument.
    pub fn rate(self, slot: Slot) -> usize {
        self.rates() + self.number(slot)
    }

    /// An argument of the formula itself as a node of its graph.
    pub fn node(self, graph: &mut Graph, slot: Slot) -> Node {
        match slot {
            Slot::B(p) => graph.parameter(p),
            _ => graph.input(self.number(slot)),
        }
    }

    /// As [`node`](Self::node), for several arguments.
    pub fn nodes(self, graph: &mut Graph, slots: &[Slot]) -> Vec<Node> {
        slots.iter().map(|slot| self.node(graph, *slot)).collect()
    }

    /// All arguments of the formula itself, in the order of their numbers.
    pub fn slots(self) -> impl Iterator<Item = Slot> {
        Slot::ALL.into_iter().zip(self.lengths()).flat_map(|(of, len)| (0..len).map(of))
    }

    /// The arguments that a cost may read, without constants.
    pub fn of_cost(self) -> impl Iterator<Item = Slot> {
        self.slots().filter(|slot| !matches!(slot, Slot::B(_)))
    }

    /// The arguments that an element may read, without constants.
    pub fn of_element(self) -> impl Iterator<Item = Slot> {
        self.slots().filter(|slot| matches!(slot, Slot::Q(_) | Slot::V(_) | Slot::U(_) | Slot::T))
    }

    /// q, v and σ.
    pub fn states(self) -> Vec<Slot> {
        self.slots().filter(|slot| matches!(slot, Slot::Q(_) | Slot::V(_) | Slot::Sigma(_))).collect()
    }

    /// The argument with a given number.
    pub fn place(self, which: usize) -> Place {
        let slot = |number: usize| self.slots().nth(number).unwrap_or(Slot::T);
        match which {
            i if i < self.c() => Place::Of(slot(i)),
            i if i < self.d() => Place::C(i - self.c()),
            i if i < self.e() => Place::D(i - self.d()),
            i if i < self.rates() => Place::E(i - self.e()),
            i => Place::Rate(slot(i - self.rates())),
        }
    }
}

/// The constants that are design variables.
pub(in crate::system) fn bound_constants(bound: &[bool]) -> Vec<Slot> {
    (0..bound.len()).filter(|&p| bound[p]).map(Slot::B).collect()
}
