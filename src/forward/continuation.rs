//! A step whose solution no guess is near: it is followed from the step of length zero.
//!
//! The equations of a step may have several solutions: a spring of rest length l₀ that pulls a point to x = l₀ pulls it to x = −l₀ too.
//! The one that is meant is the one that v₋ becomes when the step grows from nothing,
//!
//! ```text
//!   r(x; h) = 0,   x(0) = (v₋, σ₋),   h = Δt/2 · 2^−j,  j = J … 0
//! ```
//!
//! Where steps resolve the motion, extrapolation through the last nodes ends there. Where they do not, such as for a spring so stiff that v
//! changes its sign at every node, it overshoots by up to 31 times the velocity, and Newton's iteration ends anywhere.

use crate::forward::ForwardSweep;
use crate::motion::column;
use crate::node::{Miss, STILL, StepFailure};
use crate::{Settings, System, Warning};

/// A guess whose velocities were off by more than this part of them was no guess.
const MISSED: f64 = 0.5;
/// The shortest step tried is shorter by 2 to this power.
const MOST_LEVELS: u32 = 12;

/// (v, σ) of the last level, and of the one before.
pub(crate) struct Continuation {
    last: Vec<f64>,
    before: Vec<f64>,
    /// The last node that the warning counts.
    pub(crate) counted: usize,
}

impl Continuation {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Continuation { last: vec![0.0; n + m], before: vec![0.0; n + m], counted: 0 }
    }
}

impl ForwardSweep {
    /// Whether the velocities at the nodes before a column jump up and down from each to the next, by more than rounding.
    pub(crate) fn is_rough(&self, k: usize) -> bool {
        let weights = &self.stepper.newton.weights;
        let momentum = weights.of_momenta(column(&self.motion.trajectory.p_star, k - 1));
        let v = |before: usize| column(&self.motion.trajectory.v, k - before);
        let size = |v: &[f64]| weights.of_velocities(v.iter().copied());
        // Where they pass zero, three nodes do not tell.
        (3..=k.min(4)).any(|before| {
            let [v, v1, v2] = [v(before - 2), v(before - 1), v(before)];
            let first = weights.of_velocities(v.iter().zip(v1).map(|(v, v1)| v - v1));
            // Steps may be of other lengths, and lead back.
            let ratio = self.step_ratio(k - before + 2);
            let seconds = v.iter().zip(v1).zip(v2).map(|((v, v1), v2)| v - v1 - ratio * (v1 - v2));
            let second = weights.of_velocities(seconds);
            // A sine that turns by 60° a step has second differences as large as first ones.
            second > first && second > MISSED * size(v).max(size(v1)).max(STILL * momentum)
        })
    }

    /// Whether the guess of the step into this column was none, although the motion was smooth before.
    #[inline]
    pub(crate) fn has_missed(&self, k: usize) -> bool {
        // Where the guess was good, nothing more is looked at.
        self.is_far(k) && (k < 2 || self.is_beyond(k))
    }

    /// Whether it was off by more than part of the velocities before and of its own.
    #[inline]
    fn is_far(&self, k: usize) -> bool {
        let Miss { change, guess } = self.stepper.newton.miss;
        change > MISSED * guess && self.is_far_from_before(k)
    }

    #[cold]
    fn is_far_from_before(&self, k: usize) -> bool {
        let change = self.stepper.newton.miss.change;
        let before = column(&self.motion.trajectory.v, k - 1).iter().copied();
        change > MISSED * self.stepper.newton.weights.of_velocities(before)
    }

    /// The length of the step into a column, in parts of the one before.
    fn step_ratio(&self, k: usize) -> f64 {
        let length = |k: usize| self.motion.trajectory.times[k] - self.motion.trajectory.times[k - 1];
        length(k) / length(k - 1)
    }

    /// Whether mean accelerations differ by more than this part of them between the step into a column and the one before.
    pub(crate) fn turns_by(&self, k: usize, part: f64) -> bool {
        let [v, v1, v2] = [0, 1, 2].map(|before| column(&self.motion.trajectory.v, k - before));
        let size = |changes: &mut dyn Iterator<Item = f64>| self.stepper.newton.weights.of_velocities(changes);
        let ratio = self.step_ratio(k);
        let change = size(&mut v.iter().zip(v1).map(|(v, v1)| v - v1));
        let before = size(&mut v1.iter().zip(v2).map(|(v1, v2)| ratio * (v1 - v2)));
        let turn = size(&mut v.iter().zip(v1).zip(v2).map(|((v, v1), v2)| v - v1 - ratio * (v1 - v2)));
        turn > part * change.max(before)
    }

    /// Whether it was off by more than twice the change of velocities in the step before: where v passes zero, they are no measure.
    fn is_beyond(&self, k: usize) -> bool {
        let (v, before) = (column(&self.motion.trajectory.v, k - 1), column(&self.motion.trajectory.v, k - 2));
        let changes = v.iter().zip(before).map(|(v, before)| v - before);
        self.stepper.newton.miss.change > 2.0 * self.stepper.newton.weights.of_velocities(changes)
    }

    /// Follows the solution of the step into a node from h = 0; the next step is not extrapolated from what lies before it.
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
                // No guess was near, and still the motion may go on as it went; from rest, under forces that grow, it goes three times as fast.
                if s == self.motion.trajectory.last_stage() && k >= 2 && self.turns_by(k, if k == 2 { 1.0 } else { MISSED })
                {
                    self.warn_of_roughness(node);
                }
            }
            // The error shall tell of the whole step, not of a part of it.
            Err(_) => {
                let k = node - self.motion.first;
                self.stepper.begin_stage(&mut self.motion, k, s, dt);
            }
        }
        result
    }

    /// Nodes that are computed again from a checkpoint do not count again.
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
            // A failure leaves the guess as it was.
            if let Err(failure) = self.solve_at_hand::<false>(system, node, dt, settings) {
                self.solve_at_hand::<true>(system, node, dt, settings).map_err(|_| failure)?;
            }
        }
        Ok(())
    }

    /// The longest step for which v₋ is a good guess, as it is for half of it.
    fn first_level(&mut self, system: &System, node: usize, dt: f64, settings: &Settings) -> u32 {
        let once = Settings { max_iterations: 1, ..*settings };
        let k = node - self.motion.first;
        let mut good = 0;
        for level in 0..MOST_LEVELS {
            let dt = dt * 0.5f64.powi(level as i32);
            self.stepper.begin_stage(&mut self.motion, k, self.stepper.stage, dt);
            self.guess_last(k);
            // One correction of a guess that is far off may be all that fails.
            let failed =
                matches!(self.solve_at_hand::<false>(system, node, dt, &once), Err(failure) if !failure.is_unfinished());
            good = if failed || self.is_far(k) { 0 } else { good + 1 };
            if good == 2 {
                return level;
            }
        }
        MOST_LEVELS
    }

    /// The values of the node before as the first guess of the stage at hand.
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

    /// The solution at the level before stays as the guess.
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
