//! [`Weighted`]: trials in segments, with weights of the distances between the segments.

use nalgebra::DMatrix;

use super::super::multiple_shooting::MultipleShooting;
use super::super::problem::{Interval, Problem};
use super::super::stages::owners;
use super::super::trials::Trials;
use crate::Error;
use crate::solver::Asked;

/// The smallest weight of a distance, relative to the largest one of the same motion.
const SMALLEST: f64 = 1e-3;

/// Trials in segments, whose constraints are multiplied by weights: 1 for outputs.
pub(super) struct Weighted<'t> {
    pub(super) trials: &'t mut Trials<MultipleShooting>,
    weights: Vec<f64>,
}

impl<'t> Weighted<'t> {
    /// Trials at the point that was evaluated last. The distance in a state has as weight a multiple of the length of the derivatives of the residuals
    /// in a segment by this state, the root of the mean of squares over the segments: distances count as much as their effects on the residuals.
    ///
    /// # Errors
    /// A segment without derivatives.
    pub(super) fn new(trials: &'t mut Trials<MultipleShooting>, multiple: f64) -> Result<Self, Error> {
        let mut weights = Vec::new();
        for shooting in &mut trials.parts {
            let of_states = sensitivities(shooting)?;
            weights.resize(weights.len() + shooting.running.len(), 1.0);
            let joints = shooting.segments.len() - 1;
            (0..joints).for_each(|_| weights.extend(of_states.iter().map(|of| multiple * of)));
        }
        Ok(Weighted { trials, weights })
    }

    fn weighted(&self, c: &[f64]) -> Vec<f64> {
        c.iter().zip(&self.weights).map(|(c, w)| c * w).collect()
    }
}

/// For each state at the start of a segment: the length of the derivatives of the residuals in the segment.
fn sensitivities(shooting: &mut MultipleShooting) -> Result<Vec<f64>, Error> {
    let (states, owners) = (shooting.entries.len(), owners(shooting));
    let mut squares = vec![0.0; states];
    let count = shooting.segments.len();
    for k in 1..count {
        let is_own = |j: &usize| owners[*j] == Some(k) && shooting.constraints[*j] != Interval::FREE;
        let asked: Vec<Asked> = (0..owners.len()).filter(is_own).map(Asked::Output).collect();
        let segment = &mut shooting.segments[k];
        let mut jacobian = DMatrix::zeros(asked.len(), segment.places.len());
        if !asked.is_empty() {
            segment.jacobian(&asked, &mut jacobian)?;
        }
        let first = segment.places.len() - states;
        squares.iter_mut().enumerate().for_each(|(i, sum)| *sum += jacobian.column(first + i).norm_squared());
    }
    let lengths = squares.iter().map(|sum| (sum / (count - 1).max(1) as f64).sqrt());
    let most = lengths.clone().fold(0.0f64, f64::max);
    let least = if most > 0.0 { SMALLEST * most } else { 1.0 };
    Ok(lengths.map(|of| of.max(least)).collect())
}

impl Problem for Weighted<'_> {
    fn variables(&self) -> usize {
        self.trials.variables()
    }

    fn bounds(&self) -> Vec<Interval> {
        self.trials.bounds()
    }

    fn constraints(&self) -> Vec<Interval> {
        self.trials.constraints()
    }

    fn variable_name(&self, i: usize) -> String {
        self.trials.variable_name(i)
    }

    fn constraint_name(&self, j: usize) -> String {
        self.trials.constraint_name(j)
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        let f = self.trials.evaluate(x, c)?;
        c.iter_mut().zip(&self.weights).for_each(|(c, w)| *c *= w);
        Ok(f)
    }

    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let weights = self.weighted(c_weights);
        self.trials.gradient(f_weight, &weights, gradient)
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        self.trials.jacobian(rows, jacobian)?;
        for (mut row, &j) in jacobian.row_iter_mut().zip(rows) {
            row *= self.weights[j];
        }
        Ok(())
    }

    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        self.trials.jacobian_work(rows)
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        self.trials.push_forward(direction, change)?;
        change.iter_mut().zip(&self.weights).for_each(|(c, w)| *c *= w);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::Free;
    use super::super::super::trials::Sharing;
    use super::*;
    use crate::{Grid, Inputs, Settings, scenes::CartPendulum};

    /// A cart with a link in three segments, with readings of the cart; its damping is free.
    fn record(offset: f64) -> MultipleShooting {
        let mut parts = CartPendulum::with_links(1).mechanism();
        let (rail, angle) = (parts.cart.coordinates[0], parts.links[0].coordinates[2]);
        let damping = parts.scene.design("damping", 0.3);
        parts.scene.axis_spring_damper("damper", rail, 2.0, offset, damping);
        let readings: Vec<(usize, f64)> = (1..=12).map(|node| (node, 0.01 * node as f64)).collect();
        parts.scene.axis_readings("rail", rail, &readings, 0.05);
        let system = parts.scene.compile().expect("a scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(12, 0.04));
        let free = vec![Free::design(damping)];
        let states = [rail, angle];
        MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 3).expect("segments")
    }

    #[test]
    fn derivatives_of_weighted_distances_are_those_of_differences() {
        let mut trials = Trials::join(vec![record(0.1), record(-0.4)], Sharing::Designs).expect("two records");
        let n = trials.variables();
        assert_eq!(n, 1 + 2 * 8);
        let x: Vec<f64> = (0..n).map(|i| 0.3 + 0.02 * (i % 5) as f64).collect();
        let count = trials.constraints().len();
        let mut c = vec![0.0; count];
        trials.evaluate(&x, &mut c).expect("motions");
        let mut of = Weighted::new(&mut trials, 10.0).expect("derivatives");
        // Readings have the weight 1, and distances those of their effects: a rate acts for less than a second.
        assert!(of.weights[..12].iter().all(|w| *w == 1.0));
        let (position, rate) = (of.weights[12], of.weights[13]);
        assert!(position > 10.0 / 0.05 && rate < 0.3 * position, "{position} {rate}");

        let rows: Vec<usize> = (0..count).collect();
        let mut jacobian = DMatrix::zeros(count, n);
        of.evaluate(&x, &mut c).expect("motions");
        of.jacobian(&rows, &mut jacobian).expect("a Jacobian");
        let (step, mut change) = (1e-5, vec![0.0; count]);
        for i in 0..n {
            of.evaluate(&x, &mut c).expect("motions");
            let mut direction = vec![0.0; n];
            direction[i] = 1.0;
            of.push_forward(&direction, &mut change).expect("a change");
            let mut at = |by: f64| {
                let (mut x, mut c) = (x.clone(), vec![0.0; count]);
                x[i] += by;
                of.evaluate(&x, &mut c).expect("motions");
                c
            };
            let [after, before] = [at(step), at(-step)];
            let size = jacobian.column(i).amax().max(1.0);
            for j in 0..count {
                let difference = (after[j] - before[j]) / (2.0 * step);
                assert!((jacobian[(j, i)] - difference).abs() < 1e-5 * size, "row {j}, column {i}: {difference}");
                assert!((jacobian[(j, i)] - change[j]).abs() < 1e-9 * size, "row {j}, column {i}: {}", change[j]);
            }
        }
        of.evaluate(&x, &mut c).expect("motions");
        let (weights, mut gradient) = ((0..count).map(|j| 0.1 + j as f64).collect::<Vec<f64>>(), vec![0.0; n]);
        of.gradient(0.0, &weights, &mut gradient).expect("a gradient");
        let by_rows = jacobian.tr_mul(&nalgebra::DVector::from_vec(weights));
        assert!(gradient.iter().zip(by_rows.iter()).all(|(a, b)| (a - b).abs() < 1e-9 * by_rows.amax()));
    }
}
