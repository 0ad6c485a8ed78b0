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

/// The weights of all unknowns, or of all equations, in the solver's order: those of velocities, zero for multipliers, and those of multipliers.
struct Weights {
    v: Vec<f64>,
    sigma: Vec<f64>,
}

impl Weights {
    fn new(len: usize) -> Self {
        Weights { v: vec![0.0; len], sigma: vec![0.0; len] }
    }

    /// The largest weighted entries that belong to velocities and to multipliers, from a position on.
    #[inline]
    fn sizes(&self, x: &[f64], from: usize) -> Sizes {
        let x = &x[from..];
        let (of_v, of_sigma) = (&self.v[from..][..x.len()], &self.sigma[from..][..x.len()]);
        let (mut v, mut sigma) = ([0.0; 4], [0.0; 4]);
        let ((xs, x), (of_vs, of_v), (of_sigmas, of_sigma)) =
            (x.as_chunks::<4>(), of_v.as_chunks::<4>(), of_sigma.as_chunks::<4>());
        for ((xs, of_v), of_sigma) in xs.iter().zip(of_vs).zip(of_sigmas) {
            raise(&mut v, xs, of_v);
            raise(&mut sigma, xs, of_sigma);
        }
        raise(&mut v, x, of_v);
        raise(&mut sigma, x, of_sigma);
        let largest = |[a, b, c, d]: [f64; 4]| larger(larger(a, c), larger(b, d));
        Sizes { v: largest(v), sigma: largest(sigma) }
    }
}

/// Makes each of four numbers at least |x| times its weight.
#[inline(always)]
fn raise(to: &mut [f64; 4], x: &[f64], weights: &[f64]) {
    to.iter_mut().zip(x).zip(weights).for_each(|((to, x), weight)| *to = larger(*to, x.abs() * weight));
}

/// What makes unknowns of different units comparable, and the residuals of their equations.
pub(crate) struct UnitWeights {
    of_unknowns: Weights,
    of_equations: Weights,
    condensed: usize,
}

impl UnitWeights {
    pub(crate) fn new(len: usize, condensed: usize) -> Self {
        UnitWeights { of_unknowns: Weights::new(len), of_equations: Weights::new(len), condensed }
    }

    /// Takes the roots of pivots p: √p v, σ/√p and so on have one unit, √J, whatever the units of the coordinates are.
    pub(crate) fn set(&mut self, positions: &Positions, reciprocal_pivots: impl Iterator<Item = f64>) {
        let UnitWeights { of_unknowns, of_equations, .. } = self;
        of_equations.v.fill(0.0);
        let roots = reciprocal_pivots.map(|reciprocal| reciprocal.abs().sqrt());
        of_equations.sigma.iter_mut().zip(roots).for_each(|(weight, root)| *weight = root);
        for &position in &positions.v {
            std::mem::swap(&mut of_equations.v[position], &mut of_equations.sigma[position]);
        }
        let inverse = |x: &f64| if *x > 0.0 { x.recip() } else { 0.0 };
        of_unknowns.v.iter_mut().zip(of_equations.v.iter().map(inverse)).for_each(|(weight, x)| *weight = x);
        of_unknowns.sigma.iter_mut().zip(of_equations.sigma.iter().map(inverse)).for_each(|(weight, x)| *weight = x);
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

    /// The weight of an equation, of a velocity or a multiplier.
    pub(crate) fn of_any_equation(&self, position: usize) -> f64 {
        self.of_equations.v[position] + self.of_equations.sigma[position]
    }

    /// The weight of a velocity's equation.
    pub(crate) fn of_equation(&self, position: usize) -> f64 {
        self.of_equations.v[position]
    }

    /// The weight of a multiplier; of its equation, one unit.
    pub(crate) fn of_multiplier(&self, position: usize) -> f64 {
        self.of_unknowns.sigma[position]
    }

    /// The largest velocity, of those in the scene's order.
    pub(crate) fn of_velocities(&self, positions: &Positions, v: impl Iterator<Item = f64>) -> f64 {
        positions.v.iter().zip(v).fold(0.0, |size, (&position, v)| larger(size, v.abs() * self.of_unknowns.v[position]))
    }

    /// The largest multiplier, of those in the scene's order.
    pub(crate) fn of_multipliers(&self, positions: &Positions, sigma: impl Iterator<Item = f64>) -> f64 {
        let terms = positions.sigma.iter().zip(sigma);
        terms.fold(0.0, |size, (&position, sigma)| larger(size, sigma.abs() * self.of_unknowns.sigma[position]))
    }

    /// The largest multiplier's equation, of those in the scene's order.
    pub(crate) fn of_equations(&self, positions: &Positions, r: &[f64]) -> f64 {
        positions
            .sigma
            .iter()
            .zip(r)
            .fold(0.0, |size, (&position, r)| larger(size, r.abs() * self.of_equations.sigma[position]))
    }

    /// The largest momentum, of those in the scene's order.
    pub(crate) fn of_momenta(&self, positions: &Positions, p_star: &[f64]) -> f64 {
        let terms = positions.v.iter().zip(p_star);
        terms.fold(0.0, |size, (&position, p)| larger(size, p.abs() * self.of_equations.v[position]))
    }
}
