//! Sizes of velocities, multipliers and the residuals of their equations, in comparable units.

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

    /// The larger of both sizes, which have the same unit.
    pub(crate) fn largest(self) -> f64 {
        larger(self.v, self.sigma)
    }

    /// The larger of the two ratios of these sizes to others.
    pub(crate) fn relative_to(self, other: Sizes) -> f64 {
        let ratio = |x: f64, to: f64| if x == 0.0 { 0.0 } else { x / to };
        ratio(self.v, other.v).max(ratio(self.sigma, other.sigma))
    }
}

/// The weights of each position as a velocity and as a multiplier; one of the two is zero.
enum Weights {
    /// For systems without multipliers.
    Velocities(Vec<f64>),
    Both(Vec<[f64; 2]>),
}

impl Weights {
    fn new(n: usize, m: usize) -> Self {
        if m == 0 { Weights::Velocities(vec![0.0; n]) } else { Weights::Both(vec![[0.0; 2]; n + m]) }
    }

    fn get(&self, position: usize) -> [f64; 2] {
        match self {
            Weights::Velocities(weights) => [weights[position], 0.0],
            Weights::Both(weights) => weights[position],
        }
    }

    fn set(&mut self, position: usize, weight: [f64; 2]) {
        match self {
            Weights::Velocities(weights) => weights[position] = weight[0],
            Weights::Both(weights) => weights[position] = weight,
        }
    }

    /// The largest weighted velocity and the largest weighted multiplier, from a position on.
    // Not inlined, because a step calls it at six places.
    #[inline(never)]
    fn sizes(&self, x: &[f64], from: usize) -> Sizes {
        let x = &x[from..];
        match self {
            Weights::Velocities(weights) => Sizes { v: largest_weighted(x, &weights[from..]), sigma: 0.0 },
            Weights::Both(weights) => largest_of_both(x, &weights[from..]),
        }
    }
}

/// The largest weighted absolute value.
#[inline(always)]
fn largest_weighted(x: &[f64], weights: &[f64]) -> f64 {
    let ((fours, rest), (of_fours, of_rest)) = (x.as_chunks::<4>(), weights.as_chunks::<4>());
    let mut most = [0.0; 4];
    for (x, weights) in fours.iter().zip(of_fours) {
        for lane in 0..4 {
            most[lane] = larger(most[lane], x[lane].abs() * weights[lane]);
        }
    }
    most.into_iter().fold(largest(rest.iter().copied(), of_rest), larger)
}

/// The largest weighted velocity and the largest weighted multiplier.
///
/// Compilers vectorise pairs of maxima well for all instruction sets, but not maxima beside minima.
#[inline(always)]
fn largest_of_both(x: &[f64], weights: &[[f64; 2]]) -> Sizes {
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
fn larger_of_pair(most: [f64; 2], x: f64, weight: [f64; 2]) -> [f64; 2] {
    [larger(most[0], x.abs() * weight[0]), larger(most[1], x.abs() * weight[1])]
}

/// The largest weighted absolute value of an iterator.
fn largest(x: impl Iterator<Item = f64>, weights: &[f64]) -> f64 {
    x.zip(weights).fold(0.0, |size, (x, weight)| larger(size, x.abs() * weight))
}

/// Weights that make unknowns of different units comparable, and the residuals of their equations.
pub(crate) struct UnitWeights {
    /// In the solver's order.
    of_unknowns: Weights,
    of_equations: Weights,
    condensed: usize,
    /// The positions of the multipliers.
    multipliers: Vec<usize>,
    /// Weights in the scene's order.
    unknowns: Pair,
    equations: Pair,
}

impl UnitWeights {
    pub(crate) fn new((n, m): (usize, usize), condensed: usize) -> Self {
        let [of_unknowns, of_equations] = [Weights::new(n, m), Weights::new(n, m)];
        UnitWeights {
            of_unknowns,
            of_equations,
            condensed,
            multipliers: Vec::new(),
            unknowns: Pair::new(n, m),
            equations: Pair::new(n, m),
        }
    }

    /// Computes the weights from the square roots of pivots p: √p v, σ/√p and so on have one unit, √J, for any units of the coordinates.
    pub(crate) fn set(&mut self, positions: &Positions, reciprocal_pivots: impl Iterator<Item = f64>) {
        self.multipliers.clone_from(&positions.sigma);
        let UnitWeights { of_unknowns, of_equations, unknowns, equations, .. } = self;
        let roots = reciprocal_pivots.map(|reciprocal| reciprocal.abs().sqrt());
        roots.enumerate().for_each(|(position, root)| of_equations.set(position, [root, 0.0]));
        let inverse = |x: f64| if x > 0.0 { x.recip() } else { 0.0 };
        for (i, &position) in positions.v.iter().enumerate() {
            let [root, _] = of_equations.get(position);
            (unknowns.v[i], equations.v[i]) = (inverse(root), root);
            of_unknowns.set(position, [inverse(root), 0.0]);
            of_equations.set(position, [root, 0.0]);
        }
        for (j, &position) in positions.sigma.iter().enumerate() {
            let [root, _] = of_equations.get(position);
            (unknowns.sigma[j], equations.sigma[j]) = (inverse(root), root);
            of_unknowns.set(position, [0.0, inverse(root)]);
            of_equations.set(position, [0.0, root]);
        }
    }

    /// Leaves out the multipliers and equations that are open, and no others.
    pub(crate) fn set_open(&mut self, open: impl Fn(usize) -> bool) {
        for (j, &position) in self.multipliers.iter().enumerate() {
            let counts = if open(j) { 0.0 } else { 1.0 };
            self.of_unknowns.set(position, [0.0, counts * self.unknowns.sigma[j]]);
            self.of_equations.set(position, [0.0, counts * self.equations.sigma[j]]);
        }
    }

    /// The sizes of all unknowns.
    pub(crate) fn of_all(&self, x: &[f64]) -> Sizes {
        self.of_unknowns.sizes(x, 0)
    }

    /// The sizes of the unknowns that are not condensed.
    pub(crate) fn of(&self, x: &[f64]) -> Sizes {
        self.of_unknowns.sizes(x, self.condensed)
    }

    /// The sizes of the residuals of these equations.
    pub(crate) fn of_residual(&self, r: &[f64]) -> Sizes {
        self.of_equations.sizes(r, self.condensed)
    }

    /// The weight of the equation at a position, for velocities and multipliers.
    pub(crate) fn of_any_equation(&self, position: usize) -> f64 {
        self.of_equations.get(position).into_iter().sum()
    }

    /// The weight of the equation at a position, for velocities; 0 for multipliers.
    pub(crate) fn of_equation(&self, position: usize) -> f64 {
        self.of_equations.get(position)[0]
    }

    /// The weights of momenta, in the scene's order.
    pub(crate) fn momenta(&self) -> &[f64] {
        &self.equations.v
    }

    pub(crate) fn multipliers(&self) -> &[f64] {
        &self.unknowns.sigma
    }

    /// The weight of the velocity of a coordinate.
    pub(crate) fn velocity(&self, i: usize) -> f64 {
        self.unknowns.v[i]
    }

    /// The largest weighted velocity, in the scene's order.
    pub(crate) fn of_velocities(&self, v: impl Iterator<Item = f64>) -> f64 {
        largest(v, &self.unknowns.v)
    }

    /// The largest weighted multiplier, in the scene's order.
    pub(crate) fn of_multipliers(&self, sigma: impl Iterator<Item = f64>) -> f64 {
        largest(sigma, &self.unknowns.sigma)
    }

    /// The largest weighted residual of a constraint equation, in the scene's order.
    pub(crate) fn of_equations(&self, r: &[f64]) -> f64 {
        largest(r.iter().copied(), &self.equations.sigma)
    }

    /// The largest weighted momentum, in the scene's order.
    pub(crate) fn of_momenta(&self, p_star: &[f64]) -> f64 {
        largest(p_star.iter().copied(), &self.equations.v)
    }
}
