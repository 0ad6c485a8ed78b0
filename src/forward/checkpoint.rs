//! [`Checkpoint`]: data from which a motion is continued with bitwise identical results.

use super::{ForwardSweep, HISTORY, Stepper};
use crate::motion::{Clock, open};
use crate::{Inputs, Trajectory};

/// The last nodes before a part of a motion, stored as columns, and the first node from which extrapolation is allowed. Behind the columns follow the
/// last σ before a restart and the largest coordinates.
pub(crate) struct Checkpoint {
    pub(crate) node: usize,
    clock: Clock,
    smooth_from: usize,
    most_range: f64,
    last_end: usize,
    columns: Vec<f64>,
}

impl ForwardSweep {
    pub(crate) fn len_of_node(&self) -> usize {
        Trajectory::<f64>::len_of_node(self.motion.trajectory.q.nrows(), self.motion.trajectory.sigma.nrows())
    }

    /// Stores the last computed nodes.
    pub(crate) fn save(&self) -> Checkpoint {
        let computed = self.motion.trajectory.computed;
        let count = HISTORY.min(computed);
        let behind = self.len_of_rest();
        let mut columns = Vec::with_capacity(count * self.len_of_node() + behind);
        (computed - count..computed).for_each(|k| self.motion.trajectory.append_column(k, &mut columns));
        columns.extend_from_slice(&self.restarting.last_end.sigma);
        columns.extend_from_slice(&self.monitor.lengths.reach);
        let (node, last_end) = (self.motion.first + computed - 1, self.restarting.last_end.node);
        let Stepper { smooth_from, .. } = self.stepper;
        Checkpoint {
            node,
            clock: self.stepper.clock(),
            smooth_from,
            most_range: self.restarting.most_range,
            last_end,
            columns,
        }
    }

    /// Restores the state of a checkpoint at the beginning of the window.
    pub(crate) fn load(&mut self, checkpoint: &Checkpoint) {
        let count = self.count_of(checkpoint);
        let columns = checkpoint.columns.chunks_exact(self.len_of_node()).take(count);
        self.motion.trajectory.computed = count;
        self.motion.first = checkpoint.node + 1 - count;
        columns.enumerate().for_each(|(k, column)| self.motion.trajectory.set_column(k, column));
        self.motion.events.clear();
        self.motion.trajectory.restarted.truncate(1);
        self.restore(checkpoint);
    }

    /// Restores the state of a checkpoint whose nodes are still in the window.
    fn go_back(&mut self, checkpoint: &Checkpoint) {
        self.motion.trajectory.computed = checkpoint.node + 1 - self.motion.first;
        self.motion.events.truncate(checkpoint.node);
        self.restore(checkpoint);
    }

    /// Restores all but the nodes.
    fn restore(&mut self, checkpoint: &Checkpoint) {
        let rest = &checkpoint.columns[checkpoint.columns.len() - self.len_of_rest()..];
        let (sigma, reach) = rest.split_at(self.restarting.last_end.sigma.len());
        self.monitor.lengths.reach.copy_from_slice(reach);
        self.restarting.last_end.node = checkpoint.last_end;
        self.restarting.last_end.sigma.copy_from_slice(sigma);
        self.stepper.set_clock(checkpoint.node, checkpoint.clock);
        (self.stepper.smooth_from, self.restarting.most_range) = (checkpoint.smooth_from, checkpoint.most_range);
        let (linearisation, compliances) =
            (&mut self.stepper.newton.linearisation, self.motion.trajectory.compliance_from(checkpoint.node));
        linearisation.evaluation.set_compliance(compliances);
        linearisation.weights.set_open(|j| open(compliances).any(|open| open == j));
        self.motion.ahead.again();
        self.motion.trajectory.restarted.retain(|&node| node <= checkpoint.node);
    }

    /// Returns to a checkpoint, from which the motion continues with other steps.
    pub(super) fn rewind(&mut self, checkpoint: &Checkpoint, given: &Inputs) {
        // The nodes from which steps are extrapolated must be in the window, too.
        let is_here = self.motion.first + self.count_of(checkpoint) <= checkpoint.node + 1;
        if is_here && checkpoint.node < self.reached() {
            self.go_back(checkpoint);
        } else {
            self.load(checkpoint);
        }
        self.motion.retake(checkpoint.node, given);
    }

    /// The number of nodes of a checkpoint.
    fn count_of(&self, checkpoint: &Checkpoint) -> usize {
        (checkpoint.columns.len() - self.len_of_rest()) / self.len_of_node()
    }

    /// The number of values behind the columns of a checkpoint.
    fn len_of_rest(&self) -> usize {
        self.restarting.last_end.sigma.len() + self.monitor.lengths.reach.len()
    }
}
