//! Steps that are long beside the oscillations of a motion.
//!
//! For a velocity v with period T, sampled with steps Δt,
//!
//! ```text
//!   Σ |v_{i+1} − 2 v_i + v_{i−1}| = 2 (1 − cos(2π Δt/T)) Σ |v_i|
//! ```
//!
//! The trapezoidal rule shifts the phase by 2π (2π Δt/T)²/12 in each period: with 20 steps a period by 3 degrees, and the slope of the phase, with which
//! derivatives grow along a motion, by the same share. Few nodes at which a velocity changes abruptly do not count much in sums of absolute values.

use super::monitor::Monitor;
use crate::motion::{Motion, column};
use crate::node::UnitWeights;
use crate::number::largest;
use crate::{System, Warning};

/// Fewer steps in a period are too few for a scheme of second order, or of a higher one.
const FEWEST: [f64; 2] = [20.0, 8.0];
/// Every second difference of this number is computed, so that the cost is negligible.
const EVERY: usize = 8;
/// Motions with fewer differences are not judged.
const LEAST: usize = 3;
/// Velocities count whose sum is above this fraction of the largest one, in units of the masses.
const COUNTS: f64 = 0.1;
/// Velocities that move their coordinate during the motion by less than this fraction of the largest coordinate are rounding errors.
const ROUNDING: f64 = 1e-12;

/// Σ |v| and Σ |second difference of v| for each coordinate so far.
#[derive(Clone, Default)]
pub(crate) struct Oscillation {
    sums: Vec<f64>,
    bends: Vec<f64>,
    count: usize,
    /// The last node whose difference was added.
    last: usize,
}

impl Oscillation {
    pub(super) fn begin(&mut self, n: usize) {
        for list in [&mut self.sums, &mut self.bends] {
            list.clear();
            list.resize(n, 0.0);
        }
        (self.count, self.last) = (0, 0);
    }

    /// The number of steps in a period of a velocity.
    fn period(&self, i: usize) -> f64 {
        std::f64::consts::TAU / (1.0 - 0.5 * (self.bends[i] / self.sums[i]).min(4.0)).acos()
    }

    /// The coordinate with the fewest steps in a period, of those with at least the sum `least`.
    fn fastest(&self, weights: &UnitWeights, least: f64) -> Option<usize> {
        let size = |i: usize| self.sums[i] * weights.velocity(i);
        let most = (0..self.sums.len()).map(size).fold(0.0, f64::max);
        let counting = (0..self.sums.len()).filter(|&i| size(i) > COUNTS * most && self.sums[i] > least);
        counting.min_by(|&a, &b| self.period(a).total_cmp(&self.period(b)))
    }
}

impl Monitor {
    /// Adds the second difference that ends at a node and, at the end of the motion, warns of steps that are long.
    #[inline]
    pub(super) fn watch_oscillation(&mut self, system: &System, motion: &Motion, weights: &UnitWeights, node: usize) {
        let is_new = node > self.oscillation.last && node.is_multiple_of(EVERY) && node >= motion.first + 2;
        if is_new && motion.inputs.grid.stages == 1 {
            self.add_difference(motion, node);
        }
        if node + 1 == motion.nodes() && self.oscillation.count >= LEAST && !motion.is_growing {
            self.warn_of_coarse_steps(system, motion, (weights, node));
        }
    }

    fn add_difference(&mut self, motion: &Motion, node: usize) {
        let (k, Oscillation { sums, bends, count, last }) = (node - motion.first, &mut self.oscillation);
        *last = node;
        let [before, after] = [node - 1, node].map(|node| motion.length(node));
        // No difference across an uneven step, or one of length zero.
        if after == 0.0 || (after - before).abs() > 0.1 * after.abs() {
            return;
        }
        *count += 1;
        let [before, now, after] = [k - 2, k - 1, k].map(|k| column(&motion.trajectory.v, k));
        sums.iter_mut().zip(now).for_each(|(sum, v)| *sum += v.abs());
        let three = before.iter().zip(now).zip(after);
        bends.iter_mut().zip(three).for_each(|(sum, ((before, v), after))| *sum += (after - 2.0 * v + before).abs());
    }

    #[cold]
    fn warn_of_coarse_steps(&mut self, system: &System, motion: &Motion, (weights, node): (&UnitWeights, usize)) {
        let size = largest(column(&motion.trajectory.q, node - motion.first));
        let duration = motion.inputs.grid.steps.iter().sum::<f64>().abs();
        let least = ROUNDING * size * self.oscillation.count as f64 / duration;
        let Some(fastest) = self.oscillation.fastest(weights, least) else { return };
        let steps = self.oscillation.period(fastest);
        if steps < FEWEST[usize::from(motion.trajectory.scheme.order > 2)] {
            let coordinate = system.coordinate_name(fastest).to_string();
            self.report.warn(Warning::CoarseSteps { coordinate, steps });
        }
    }
}
