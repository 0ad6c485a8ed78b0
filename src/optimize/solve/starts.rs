//! [`Starts`]: random controls, durations and guesses.

use nalgebra::DMatrix;
use std::f64::consts::{LN_2, PI};

use super::super::Outcome;
use super::super::free::Quantity;
use super::super::motion_problem::{MotionProblem, Statement};
use super::super::problem::Interval;
use super::super::variables::Variables;
use crate::Error;
use crate::number::Random;

/// Added to the number of a start, it is the seed of its random numbers. Any number will do; which minima few starts find depends on it.
const SEED: u64 = 3000;
/// Number of sines in a random control.
const SINES: usize = 6;
/// Their largest coefficients, relative to half the distance between bounds. Near the best outcome, they are multiplied by a random number below 1.
const BOUNDED: f64 = 0.4;
/// Random durations relative to that of the best outcome, or to the given one, as powers of 2: from much shorter to somewhat longer ones, because
/// the way to a shorter motion is often through infeasible ones, and the way from a longer one is not.
const OCTAVES: [f64; 2] = [-0.75, 0.25];
/// One of so many starts begins near the best outcome.
const EVERY: usize = 2;
/// Number of sines that bend a guess, and their largest coefficient, relative to the largest change of a coordinate.
const BENDS: usize = 3;
const BENT: f64 = 0.5;

/// Random starts of a problem.
pub(super) struct Starts {
    of: Statement,
    start: Vec<f64>,
    /// The magnitude of controls without bounds.
    size: f64,
}

impl Starts {
    /// Starts around that of a problem, with controls of the magnitude of those of an outcome.
    pub(super) fn new(problem: &MotionProblem, known: &Outcome) -> Self {
        let controls = controls(problem.free()).flat_map(|range| known.x[range].to_vec());
        let largest = controls.fold(0.0f64, |most, u| most.max(u.abs()));
        let size = if largest > 0.0 && largest.is_finite() && known.reason.is_converged() { largest } else { 1.0 };
        Starts { of: problem.statement(), start: problem.start(), size }
    }

    /// True if start number `which` is near the best outcome.
    pub(super) fn is_near(which: usize) -> bool {
        which.is_multiple_of(EVERY)
    }

    /// The problem with start number `which`. Durations are around that of the best outcome, if there is one, and if the start is near it, controls, too.
    ///
    /// # Errors
    /// Inputs that do not fit.
    pub(super) fn problem(&self, which: usize, best: Option<&Outcome>) -> Result<MotionProblem, Error> {
        let (variables, around) = (&self.of.variables, best.map_or(&self.start, |best| &best.x));
        let from = if Self::is_near(which) { around } else { &self.start };
        let (mut x, bounds, mut random) = (from.clone(), variables.bounds(), Random::new(SEED + which as u64));
        for range in controls(variables) {
            let (steps, within) = ((range.len() - 1).max(1) as f64, bounds[range.start]);
            let half = 0.5 * (within.most - within.least);
            let largest = if half.is_finite() { BOUNDED * half } else { self.size };
            // Some starts near the best outcome lead to minima beside it, others farther away.
            let part = random.uniform(0.0, 1.0);
            let size = if Self::is_near(which) { part * largest } else { largest };
            let sines: Vec<f64> = (0..SINES).map(|_| random.uniform(-size, size)).collect();
            for (k, u) in x[range].iter_mut().enumerate() {
                let t = PI * k as f64 / steps;
                let sum: f64 = sines.iter().enumerate().map(|(j, of)| of * ((j + 1) as f64 * t).sin()).sum();
                *u = within.nearest(*u + sum);
            }
        }
        for (free, range) in variables.parts().filter(|(free, _)| free.quantity == Quantity::Duration) {
            let factor = (LN_2 * random.uniform(OCTAVES[0], OCTAVES[1])).exp();
            let Interval { least, most } = bounds[range.start];
            let longer = free.to_variable(free.to_value(around[range.start]) * factor);
            x[range.start] = longer.clamp(least, most);
        }
        self.of.at(&x)
    }
}

/// Adds random sines to the independent coordinates of a guess, (q_1, v_1, q_2, …) in the rows, and their derivatives to the rates; the ends keep
/// their coordinates.
pub(super) fn bend(z: &mut DMatrix<f64>, times: &[f64], which: usize) {
    let (mut random, last) = (Random::new(!(SEED + which as u64)), times.len() - 1);
    let positions = (0..z.nrows()).step_by(2);
    let change = positions.clone().fold(0.0f64, |most, i| most.max((z[(i, last)] - z[(i, 0)]).abs()));
    let (size, total) = (change * random.uniform(0.0, BENT), times[last] - times[0]);
    if total == 0.0 {
        return;
    }
    for i in positions {
        for j in 1..=BENDS {
            let (by, speed) = (size * random.uniform(-1.0, 1.0) / j as f64, j as f64 * PI / total);
            for (node, time) in times.iter().enumerate() {
                let (sin, cos) = (speed * (time - times[0])).sin_cos();
                z[(i, node)] += by * sin;
                z[(i + 1, node)] += by * speed * cos;
            }
        }
    }
}

/// The variables of each control.
fn controls(variables: &Variables) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    variables.parts().filter(|(free, _)| free.quantity.control().is_some()).map(|(_, range)| range)
}

#[cfg(test)]
mod tests {
    use super::super::super::{Free, Options, interior_point, silent};
    use super::*;
    use crate::{Grid, Inputs, Settings, scenes::CartPendulum};

    #[test]
    fn every_second_start_begins_near_the_best_outcome() {
        let mut cart = CartPendulum::with_links(1).mechanism();
        cart.scene.effort("effort", cart.force, 1e-4);
        let rate = cart.scene.end_state(cart.cart.coordinates[0]).rate;
        let system = cart.scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
        let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force)]).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
        problem.constrain(rate, Interval::equal(1.0));
        let start = problem.start();
        let best = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        assert!(best.reason.is_converged(), "{best}");
        problem.settle_at(&start);
        let starts = Starts::new(&problem, &best);
        // Random controls do not depend on the controls to which they are added.
        let added = |which: usize, best: Option<&Outcome>, to: &[f64]| {
            let x = starts.problem(which, best).expect("fits").start();
            x.iter().zip(to).map(|(x, of)| x - of).collect::<Vec<f64>>()
        };
        for which in 1..=8 {
            let near = added(which, Some(&best), if which % 2 == 0 { &best.x } else { &start });
            let far = added(which, None, &start);
            let off = near.iter().zip(&far).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
            let size = far.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            assert!(size > 0.0 && off < 1e-12 * size, "{which}: {off:.1e} of {size:.1e}");
        }
    }
}
