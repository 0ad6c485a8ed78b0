//! Continuation of a step for which no guess is close to its solution, starting from a step of length zero.
//!
//! The equations of a step may have several solutions: a spring of rest length l₀ that pulls a point to x = l₀ also pulls it to x = −l₀. The correct
//! solution is the one into which v₋ develops as the step grows from zero,
//!
//! ```text
//!   r(x; h) = 0,   x(0) = (v₋, σ₋),   h = Δt/2 · 2^−j,  j = J … 0
//! ```
//!
//! If steps resolve the motion, extrapolation through the last nodes leads to it. If they do not, for example with a spring so stiff that v changes
//! its sign at every node, extrapolation overshoots by up to 31 times the velocity, and Newton's iteration may converge to any solution.

use super::stepper::Continuation;
use crate::forward::ForwardSweep;
use crate::motion::column;
use crate::node::{Miss, STILL, StepFailure};
use crate::{Settings, System, Warning};

/// A guess has failed if the error of its velocities exceeds this fraction of them.
const MISSED: f64 = 0.5;
/// The shortest trial step is shorter by 2 to this power.
const MOST_LEVELS: u32 = 12;

impl ForwardSweep {
    /// True if the velocities at the nodes before a column alternate from node to node by more than rounding.
    pub(crate) fn is_rough(&self, k: usize) -> bool {
        let weights = &self.stepper.newton.linearisation.weights;
        let momentum = weights.of_momenta(column(&self.motion.trajectory.p_star, k - 1));
        let v = |before: usize| column(&self.motion.trajectory.v, k - before);
        let size = |v: &[f64]| weights.of_velocities(v.iter().copied());
        // Where velocities pass through zero, three nodes are not sufficient.
        (3..=k.min(4)).any(|before| {
            let [v, v1, v2] = [v(before - 2), v(before - 1), v(before)];
            let first = weights.of_velocities(v.iter().zip(v1).map(|(v, v1)| v - v1));
            // Steps may differ in length and direction.
            let Some(ratio) = self.step_ratio(k - before + 2) else { return false };
            let seconds = v.iter().zip(v1).zip(v2).map(|((v, v1), v2)| v - v1 - ratio * (v1 - v2));
            let second = weights.of_velocities(seconds);
            // For a sine that turns by 60° per step, second differences are as large as first ones.
            second > first && second > MISSED * size(v).max(size(v1)).max(STILL * momentum)
        })
    }

    /// True if the guess of the step that ends in this column has failed, although the motion was smooth before.
    #[inline]
    pub(crate) fn has_missed(&self, k: usize) -> bool {
        // If the guess was good, nothing else is checked.
        self.is_far(k) && (self.step_ratio(k).is_none() || self.is_beyond(k))
    }

    /// True if the error of the guess exceeds a fraction of its velocities and of the previous ones.
    #[inline]
    fn is_far(&self, k: usize) -> bool {
        let Miss { change, guess } = self.stepper.newton.miss;
        change > MISSED * guess && self.is_far_from_before(k)
    }

    #[cold]
    fn is_far_from_before(&self, k: usize) -> bool {
        let change = self.stepper.newton.miss.change;
        let before = column(&self.motion.trajectory.v, k - 1).iter().copied();
        change > MISSED * self.stepper.newton.linearisation.weights.of_velocities(before)
    }

    /// The length of the step that ends in a column, relative to the previous one; `None` if there is no other, or if one of them has length zero.
    pub(crate) fn step_ratio(&self, k: usize) -> Option<f64> {
        let length = |k: usize| self.motion.trajectory.times[k] - self.motion.trajectory.times[k - 1];
        (k >= 2 && length(k) != 0.0 && length(k - 1) != 0.0).then(|| length(k) / length(k - 1))
    }

    /// True if mean accelerations in the step that ends in a column and in the previous step differ by more than this fraction.
    pub(crate) fn turns_by(&self, k: usize, part: f64) -> bool {
        let Some(ratio) = self.step_ratio(k) else { return false };
        let [v, v1, v2] = [0, 1, 2].map(|before| column(&self.motion.trajectory.v, k - before));
        let size = |changes: &mut dyn Iterator<Item = f64>| self.stepper.newton.linearisation.weights.of_velocities(changes);
        let change = size(&mut v.iter().zip(v1).map(|(v, v1)| v - v1));
        let before = size(&mut v1.iter().zip(v2).map(|(v1, v2)| ratio * (v1 - v2)));
        let turn = size(&mut v.iter().zip(v1).zip(v2).map(|((v, v1), v2)| v - v1 - ratio * (v1 - v2)));
        turn > part * change.max(before)
    }

    /// True if the error of the guess exceeds twice the change of velocities in the previous step: velocities that pass through zero give no scale.
    fn is_beyond(&self, k: usize) -> bool {
        let (v, before) = (column(&self.motion.trajectory.v, k - 1), column(&self.motion.trajectory.v, k - 2));
        let changes = v.iter().zip(before).map(|(v, before)| v - before);
        self.stepper.newton.miss.change > 2.0 * self.stepper.newton.linearisation.weights.of_velocities(changes)
    }

    /// Continues the solution of the step that ends at a node from h = 0; the next step is not extrapolated from earlier nodes.
    #[cold]
    pub(crate) fn continue_from_zero(
        &mut self,
        system: &System,
        node: usize,
        settings: &Settings,
    ) -> Result<(), StepFailure> {
        let (dt, s) = (self.motion.inputs.grid.steps[node - 1], self.stepper.stage);
        let result = self.follow(system, node, settings);
        match &result {
            Ok(()) => {
                self.stepper.smooth_from = node;
                let k = node - self.motion.first;
                // No guess was close, but the motion may still be smooth; from rest, under growing forces, the velocity changes three times as much.
                if s == self.motion.trajectory.last_stage() && self.turns_by(k, if k == 2 { 1.0 } else { MISSED }) {
                    self.warn_of_roughness(node);
                }
            }
            // The error must describe the whole step, not a part of it.
            Err(_) => {
                let k = node - self.motion.first;
                self.stepper.begin_stage(&mut self.motion, k, s, dt);
            }
        }
        result
    }

    /// Nodes that are recomputed from a checkpoint are not counted again.
    fn warn_of_roughness(&mut self, node: usize) {
        if node <= self.stepper.continuation.counted {
            return;
        }
        self.stepper.continuation.counted = node;
        let counter = self.monitor.report.warnings.iter_mut().find_map(|warning| match warning {
            Warning::Rough { steps, .. } => Some(steps),
            _ => None,
        });
        match counter {
            Some(steps) => *steps += 1,
            None => {
                let (step, time) = (self.motion.step_of_whole(node), self.motion.time(node));
                self.monitor.report.warn(Warning::Rough { step, time, steps: 1 });
            }
        }
    }

    fn follow(&mut self, system: &System, node: usize, settings: &Settings) -> Result<(), StepFailure> {
        let (k, s, dt) = (node - self.motion.first, self.stepper.stage, self.motion.inputs.grid.steps[node - 1]);
        let first = self.first_level(system, node, dt, settings);
        for level in (0..=first).rev() {
            let dt = dt * 0.5f64.powi(level as i32);
            self.stepper.begin_stage(&mut self.motion, k, s, dt);
            match first - level {
                0 => self.guess_last(k),
                1 => self.store_level(k),
                _ => self.guess_level(k),
            }
            // A failed solve leaves the guess unchanged.
            if let Err(failure) = self.solve_at_hand::<false>(system, node, dt, settings) {
                self.solve_at_hand::<true>(system, node, dt, settings).map_err(|_| failure)?;
            }
        }
        Ok(())
    }

    /// The longest step for which v₋ is a good guess, as it also is for half of it.
    fn first_level(&mut self, system: &System, node: usize, dt: f64, settings: &Settings) -> u32 {
        let once = Settings { max_iterations: 1, ..*settings };
        let k = node - self.motion.first;
        let mut good = 0;
        for level in 0..MOST_LEVELS {
            let dt = dt * 0.5f64.powi(level as i32);
            self.stepper.begin_stage(&mut self.motion, k, self.stepper.stage, dt);
            self.guess_last(k);
            // A guess far from the solution may fail only because one correction is not enough.
            let failed =
                matches!(self.solve_at_hand::<false>(system, node, dt, &once), Err(failure) if !failure.is_unfinished());
            good = if failed || self.is_far(k) { 0 } else { good + 1 };
            if good == 2 {
                return level;
            }
        }
        MOST_LEVELS
    }

    /// Sets the first guess of the current stage to the values of the previous node.
    fn guess_last(&mut self, k: usize) {
        let before = self.motion.trajectory.columns(k - 1);
        let Continuation { last, .. } = &mut self.stepper.continuation;
        let (v, sigma) = last.split_at_mut(before.v.len());
        v.copy_from_slice(before.v);
        sigma.copy_from_slice(before.sigma);
        let now = self.motion.trajectory.stage_mut(k, self.stepper.stage);
        now.v.copy_from_slice(v);
        now.sigma.copy_from_slice(sigma);
    }

    /// Stores the solution at the previous level, which remains the guess.
    fn store_level(&mut self, k: usize) {
        let now = self.motion.trajectory.stage(k, self.stepper.stage);
        let (v, sigma) = self.stepper.continuation.last.split_at_mut(now.v.len());
        v.copy_from_slice(now.v);
        sigma.copy_from_slice(now.sigma);
    }

    /// x(2h) = x(h) + ½ (x(h) − x(h/2)): exact for α + β/h, which the solution becomes for long steps.
    fn guess_level(&mut self, k: usize) {
        let Continuation { last, before, .. } = &mut self.stepper.continuation;
        std::mem::swap(last, before);
        let guess = |now: &mut [f64], last: &mut [f64], before: &[f64]| {
            for ((x, last), before) in now.iter_mut().zip(last).zip(before) {
                *last = *x;
                *x += 0.5 * (*x - before);
            }
        };
        let now = self.motion.trajectory.stage_mut(k, self.stepper.stage);
        let n = now.v.len();
        guess(now.v, &mut last[..n], &before[..n]);
        guess(now.sigma, &mut last[n..], &before[n..]);
    }
}
