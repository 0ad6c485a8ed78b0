//! The true Jacobian at a point, three ways: dual numbers, complex step, and differences with an error estimate.

use nalgebra::DMatrix;
use std::ops::Range;

use super::formula::Differentiable;
use super::random::Random;
use super::ridders::ridders;

/// Blocks with more columns than this are checked by differences in this many columns only.
const MOST_DIFFERENCED: usize = 24;

/// Derivatives below this may be lost as a complex step's, which is as small again.
const UNDERFLOW: f64 = 1e-200;

/// How often the arguments are changed by rounding.
const TRIALS: usize = 3;

/// The steps of the differences go from h to h/2¹²; again so far where they straddled something narrow.
const HALVINGS: usize = 12;

/// A Jacobian and what is known about its accuracy.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    /// By dual numbers.
    pub value: DMatrix<f64>,
    pub complex: DMatrix<f64>,
    /// NaN in columns that were not differenced.
    pub differences: DMatrix<f64>,
    /// How far the differences may be off, by their own estimate.
    pub differences_error: DMatrix<f64>,
    /// How much the entries change when the arguments change by rounding.
    pub noise: DMatrix<f64>,
    /// The function itself, for the scale of its rows.
    pub function: Vec<f64>,
}

/// ∂f/∂x over the arguments `by`, by dual numbers.
pub(crate) fn dual(f: &dyn Differentiable, x: &[f64], by: &Range<usize>) -> DMatrix<f64> {
    jacobian(x, by, |x, direction| f.by_dual(x, direction))
}

/// The same by complex step.
pub(crate) fn complex_step(f: &dyn Differentiable, x: &[f64], by: &Range<usize>) -> DMatrix<f64> {
    jacobian(x, by, |x, direction| f.by_complex_step(x, direction))
}

fn jacobian(x: &[f64], by: &Range<usize>, along: impl Fn(&[f64], &[f64]) -> Vec<f64>) -> DMatrix<f64> {
    let mut direction = vec![0.0; x.len()];
    let columns: Vec<Vec<f64>> = by
        .clone()
        .map(|j| {
            direction[j] = 1.0;
            let column = along(x, &direction);
            direction[j] = 0.0;
            column
        })
        .collect();
    let rows = columns.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i])
}

/// All oracles but the differences at one point.
pub(crate) fn truth(f: &dyn Differentiable, x: &[f64], by: &Range<usize>, random: &mut Random) -> Truth {
    let value = dual(f, x, by);
    let (rows, columns) = value.shape();
    Truth {
        complex: complex_step(f, x, by),
        noise: noise(f, x, by, &value, random),
        function: f.real(x),
        value,
        differences: DMatrix::from_element(rows, columns, f64::NAN),
        differences_error: DMatrix::from_element(rows, columns, f64::INFINITY),
    }
}

impl Truth {
    /// Adds the differences; `magnitudes` are the sizes that the arguments have.
    pub(crate) fn difference(
        &mut self,
        f: &dyn Differentiable,
        x: &[f64],
        by: &Range<usize>,
        magnitudes: &[f64],
        random: &mut Random,
    ) {
        for j in differenced(self.value.ncols(), random) {
            let (estimate, error) = differences(f, x, by.start + j, magnitudes, 0);
            self.differences.column_mut(j).copy_from_slice(&estimate);
            self.differences_error.column_mut(j).copy_from_slice(&error);
        }
    }
}

/// ∂f/∂x_k and the estimated errors; the first step is `finer` times 2¹² times shorter than usual.
pub(crate) fn differences(
    f: &dyn Differentiable,
    x: &[f64],
    k: usize,
    magnitudes: &[f64],
    finer: i32,
) -> (Vec<f64>, Vec<f64>) {
    let step = 0.05 * magnitudes[k].max(x[k].abs()) * 0.5f64.powi(finer * HALVINGS as i32);
    let along = |s: f64| {
        let mut x = x.to_vec();
        x[k] += s;
        // The step as it is in binary.
        (x[k], f.real(&x))
    };
    ridders(along, (step, HALVINGS), 0.0, f.real(x).len())
}

fn differenced(columns: usize, random: &mut Random) -> Vec<usize> {
    if columns <= MOST_DIFFERENCED {
        return (0..columns).collect();
    }
    let mut picked: Vec<usize> = (0..MOST_DIFFERENCED).map(|_| random.below(columns)).collect();
    picked.sort_unstable();
    picked.dedup();
    picked
}

/// The change of the Jacobian when every argument changes by a few units in its last place.
///
/// It measures the cancellation inside the formula: no hand-derived one can be expected to be better.
fn noise(f: &dyn Differentiable, x: &[f64], by: &Range<usize>, value: &DMatrix<f64>, random: &mut Random) -> DMatrix<f64> {
    let mut noise = value.map(|x| (f64::EPSILON * x.abs()).max(UNDERFLOW));
    let changes = changes(x.len(), random);
    for trial in 0..TRIALS {
        let nearby: Vec<f64> = x.iter().zip(&changes).map(|(x, change)| x * (1.0 + f64::EPSILON * change[trial])).collect();
        let change = dual(f, &nearby, by) - value;
        noise.zip_apply(&change, |noise, change| *noise = noise.max(change.abs()));
    }
    noise
}

/// By how many units in the last place every argument changes: −2 … 2 in each of three trials.
///
/// No two arguments change alike in all of them (of more than 124, few), or their changes would cancel in their difference, as in γ (q_i − q_{i−1}).
fn changes(count: usize, random: &mut Random) -> Vec<[f64; TRIALS]> {
    let unit = |code: usize| (code % 5) as f64 - 2.0;
    let mut all: Vec<[f64; TRIALS]> = (0..125).map(|code| [code, code / 5, code / 25].map(unit)).collect();
    all.retain(|change| change.iter().any(|units| *units != 0.0));
    (1..all.len()).rev().for_each(|k| all.swap(k, random.below(k + 1)));
    (0..count).map(|k| all[k % all.len()]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::formula::{Function, Plain};
    use super::*;
    use crate::Scalar;

    /// (γ (q_i − q_{i−1}))², as the velocity of every step.
    struct Velocity;

    impl Function for Velocity {
        fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
            vec![((x[0] - x[1]) * 300.0).powi(2)]
        }
    }

    #[test]
    fn rounding_of_a_difference_is_always_seen() {
        let noise = |seed| truth(&Plain(&Velocity), &[200.0, 199.9], &(0..1), &mut Random::new(seed)).noise[0];
        let least = (0..500).map(noise).fold(f64::INFINITY, f64::min);
        assert!(least > 300.0 * 300.0 * f64::EPSILON * 200.0, "{least:e}");
    }
}
