//! How large velocities and multipliers are, or the residuals of their equations, in units that make them comparable.

use crate::number::larger;
use crate::system::{Pair, Positions};

/// The largest velocity and the largest multiplier, or the largest residuals of their equations.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sizes {
    pub(crate) v: f64,
    pub(crate) sigma: f64,
}

impl Sizes {
    pub(crate) fn at_least(self, floor: f64) -> Sizes {
        Sizes { v: larger(self.v, floor), sigma: larger(self.sigma, floor) }
    }

    /// The larger of both, which have one unit.
    pub(crate) fn largest(self) -> f64 {
        larger(self.v, self.sigma)
    }

    /// This relative to another, the larger of the two ratios.
    pub(crate) fn relative_to(self, other: Sizes) -> f64 {
        let ratio = |x: f64, to: f64| if x == 0.0 { 0.0 } else { x / to };
        ratio(self.v, other.v).max(ratio(self.sigma, other.sigma))
    }
}

/// What numbers weigh as velocities, and as multipliers, by positions: one of the two is zero. Without multipliers the second list is empty.
struct Weights {
    v: Vec<f64>,
    sigma: Vec<f64>,
}

impl Weights {
    fn new(n: usize, m: usize) -> Self {
        Weights { v: vec![0.0; n + m], sigma: vec![0.0; if m > 0 { n + m } else { 0 }] }
    }

    /// Sets what a number weighs as a velocity, and as a multiplier.
    fn set(&mut self, position: usize, [v, sigma]: [f64; 2]) {
        self.v[position] = v;
        self.sigma.get_mut(position).into_iter().for_each(|weight| *weight = sigma);
    }

    /// The largest weighted velocity and the largest weighted multiplier, from a position on.
    fn sizes(&self, x: &[f64], from: usize) -> Sizes {
        let sigma = if self.sigma.is_empty() { 0.0 } else { largest_weighted(&x[from..], &self.sigma[from..]) };
        Sizes { v: largest_weighted(&x[from..], &self.v[from..]), sigma }
    }
}

/// The largest weighted number.
// By itself: it is called from many places of a step.
#[inline(never)]
fn largest_weighted(x: &[f64], weights: &[f64]) -> f64 {
    let ((fours, rest), (of_fours, of_rest)) = (x.as_chunks::<4>(), weights.as_chunks::<4>());
    let mut most = [0.0; 4];
    for (x, weights) in fours.iter().zip(of_fours) {
        for lane in 0..4 {
            most[lane] = larger(most[lane], x[lane].abs() * weights[lane]);
        }
    }
    let rest = largest(rest.iter().copied(), of_rest);
    most.into_iter().fold(rest, larger)
}

/// The same of numbers that are made one by one.
fn largest(x: impl Iterator<Item = f64>, weights: &[f64]) -> f64 {
    x.zip(weights).fold(0.0, |size, (x, weight)| larger(size, x.abs() * weight))
}

/// What makes unknowns of different units comparable, and the residuals of their equations.
pub(crate) struct UnitWeights {
    /// In the solver's order.
    of_unknowns: Weights,
    of_equations: Weights,
    condensed: usize,
    /// The same in the scene's order.
    unknowns: Pair,
    equations: Pair,
}

impl UnitWeights {
    pub(crate) fn new((n, m): (usize, usize), condensed: usize) -> Self {
        let [of_unknowns, of_equations] = [Weights::new(n, m), Weights::new(n, m)];
        UnitWeights { of_unknowns, of_equations, condensed, unknowns: Pair::new(n, m), equations: Pair::new(n, m) }
    }

    /// Takes the roots of pivots p: √p v, σ/√p and so on have one unit, √J, whatever the units of the coordinates are.
    pub(crate) fn set(&mut self, positions: &Positions, reciprocal_pivots: impl Iterator<Item = f64>) {
        let UnitWeights { of_unknowns, of_equations, unknowns, equations, .. } = self;
        let roots = reciprocal_pivots.map(|reciprocal| reciprocal.abs().sqrt());
        of_equations.v.iter_mut().zip(roots).for_each(|(weight, root)| *weight = root);
        let inverse = |x: f64| if x > 0.0 { x.recip() } else { 0.0 };
        for (i, &position) in positions.v.iter().enumerate() {
            let root = of_equations.v[position];
            (unknowns.v[i], equations.v[i]) = (inverse(root), root);
            of_unknowns.set(position, [inverse(root), 0.0]);
            of_equations.set(position, [root, 0.0]);
        }
        for (j, &position) in positions.sigma.iter().enumerate() {
            let root = of_equations.v[position];
            (unknowns.sigma[j], equations.sigma[j]) = (inverse(root), root);
            of_unknowns.set(position, [0.0, inverse(root)]);
            of_equations.set(position, [0.0, root]);
        }
    }

    /// The sizes of all unknowns.
    pub(crate) fn of_all(&self, x: &[f64]) -> Sizes {
        self.of_unknowns.sizes(x, 0)
    }

    /// The sizes of unknowns, condensed ones left out.
    pub(crate) fn of(&self, x: &[f64]) -> Sizes {
        self.of_unknowns.sizes(x, self.condensed)
    }

    /// The sizes of residuals of the same equations.
    pub(crate) fn of_residual(&self, r: &[f64]) -> Sizes {
        self.of_equations.sizes(r, self.condensed)
    }

    /// The weight of an equation, of a velocity or a multiplier, by its position.
    pub(crate) fn of_any_equation(&self, position: usize) -> f64 {
        self.of_equations.v[position] + self.of_equations.sigma.get(position).unwrap_or(&0.0)
    }

    /// The weight of a velocity's equation, by its position; 0 for a multiplier's.
    pub(crate) fn of_equation(&self, position: usize) -> f64 {
        self.of_equations.v[position]
    }

    /// The weights of velocities' equations and of multipliers, in the scene's order.
    pub(crate) fn momenta(&self) -> &[f64] {
        &self.equations.v
    }

    pub(crate) fn multipliers(&self) -> &[f64] {
        &self.unknowns.sigma
    }

    /// The largest velocity, of those in the scene's order.
    pub(crate) fn of_velocities(&self, v: impl Iterator<Item = f64>) -> f64 {
        largest(v, &self.unknowns.v)
    }

    /// The largest multiplier, of those in the scene's order.
    pub(crate) fn of_multipliers(&self, sigma: impl Iterator<Item = f64>) -> f64 {
        largest(sigma, &self.unknowns.sigma)
    }

    /// The largest multiplier's equation, of those in the scene's order.
    pub(crate) fn of_equations(&self, r: &[f64]) -> f64 {
        largest(r.iter().copied(), &self.equations.sigma)
    }

    /// The largest momentum, of those in the scene's order.
    pub(crate) fn of_momenta(&self, p_star: &[f64]) -> f64 {
        largest(p_star.iter().copied(), &self.equations.v)
    }
}
