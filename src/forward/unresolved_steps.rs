//! Which steps are worth a look, if elements may bend within them: those whose end was not where the nodes before led to expect it.

use super::ForwardSweep;
use crate::motion::column;

/// A guess whose velocities were off by more than this part of their change in a step makes it worth a look …
const SURPRISE: f64 = 1e-2;
/// … where it comes from fewer nodes than this, only if accelerations change too …
const GUESSED: usize = 3;
/// … by more than this part of them.
const JERK: f64 = 0.1;

impl ForwardSweep {
    /// Notes whether the step into a column, guessed from so many nodes, is worth a look.
    pub(crate) fn note_surprise(&mut self, k: usize, history: usize) {
        if self.motion.surprising.len() <= k {
            self.motion.surprising.resize(k + 1, false);
        }
        let (v, before) = (column(&self.motion.trajectory.v, k), column(&self.motion.trajectory.v, k - 1));
        let changes = v.iter().zip(before).map(|(v, before)| v - before);
        let change = self.stepper.newton.weights.of_velocities(changes);
        let has_missed = self.stepper.newton.miss.change > SURPRISE * change;
        let turns = |k: usize| self.turns_by(k, JERK);
        let is_surprising = has_missed && (history >= GUESSED || k >= 2 && turns(k));
        // Of the first step nothing can be expected before the second.
        if k == 2 && self.motion.first == 0 {
            self.motion.surprising[1] = turns(2);
        }
        self.motion.surprising[k] = is_surprising;
    }
}
