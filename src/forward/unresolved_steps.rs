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
        let is_surprising = has_missed && (history >= GUESSED || k >= 2 && turns(k));
        // The first step can be judged only after the second.
        if k == 2 && self.motion.first == 0 {
            self.motion.surprising[1] = turns(2);
        }
        self.motion.surprising[k] = is_surprising;
    }
}
