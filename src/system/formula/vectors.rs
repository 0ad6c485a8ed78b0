//! Sums and adjoint quantities that elements contribute to.

use super::kind::Number;
use super::shape::Argument;
use crate::number::{add, take};

/// 𝓛_v (n), 𝓛_q + Q (n) and dΦ/dt (m) of all elements, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Sums<R> {
    pub all: Vec<R>,
    pub n: usize,
}

impl<R: Number> Sums<R> {
    pub fn new(n: usize, m: usize) -> Self {
        Sums { all: vec![R::zero(); 2 * n + m], n }
    }

    pub fn clear(&mut self) {
        self.all.fill(R::zero());
    }

    pub fn l_v(&self) -> &[R] {
        &self.all[..self.n]
    }

    pub fn force(&self) -> &[R] {
        &self.all[self.n..2 * self.n]
    }

    pub fn phi_dot(&self) -> &[R] {
        &self.all[2 * self.n..]
    }

    /// 𝓛_v, 𝓛_q + Q and dΦ/dt.
    pub fn parts_mut(&mut self) -> [&mut [R]; 3] {
        let (l_v, rest) = self.all.split_at_mut(self.n);
        let (force, phi_dot) = rest.split_at_mut(self.n);
        [l_v, force, phi_dot]
    }
}

/// The index of each velocity and each multiplier in the solver's order.
#[derive(Debug)]
pub struct Positions {
    pub v: Vec<usize>,
    pub sigma: Vec<usize>,
}

/// Numbers for each velocity (n) and each multiplier (m).
#[derive(Clone, Debug, Default)]
pub struct Pair {
    pub v: Vec<f64>,
    pub sigma: Vec<f64>,
}

impl Pair {
    pub fn new(n: usize, m: usize) -> Self {
        Pair { v: vec![0.0; n], sigma: vec![0.0; m] }
    }

    /// Adds `other` to this pair.
    pub fn add(&mut self, other: &Pair) {
        add(&mut self.v, &other.v);
        add(&mut self.sigma, &other.sigma);
    }

    /// Replaces this pair by `other` minus this pair.
    pub fn subtract_from(&mut self, other: &Pair) {
        self.v.iter_mut().zip(&other.v).for_each(|(x, other)| *x = other - *x);
        self.sigma.iter_mut().zip(&other.sigma).for_each(|(x, other)| *x = other - *x);
    }

    /// The negative of this pair.
    pub fn negative(&self) -> Pair {
        let negative = |x: &[f64]| x.iter().map(|x| -x).collect();
        Pair { v: negative(&self.v), sigma: negative(&self.sigma) }
    }

    /// Reads the values from a vector in the solver's order.
    pub fn load(&mut self, positions: &Positions, x: &[f64]) {
        take(x, &positions.v, &mut self.v);
        take(x, &positions.sigma, &mut self.sigma);
    }

    /// Writes the values to a vector in the solver's order.
    pub fn store(&self, positions: &Positions, x: &mut [f64]) {
        self.v.iter().zip(&positions.v).for_each(|(v, &at)| x[at] = *v);
        self.sigma.iter().zip(&positions.sigma).for_each(|(sigma, &at)| x[at] = *sigma);
    }
}

/// The adjoint variables c (of E3), d (of E4) and e (of E5) at one node.
#[derive(Clone, Copy)]
pub struct Covector<'a> {
    pub c: &'a [f64],
    pub d: &'a [f64],
    pub e: &'a [f64],
}

/// Derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to v (n), q (n) and σ (m).
#[derive(Clone, Debug, Default)]
pub struct StateRows {
    pub v: Vec<f64>,
    pub q: Vec<f64>,
    pub sigma: Vec<f64>,
}

impl StateRows {
    pub fn new(n: usize, m: usize) -> Self {
        StateRows { v: vec![0.0; n], q: vec![0.0; n], sigma: vec![0.0; m] }
    }

    pub fn clear(&mut self) {
        self.v.fill(0.0);
        self.q.fill(0.0);
        self.sigma.fill(0.0);
    }
}

/// Derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to u, the design variables and t.
pub struct InputRows<'a> {
    pub u: &'a mut [f64],
    pub design: &'a mut [f64],
    pub time: &'a mut f64,
    /// The number of derivatives evaluated so far.
    pub evaluations: &'a mut usize,
}

impl InputRows<'_> {
    /// Adds a derivative with respect to an input, times the factor between the two.
    pub fn add(&mut self, (input, factor): (Argument, f64), slope: f64) {
        *self.evaluations += 1;
        match input {
            Argument::U(channel) => self.u[channel] += factor * slope,
            Argument::B(p) => self.design[p] += factor * slope,
            _ => *self.time += factor * slope,
        }
    }
}

/// Change of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt of an element over a step.
#[derive(Clone, Copy)]
pub struct Within {
    /// The number of the element among all elements.
    pub element: usize,
    /// The change minus the prediction from the derivatives at the ends of the step.
    pub missed: f64,
    /// The larger magnitude of the change and its prediction.
    pub change: f64,
}

/// An entry of a sparse matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    pub row: usize,
    pub col: usize,
    pub value: f64,
}
