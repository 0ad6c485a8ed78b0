//! A window over a motion that is longer than its memory, with the last nodes, from which the next step is extrapolated.

use super::ForwardSweep;
use crate::node::Predictor;

/// Number of nodes that are kept when the window is moved.
pub(crate) const HISTORY: usize = Predictor::MOST;

impl ForwardSweep {
    /// The first node that is not computed.
    pub(crate) fn reached(&self) -> usize {
        self.motion.first + self.motion.trajectory.computed
    }

    /// Moves the last nodes to the front of the window.
    pub(crate) fn slide(&mut self) {
        let count = HISTORY.min(self.motion.trajectory.computed);
        let from = self.motion.trajectory.computed - count;
        self.motion.trajectory.move_to_front(from, count);
        self.motion.first += from;
        self.motion.trajectory.computed = count;
        self.motion.events.clear();
        // Only whether there were earlier restarts is needed.
        self.motion.trajectory.restarted.truncate(1);
    }
}
