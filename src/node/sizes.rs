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

/// What a number weighs as a velocity, and as a multiplier; one of the two is zero.
type Weight = [f64; 2];

/// The largest weighted velocity and the largest weighted multiplier.
///
/// Pairs of maxima: compilers make good vectors of them for all sets of instructions, which they do not of maxima beside minima.
// By itself: it is called from six places of a step.
#[inline(never)]
fn sizes(x: &[f64], weights: &[Weight]) -> Sizes {
    let ((fours, rest), (of_fours, of_rest)) = (x.as_chunks::<4>(), weights.as_chunks::<4>());
    let mut most = [[0.0; 2]; 4];
    for (x, weights) in fours.iter().zip(of_fours) {
        for lane in 0..4 {
            most[lane] = larger_of_pair(most[lane], x[lane], weights[lane]);
        }
    }
    let [mut a, b, c, d] = most;
    for (&x, &weight) in rest.iter().zip(of_rest) {
        a = larger_of_pair(a, x, weight);
    }
    let [v, sigma] = [0, 1].map(|kind| larger(larger(a[kind], b[kind]), larger(c[kind], d[kind])));
    Sizes { v, sigma }
}

#[inline(always)]
fn larger_of_pair(most: [f64; 2], x: f64, weight: Weight) -> [f64; 2] {
    [larger(most[0], x.abs() * weight[0]), larger(most[1], x.abs() * weight[1])]
}

/// The largest weighted number.
fn largest(x: impl Iterator<Item = f64>, weights: &[f64]) -> f64 {
    x.zip(weights).fold(0.0, |size, (x, weight)| larger(size, x.abs() * weight))
}

/// What makes unknowns of different units comparable, and the residuals of their equations.
pub(crate) struct UnitWeights {
    /// In the solver's order.
    of_unknowns: Vec<Weight>,
    of_equations: Vec<Weight>,
    condensed: usize,
    /// The same in the scene's order.
    unknowns: Pair,
    equations: Pair,
}

impl UnitWeights {
    pub(crate) fn new((n, m): (usize, usize), condensed: usize) -> Self {
        let [of_unknowns, of_equations] = [vec![[0.0; 2]; n + m], vec![[0.0; 2]; n + m]];
        UnitWeights { of_unknowns, of_equations, condensed, unknowns: Pair::new(n, m), equations: Pair::new(n, m) }
    }

    /// Takes the roots of pivots p: √p v, σ/√p and so on have one unit, √J, whatever the units of the coordinates are.
    pub(crate) fn set(&mut self, positions: &Positions, reciprocal_pivots: impl Iterator<Item = f64>) {
        let roots = reciprocal_pivots.map(|reciprocal| reciprocal.abs().sqrt());
        self.of_equations.iter_mut().zip(roots).for_each(|(weight, root)| weight[0] = root);
        let inverse = |x: f64| if x > 0.0 { x.recip() } else { 0.0 };
        for (i, &position) in positions.v.iter().enumerate() {
            let root = self.of_equations[position][0];
            (self.unknowns.v[i], self.equations.v[i]) = (inverse(root), root);
            (self.of_unknowns[position], self.of_equations[position]) = ([inverse(root), 0.0], [root, 0.0]);
        }
        for (j, &position) in positions.sigma.iter().enumerate() {
            let root = self.of_equations[position][0];
            (self.unknowns.sigma[j], self.equations.sigma[j]) = (inverse(root), root);
            (self.of_unknowns[position], self.of_equations[position]) = ([0.0, inverse(root)], [0.0, root]);
        }
    }

    /// The sizes of all unknowns.
    pub(crate) fn of_all(&self, x: &[f64]) -> Sizes {
        sizes(x, &self.of_unknowns)
    }

    /// The sizes of unknowns, condensed ones left out.
    pub(crate) fn of(&self, x: &[f64]) -> Sizes {
        sizes(&x[self.condensed..], &self.of_unknowns[self.condensed..])
    }

    /// The sizes of residuals of the same equations.
    pub(crate) fn of_residual(&self, r: &[f64]) -> Sizes {
        sizes(&r[self.condensed..], &self.of_equations[self.condensed..])
    }

    /// The weight of an equation, of a velocity or a multiplier, by its position.
    pub(crate) fn of_any_equation(&self, position: usize) -> f64 {
        self.of_equations[position].into_iter().sum()
    }

    /// The weight of a velocity's equation, by its position; 0 for a multiplier's.
    pub(crate) fn of_equation(&self, position: usize) -> f64 {
        self.of_equations[position][0]
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
