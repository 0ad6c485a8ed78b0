//! How large velocities and multipliers are, or the residuals of their equations, in units that make them comparable.

use crate::number::larger;
use crate::system::Positions;

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

/// What makes unknowns of different units comparable, and the residuals of their equations, in the solver's order: (weight, 0) for a velocity and
/// its equation, (0, weight) for a multiplier and its.
pub(crate) struct UnitWeights {
    of_unknowns: Vec<[f64; 2]>,
    of_equations: Vec<[f64; 2]>,
    condensed: usize,
}

impl UnitWeights {
    pub(crate) fn new(len: usize, condensed: usize) -> Self {
        UnitWeights { of_unknowns: vec![[0.0; 2]; len], of_equations: vec![[0.0; 2]; len], condensed }
    }

    /// Takes the roots of pivots p: √p v, σ/√p and so on have one unit, √J, whatever the units of the coordinates are.
    pub(crate) fn set(&mut self, positions: &Positions, reciprocal_pivots: impl Iterator<Item = f64>) {
        let roots = reciprocal_pivots.map(|reciprocal| reciprocal.abs().sqrt());
        self.of_equations.iter_mut().zip(roots).for_each(|(weights, root)| *weights = [0.0, root]);
        for &position in &positions.v {
            self.of_equations[position].swap(0, 1);
        }
        let inverse = |x: f64| if x > 0.0 { x.recip() } else { 0.0 };
        let weights = self.of_unknowns.iter_mut().zip(&self.of_equations);
        weights.for_each(|(of_unknown, of_equation)| *of_unknown = of_equation.map(inverse));
    }

    /// The sizes of all unknowns.
    pub(crate) fn of_all(&self, x: &[f64]) -> Sizes {
        sizes(&self.of_unknowns, x)
    }

    /// The sizes of unknowns, condensed ones left out.
    pub(crate) fn of(&self, x: &[f64]) -> Sizes {
        sizes(&self.of_unknowns[self.condensed..], &x[self.condensed..])
    }

    /// The sizes of residuals of the same equations.
    pub(crate) fn of_residual(&self, r: &[f64]) -> Sizes {
        sizes(&self.of_equations[self.condensed..], &r[self.condensed..])
    }

    /// The weight of a velocity's equation.
    pub(crate) fn of_equation(&self, position: usize) -> f64 {
        self.of_equations[position][0]
    }

    /// The weight of a multiplier; of its equation, one unit.
    pub(crate) fn of_multiplier(&self, position: usize) -> f64 {
        self.of_unknowns[position][1]
    }

    /// The largest velocity, of those in the scene's order.
    pub(crate) fn of_velocities(&self, positions: &Positions, v: impl Iterator<Item = f64>) -> f64 {
        positions.v.iter().zip(v).fold(0.0, |size, (&position, v)| larger(size, v.abs() * self.of_unknowns[position][0]))
    }

    /// The largest multiplier, of those in the scene's order.
    pub(crate) fn of_multipliers(&self, positions: &Positions, sigma: impl Iterator<Item = f64>) -> f64 {
        let terms = positions.sigma.iter().zip(sigma);
        terms.fold(0.0, |size, (&position, sigma)| larger(size, sigma.abs() * self.of_unknowns[position][1]))
    }

    /// The largest multiplier's equation, of those in the scene's order.
    pub(crate) fn of_equations(&self, positions: &Positions, r: &[f64]) -> f64 {
        positions
            .sigma
            .iter()
            .zip(r)
            .fold(0.0, |size, (&position, r)| larger(size, r.abs() * self.of_equations[position][1]))
    }

    /// The largest momentum, of those in the scene's order.
    pub(crate) fn of_momenta(&self, positions: &Positions, p_star: &[f64]) -> f64 {
        let terms = positions.v.iter().zip(p_star);
        terms.fold(0.0, |size, (&position, p)| larger(size, p.abs() * self.of_equations[position][0]))
    }
}

/// The largest weighted entries that belong to velocities and to multipliers.
#[inline]
fn sizes(weights: &[[f64; 2]], x: &[f64]) -> Sizes {
    let (chunks, rest) = x.as_chunks::<4>();
    let (weights, rest_weights) = weights.as_chunks::<4>();
    let update = |[v, sigma]: &mut [f64; 2], x: f64, [of_v, of_sigma]: &[f64; 2]| {
        *v = larger(*v, x.abs() * of_v);
        *sigma = larger(*sigma, x.abs() * of_sigma);
    };
    let mut lanes = [[0.0; 2]; 4];
    for (x, weights) in chunks.iter().zip(weights) {
        for k in 0..4 {
            update(&mut lanes[k], x[k], &weights[k]);
        }
    }
    for ((x, weight), lane) in rest.iter().zip(rest_weights).zip(&mut lanes) {
        update(lane, *x, weight);
    }
    let size = |k: usize| larger(larger(lanes[0][k], lanes[1][k]), larger(lanes[2][k], lanes[3][k]));
    Sizes { v: size(0), sigma: size(1) }
}
