//! The arguments of an element's formula, numbered consecutively.

use super::typed::Slot;

/// The numbers of coordinates, equations, controls and constants of an element.
///
/// Its arguments are numbered in the order q (n), v (n), u (k), t; σ (m); the adjoint variables c (n), d (n), e (m); the rates of q, v, σ, u
/// and t; the rates of the constants (p).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shape {
    pub n: usize,
    pub m: usize,
    pub k: usize,
    pub p: usize,
}

/// An argument of an element's formula or of its derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Q(usize),
    V(usize),
    U(usize),
    T,
    Sigma(usize),
    C(usize),
    D(usize),
    E(usize),
    QRate(usize),
    VRate(usize),
    SigmaRate(usize),
    URate(usize),
    TRate,
    ConstantRate(usize),
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

    /// The number of an argument of the plain formula; the constants come after all others.
    pub const fn number(self, slot: Slot) -> usize {
        match slot {
            Slot::Q(i) => i,
            Slot::V(i) => self.v() + i,
            Slot::Sigma(j) => self.sigma() + j,
            Slot::U(k) => self.u() + k,
            Slot::T => self.t(),
            Slot::B(p) => self.constant_rates() + self.p + p,
        }
    }

    /// The numbers of the arguments that have rates, in the order of the rates.
    pub fn moving(self) -> impl Iterator<Item = usize> {
        (0..self.u()).chain(self.sigma()..self.c()).chain(self.u()..self.sigma())
    }

    /// The argument with a given number.
    pub fn place(self, which: usize) -> Place {
        match which {
            i if i < self.v() => Place::Q(i),
            i if i < self.u() => Place::V(i - self.v()),
            i if i < self.t() => Place::U(i - self.u()),
            i if i < self.sigma() => Place::T,
            i if i < self.c() => Place::Sigma(i - self.sigma()),
            i if i < self.d() => Place::C(i - self.c()),
            i if i < self.e() => Place::D(i - self.d()),
            i if i < self.rates() => Place::E(i - self.e()),
            i if i >= self.constant_rates() => Place::ConstantRate(i - self.constant_rates()),
            i => match self.moving().nth(i - self.rates()).map(|which| self.place(which)) {
                Some(Place::Q(i)) => Place::QRate(i),
                Some(Place::V(i)) => Place::VRate(i),
                Some(Place::Sigma(j)) => Place::SigmaRate(j),
                Some(Place::U(k)) => Place::URate(k),
                _ => Place::TRate,
            },
        }
    }
}
