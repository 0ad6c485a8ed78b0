//! Steps whose end state was badly predicted; only these are checked for elements that bend within a step.

use super::ForwardSweep;
use crate::motion::column;

/// A step is badly predicted if the error of the guessed velocities exceeds this fraction of their change in the step …
const SURPRISE: f64 = 1e-2;
/// … and, if the guess used fewer nodes than this, accelerations also change …
const GUESSED: usize = 3;
/// … by more than this fraction.
const JERK: f64 = 0.1;

impl ForwardSweep {
    /// Records whether the end of the step in column `k`, predicted from `history` nodes, was badly predicted.
    pub(crate) fn note_surprise(&mut self, k: usize, history: usize) {
        if self.motion.surprising.len() <= k {
            self.motion.surprising.resize(k + 1, false);
        }
        let (v, before) = (column(&self.motion.trajectory.v, k), column(&self.motion.trajectory.v, k - 1));
        let changes = v.iter().zip(before).map(|(v, before)| v - before);
        let change = self.stepper.newton.linearisation.weights.of_velocities(changes);
        let has_missed = self.stepper.newton.miss.change > SURPRISE * change;
        let turns = |k: usize| self.turns_by(k, JERK);
        let is_surprising = has_missed && (history >= GUESSED || turns(k));
        // The first step, and one after a step of length zero, can be judged only after the next.
        if k >= 2 && (k > 2 || self.motion.first == 0) && self.step_ratio(k - 1).is_none() {
            self.motion.surprising[k - 1] = turns(k);
        }
        self.motion.surprising[k] = is_surprising;
    }
}
