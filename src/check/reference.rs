//! The reference Jacobian, computed in three ways: dual numbers, complex step, and differences with an error estimate.

use nalgebra::DMatrix;
use std::ops::Range;

use super::formula::{Differentiable, Formula};
use super::ridders::ridders;
use crate::number::Random;

/// Blocks with more columns than this are checked by differences in this many columns only.
const MOST_DIFFERENCED: usize = 24;

/// Smaller derivatives may be lost to underflow in a complex step.
const UNDERFLOW: f64 = 1e-200;

/// Number of random changes of the arguments by rounding.
const TRIALS: usize = 3;

/// The steps of the differences are halved from h to h/2¹²; finer ones continue from there if these straddled a narrow feature.
const HALVINGS: usize = 12;

/// ∂f/∂x with respect to some of the arguments. The last argument is a factor 1, and the derivative with respect to it is f itself.
pub(crate) struct Jacobian<'a> {
    pub function: Box<dyn Differentiable + 'a>,
    pub by: Range<usize>,
}

impl<'a> Jacobian<'a> {
    pub(crate) fn new(function: impl Formula + 'a, by: Range<usize>) -> Self {
        Jacobian { function: Box::new(function), by }
    }

    /// The Jacobian by dual numbers.
    pub(crate) fn dual(&self, x: &[f64]) -> DMatrix<f64> {
        self.by_columns(x, |direction| self.function.by_dual(x, direction).1)
    }

    pub(crate) fn complex_step(&self, x: &[f64]) -> DMatrix<f64> {
        self.by_columns(x, |direction| self.function.by_complex_step(x, direction))
    }

    fn by_columns(&self, x: &[f64], along: impl Fn(&[f64]) -> Vec<f64>) -> DMatrix<f64> {
        let mut direction = vec![0.0; x.len()];
        let column = |j: usize| {
            direction[j] = 1.0;
            let column = along(&direction);
            direction[j] = 0.0;
            column
        };
        let columns: Vec<Vec<f64>> = self.by.clone().map(column).collect();
        let rows = columns.first().map_or(0, Vec::len);
        DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i])
    }

    /// A column by differences, and its estimated errors; the first step is 2¹² times shorter than usual for each level of `finer`.
    pub(crate) fn differences(&self, x: &[f64], column: usize, magnitudes: &[f64], finer: i32) -> (Vec<f64>, Vec<f64>) {
        let k = self.by.start + column;
        let step = 0.05 * magnitudes[k].max(x[k].abs()) * 0.5f64.powi(finer * HALVINGS as i32);
        let along = |s: f64| {
            let mut x = x.to_vec();
            x[k] += s;
            // The argument as rounded.
            (x[k], self.function.real(&x))
        };
        ridders(along, (step, HALVINGS), 0.0, self.function.real(x).len())
    }

    /// The change of the Jacobian when every argument changes by a few units in its last place.
    ///
    /// The result measures the cancellation inside the formula; a hand-derived formula cannot be expected to round less.
    pub(crate) fn noise(&self, x: &[f64], value: &DMatrix<f64>, random: &mut Random) -> DMatrix<f64> {
        let mut noise = value.map(|x| (f64::EPSILON * x.abs()).max(UNDERFLOW));
        let changes = changes(x.len(), random);
        for trial in 0..TRIALS {
            let nearby = |(x, change): (&f64, &[f64; TRIALS])| x * (1.0 + f64::EPSILON * change[trial]);
            let change = self.dual(&x.iter().zip(&changes).map(nearby).collect::<Vec<f64>>()) - value;
            noise.zip_apply(&change, |noise, change| *noise = noise.max(change.abs()));
        }
        noise
    }
}

/// Indices of the columns that are checked by differences.
pub(crate) fn differenced(columns: usize, random: &mut Random) -> Vec<usize> {
    if columns <= MOST_DIFFERENCED {
        return (0..columns).collect();
    }
    let mut picked: Vec<usize> = (0..MOST_DIFFERENCED).map(|_| random.below(columns)).collect();
    picked.sort_unstable();
    picked.dedup();
    picked
}

/// Changes of every argument in units in the last place: −2 … 2 in each of three trials.
///
/// No two arguments change alike in all trials (few do if there are more than 124), because equal changes cancel in γ (q_i − q_{i−1}).
fn changes(count: usize, random: &mut Random) -> Vec<[f64; TRIALS]> {
    let unit = |code: usize| (code % 5) as f64 - 2.0;
    let mut all: Vec<[f64; TRIALS]> = (0..125).map(|code| [code, code / 5, code / 25].map(unit)).collect();
    all.retain(|change| change.iter().any(|units| *units != 0.0));
    (1..all.len()).rev().for_each(|k| all.swap(k, random.below(k + 1)));
    (0..count).map(|k| all[k % all.len()]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::formula::Function;
    use super::*;
    use crate::Scalar;

    /// (γ (q_i − q_{i−1}))², the square of the velocity in a step.
    struct Velocity;

    impl Function for Velocity {
        fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
            vec![((x[0] - x[1]) * 300.0).powi(2)]
        }
    }

    #[test]
    fn rounding_of_a_difference_is_always_seen() {
        let (of, x) = (Jacobian::new(&Velocity, 0..1), [200.0, 199.9, 1.0]);
        let noise = |seed| of.noise(&x, &of.dual(&x), &mut Random::new(seed))[0];
        let least = (0..500).map(noise).fold(f64::INFINITY, f64::min);
        assert!(least > 300.0 * 300.0 * f64::EPSILON * 200.0, "{least:e}");
    }
}
