//! [`Checkpoint`]: data from which a motion is continued with bitwise identical results.

use crate::Trajectory;
use crate::forward::{ForwardSweep, HISTORY, Stepper};
use crate::motion::Clock;

/// The last nodes before a part of a motion, stored as columns, and the first node from which extrapolation is allowed. Behind the columns follow the
/// last σ before a restart and the largest coordinates.
pub(super) struct Checkpoint {
    pub(super) node: usize,
    clock: Clock,
    smooth_from: usize,
    most_range: f64,
    last_end: usize,
    columns: Vec<f64>,
}

impl ForwardSweep {
    pub(super) fn len_of_node(&self) -> usize {
        Trajectory::<f64>::len_of_node(self.motion.trajectory.q.nrows(), self.motion.trajectory.sigma.nrows())
    }

    /// Stores the last computed nodes.
    pub(super) fn save(&self) -> Checkpoint {
        let computed = self.motion.trajectory.computed;
        let count = HISTORY.min(computed);
        let behind = self.restarting.last_end.sigma.len() + self.monitor.lengths.reach.len();
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

    /// Restores the state of a checkpoint.
    pub(super) fn load(&mut self, checkpoint: &Checkpoint) {
        let (columns, reach) = checkpoint.columns.split_at(checkpoint.columns.len() - self.monitor.lengths.reach.len());
        let (columns, sigma) = columns.split_at(columns.len() - self.restarting.last_end.sigma.len());
        self.monitor.lengths.reach.copy_from_slice(reach);
        self.restarting.last_end.node = checkpoint.last_end;
        self.restarting.last_end.sigma.copy_from_slice(sigma);
        let columns = columns.chunks_exact(self.len_of_node());
        self.motion.trajectory.computed = columns.len();
        self.motion.first = checkpoint.node + 1 - columns.len();
        columns.enumerate().for_each(|(k, column)| self.motion.trajectory.set_column(k, column));
        self.stepper.set_clock(checkpoint.node, checkpoint.clock);
        (self.stepper.smooth_from, self.restarting.most_range) = (checkpoint.smooth_from, checkpoint.most_range);
        self.stepper.newton.linearisation.evaluation.set_compliance(self.motion.trajectory.compliance_from(checkpoint.node));
        self.motion.events.clear();
        self.motion.ahead.again();
        self.motion.trajectory.restarted.truncate(1);
        self.motion.trajectory.restarted.retain(|&node| node <= checkpoint.node);
    }
}
