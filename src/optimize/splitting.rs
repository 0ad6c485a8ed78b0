//! The same quadratic programme by operator splitting (Stellato et al. 2020): slower, but it never goes round in circles.
//!
//! min gᵀd + ½ dᵀBd with z = (d, A d) between bounds; d and z are moved in turn, their difference being paid for by y.

use nalgebra::{DMatrix, DVector};

use super::problem::Interval;
use super::quadratic::{Held, Quadratic, Solution, regular};

const MOST_ROUNDS: usize = 1000;
const TOLERANCE: f64 = 1e-8;
const RELAXATION: f64 = 1.6;
/// Equalities are paid for so many times as dearly.
const STIFFER: f64 = 1e3;

/// The solution, and which variables and constraints are held at which bounds there.
pub(super) fn solve(of: &Quadratic) -> Option<(Solution, Held, Held)> {
    let (a, n) = (&of.at.jacobian, of.at.x.len());
    let m = a.nrows();
    let size = of.b.diagonal().mean();
    let here = |i: usize| if i < n { of.at.x[i] } else { of.at.c[i - n] };
    let interval = |i: usize| -> Interval { if i < n { of.bounds[i] } else { of.intervals[i - n] } };
    let price = DVector::from_fn(n + m, |i, _| {
        let row = if i < n { 1.0 } else { a.row(i - n).norm_squared().max(f64::MIN_POSITIVE) };
        let of = interval(i);
        size / row * if of.least == of.most { STIFFER } else { 1.0 }
    });
    // B + σ I + Mᵀ R M with M = (I, A), R the prices.
    let small = 1e-6 * size;
    let priced = DMatrix::from_fn(m, n, |j, i| price[n + j] * a[(j, i)]);
    let mut matrix = of.b + a.tr_mul(&priced);
    (0..n).for_each(|i| matrix[(i, i)] += small + price[i]);
    let factors = regular(matrix)?;
    let rows = |d: &DVector<f64>| {
        let ad = a * d;
        DVector::from_fn(n + m, |i, _| if i < n { d[i] } else { ad[i - n] })
    };
    let columns = |y: &DVector<f64>| y.rows(0, n) + a.tr_mul(&y.rows(n, m));
    let (mut d, mut z, mut y) = (DVector::zeros(n), DVector::zeros(n + m), DVector::<f64>::zeros(n + m));
    for _ in 0..MOST_ROUNDS {
        let pulled = z.component_mul(&price) - &y;
        let right = &d * small - &of.at.gradient + columns(&pulled);
        let next = factors.solve(&right);
        let ahead = rows(&next) * RELAXATION + &z * (1.0 - RELAXATION);
        let wanted = DVector::from_fn(n + m, |i, _| interval(i).nearest(here(i) + ahead[i] + y[i] / price[i]) - here(i));
        y += (&ahead - &wanted).component_mul(&price);
        let change = (&wanted - &z).amax().max((&next - &d).amax());
        let apart = (rows(&next) - &wanted).amax();
        (d, z) = (next, wanted);
        if change.max(apart) <= TOLERANCE * z.amax().max(1e-12) {
            break;
        }
    }
    let held = |i: usize| {
        let of = interval(i);
        match y[i] {
            _ if of.least == of.most => Some(of.least),
            y if y < 0.0 => Some(of.least),
            y if y > 0.0 => Some(of.most),
            _ => None,
        }
    };
    let multipliers = y.rows(n, m).into_owned();
    Some((Solution { step: d, multipliers }, (0..n).map(held).collect(), (n..n + m).map(held).collect()))
}
