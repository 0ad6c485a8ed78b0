//! The arguments of formulas, numbered consecutively.

use crate::program::{Graph, Node};

/// An argument of a formula, by its number within the element or the cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Slot {
    Q(usize),
    V(usize),
    Sigma(usize),
    U(usize),
    T,
    /// A constant.
    B(usize),
    // Of costs alone.
    PStar(usize),
    PStarDot(usize),
    VDot(usize),
    Lambda(usize),
    UDot(usize),
}

/// An argument of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Of(Slot),
    /// The adjoint variables c, d and e.
    C(usize),
    D(usize),
    E(usize),
    /// The rate of an argument of an element.
    Rate(Slot),
}

/// The numbers of coordinates, equations, controls and constants of an element or a cost.
///
/// The arguments are numbered in this order: q (n), v (n), u (k), t; then σ (m), and c (n), d (n), e (m) of the adjoint; then the rates of q, v, σ, u and t,
/// and those of the constants (p); then the constants (p), and p*, ṗ*, v̇ (n each), λ (m) and u̇ (k).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shape {
    pub n: usize,
    pub m: usize,
    pub k: usize,
    pub p: usize,
}

impl Shape {
    pub const fn v(self) -> usize {
        self.n
    }
    pub const fn u(self) -> usize {
        2 * self.n
    }
    pub const fn t(self) -> usize {
        2 * self.n + self.k
    }
    pub const fn sigma(self) -> usize {
        self.t() + 1
    }
    pub const fn c(self) -> usize {
        self.sigma() + self.m
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
    pub const fn constant_rates(self) -> usize {
        self.rates() + self.sigma() + self.m
    }
    const fn constants(self) -> usize {
        self.constant_rates() + self.p
    }
    const fn of_costs(self) -> usize {
        self.constants() + self.p
    }
    /// The number of all arguments.
    pub const fn len(self) -> usize {
        self.of_costs() + 3 * self.n + self.m + self.k
    }

    /// The number of an argument of the formula itself.
    pub const fn number(self, slot: Slot) -> usize {
        match slot {
            Slot::Q(i) => i,
            Slot::V(i) => self.v() + i,
            Slot::Sigma(j) => self.sigma() + j,
            Slot::U(k) => self.u() + k,
            Slot::T => self.t(),
            Slot::B(p) => self.constants() + p,
            Slot::PStar(i) => self.of_costs() + i,
            Slot::PStarDot(i) => self.of_costs() + self.n + i,
            Slot::VDot(i) => self.of_costs() + 2 * self.n + i,
            Slot::Lambda(j) => self.of_costs() + 3 * self.n + j,
            Slot::UDot(k) => self.of_costs() + 3 * self.n + self.m + k,
        }
    }

    /// An argument of the formula itself as a node of its graph.
    pub fn node(self, graph: &mut Graph, slot: Slot) -> Node {
        match slot {
            Slot::B(p) => graph.parameter(p),
            _ => graph.input(self.number(slot)),
        }
    }

    /// The arguments that an element may read, without constants, in the order of their numbers.
    pub fn of_element(self) -> impl Iterator<Item = Slot> {
        let state = (0..self.n).map(Slot::Q).chain((0..self.n).map(Slot::V));
        state.chain((0..self.k).map(Slot::U)).chain([Slot::T])
    }

    /// The arguments that a cost may read, without constants.
    pub fn of_cost(self) -> impl Iterator<Item = Slot> {
        let lists = [Slot::Q, Slot::V, Slot::PStar, Slot::PStarDot, Slot::VDot].map(|of| (of as fn(usize) -> Slot, self.n));
        let of_equations = [Slot::Sigma, Slot::Lambda].map(|of| (of as fn(usize) -> Slot, self.m));
        let of_controls = [Slot::U, Slot::UDot].map(|of| (of as fn(usize) -> Slot, self.k));
        let lists = lists.into_iter().chain(of_equations).chain(of_controls);
        lists.flat_map(|(of, len)| (0..len).map(of)).chain([Slot::T])
    }

    /// The arguments that have rates, in their order.
    pub fn moving(self) -> impl Iterator<Item = usize> {
        (0..self.u()).chain(self.sigma()..self.c()).chain(self.u()..self.sigma())
    }

    /// The argument with a given number.
    pub fn place(self, which: usize) -> Place {
        let (n, m, first) = (self.n, self.m, self.of_costs());
        match which {
            i if i < self.v() => Place::Of(Slot::Q(i)),
            i if i < self.u() => Place::Of(Slot::V(i - self.v())),
            i if i < self.t() => Place::Of(Slot::U(i - self.u())),
            i if i < self.sigma() => Place::Of(Slot::T),
            i if i < self.c() => Place::Of(Slot::Sigma(i - self.sigma())),
            i if i < self.d() => Place::C(i - self.c()),
            i if i < self.e() => Place::D(i - self.d()),
            i if i < self.rates() => Place::E(i - self.e()),
            i if i < self.constant_rates() => match self.moving().nth(i - self.rates()).map(|which| self.place(which)) {
                Some(Place::Of(slot)) => Place::Rate(slot),
                _ => Place::Rate(Slot::T),
            },
            i if i < self.constants() => Place::Rate(Slot::B(i - self.constant_rates())),
            i if i < first => Place::Of(Slot::B(i - self.constants())),
            i if i < first + n => Place::Of(Slot::PStar(i - first)),
            i if i < first + 2 * n => Place::Of(Slot::PStarDot(i - first - n)),
            i if i < first + 3 * n => Place::Of(Slot::VDot(i - first - 2 * n)),
            i if i < first + 3 * n + m => Place::Of(Slot::Lambda(i - first - 3 * n)),
            i => Place::Of(Slot::UDot(i - first - 3 * n - m)),
        }
    }
}
