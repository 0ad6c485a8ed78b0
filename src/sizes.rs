//! How large velocities and multipliers are, or the residuals of their equations, in units that make them comparable.

use crate::lanes::larger;

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

    /// This relative to another, the larger of the two ratios.
    pub(crate) fn relative_to(self, other: Sizes) -> f64 {
        let ratio = |x: f64, to: f64| if x == 0.0 { 0.0 } else { x / to };
        ratio(self.v, other.v).max(ratio(self.sigma, other.sigma))
    }
}

/// The largest weighted entries that belong to velocities and to multipliers.
#[inline]
pub(crate) fn sizes(weights: &[[f64; 2]], x: &[f64]) -> Sizes {
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
