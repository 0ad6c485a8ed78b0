//! A step that has no solution is halved, and its parts again: the motion goes on, on a grid that is written down as it is taken.
//!
//! From the first halved step on, the lists of the inputs hold what was taken, a gap, and what is ahead:
//!
//! ```text
//!   ├── taken ──┤   gap   ├── ahead ──┤
//! ```
//!
//! Taking a step carries it over the gap; halving one puts its second half to what is ahead. Either costs the same however long the lists
//! are, for a gap that is used up is made anew in proportion to them. At the end nothing is ahead, and the gap is left out.

use nalgebra::DMatrix;

use super::{ForwardSweep, Motion};
use crate::motion::{Refinement, column_mut};
use crate::{Settings, Warning};

/// Parts of a step below this share of it, as a power of ½, are lost in its rounding.
const MOST_HALVINGS: usize = 52;
/// A gap has so many nodes at least, or one of so many nodes of the grid.
const GAP: (usize, usize) = (16, 2);

/// What is ahead of the step at hand, while steps are halved.
pub(crate) struct Ahead {
    /// Whether there was a halved step.
    is_halved: bool,
    gap: usize,
    /// How often the step at hand is halved, and the parts that follow it in its given step, the next one last.
    halvings: usize,
    parts: Vec<usize>,
    /// Steps up to this node are taken again as they were taken before.
    known: usize,
    /// The most nodes that there is memory for.
    pub(crate) most_nodes: usize,
}

impl Ahead {
    pub(crate) fn new() -> Self {
        Ahead { is_halved: false, gap: 0, halvings: 0, parts: Vec::new(), known: 0, most_nodes: usize::MAX }
    }

    /// Nothing is known of the grid but what is given.
    pub(crate) fn forget(&mut self) {
        (self.gap, self.known) = (0, 0);
        self.again();
    }

    /// Whether a motion has had all nodes before.
    pub(crate) fn is_known(&self, nodes: usize) -> bool {
        self.known + 1 == nodes
    }

    /// The grid is taken again as far as it is known.
    pub(crate) fn again(&mut self) {
        (self.is_halved, self.halvings) = (false, 0);
        self.parts.clear();
    }
}

impl Motion {
    /// The number of nodes of the grid, as far as it is known.
    pub(crate) fn nodes(&self) -> usize {
        self.inputs.grid.nodes() - self.ahead.gap
    }

    /// How the grid taken follows from the given one.
    pub(crate) fn refinement(&self) -> Refinement {
        let grid = &self.inputs.grid;
        Refinement::new(&grid.steps, grid.around[0], &self.trajectory.inserted)
    }

    /// The number of the given step that ends at or behind a node, counted from 1, in the motion that this one is a part of; 0 for its start.
    pub(crate) fn step_of_whole(&self, node: usize) -> usize {
        if node == 0 { 0 } else { self.node_of_whole(node) }
    }

    /// The number of the given node that a node is or comes before, in the motion that this one is a part of.
    pub(crate) fn node_of_whole(&self, node: usize) -> usize {
        self.inputs.grid.around[0] + node - self.trajectory.inserted.partition_point(|&inserted| inserted < node)
    }

    /// The length of the given step that the step into a node, which is at hand, is or is a part of.
    pub(crate) fn given_length(&self, node: usize) -> f64 {
        self.length(node) * 2f64.powi(self.ahead.halvings as i32)
    }

    /// Makes the step into a node the one at hand.
    #[inline]
    pub(crate) fn take(&mut self, node: usize) {
        if self.ahead.is_halved {
            self.ahead.halvings = self.ahead.parts.pop().unwrap_or(0);
            self.carry(node + self.ahead.gap, node);
        }
    }

    /// The step into this node is taken and has a solution.
    #[inline]
    pub(crate) fn keep(&mut self, node: usize) {
        if !self.ahead.parts.is_empty() {
            self.trajectory.inserted.push(node);
        }
    }

    /// Whether the motion has come to this node before.
    pub(crate) fn has_been_at(&self, node: usize) -> bool {
        node <= self.ahead.known
    }

    /// The compliances that were chosen on the way are taken again as far as it is known.
    pub(crate) fn forget_compliance(&mut self) {
        let known = self.ahead.known;
        self.trajectory.compliance.retain(|part| 0 < part.from && part.from <= known);
    }

    /// The motion has come before this node.
    pub(crate) fn know(&mut self, node: usize) {
        self.ahead.known = self.ahead.known.max(node - 1);
    }

    /// Puts the step at hand back to those ahead.
    pub(crate) fn put_back(&mut self, node: usize) {
        self.carry(node, node + self.ahead.gap);
        if self.ahead.halvings > 0 {
            self.ahead.parts.push(self.ahead.halvings);
        }
    }

    /// Copies the step that stands before one place and the controls at its end to before another.
    fn carry(&mut self, from: usize, to: usize) {
        let Motion { inputs, .. } = self;
        inputs.grid.steps[to - 1] = inputs.grid.steps[from - 1];
        let channels = inputs.controls.nrows();
        inputs.controls.as_mut_slice().copy_within(from * channels..(from + 1) * channels, to * channels);
    }

    /// Whether the step that ends at a node may be shorter by half.
    pub(crate) fn may_halve(&self, node: usize, settings: &Settings) -> bool {
        // Below this the end of the step would be its beginning.
        let (t, dt) = (self.time(node - 1), self.length(node));
        let most = settings.max_halvings.min(MOST_HALVINGS);
        node > self.ahead.known && self.ahead.halvings < most && t + 0.25 * dt != t
    }

    /// Inserts a node in the middle of the step at hand, which ended at `node`, with the mean of the controls at its ends.
    pub(crate) fn halve(&mut self, node: usize) {
        if self.ahead.gap == 0 {
            self.open_gap(node);
        }
        self.ahead.gap -= 1;
        self.ahead.is_halved = true;
        self.ahead.halvings += 1;
        self.ahead.parts.push(self.ahead.halvings);
        self.inputs.grid.steps[node - 1] *= 0.5;
        self.carry(node, node + 1 + self.ahead.gap);
        let mean = 0.5 * (self.inputs.controls.column(node - 1) + self.inputs.controls.column(node));
        column_mut(&mut self.inputs.controls, node).copy_from_slice(mean.as_slice());
    }

    /// Moves what lies behind a node, to make room before it.
    fn open_gap(&mut self, node: usize) {
        let (steps, nodes) = (self.inputs.grid.steps.len(), self.inputs.grid.nodes());
        let gap = GAP.0.max(nodes / GAP.1).min(self.ahead.most_nodes - nodes);
        self.ahead.gap = gap;
        let Motion { inputs, .. } = self;
        inputs.grid.steps.reserve_exact(gap);
        inputs.grid.steps.resize(steps + gap, 0.0);
        inputs.grid.steps.copy_within(node..steps, node + gap);
        let channels = inputs.controls.nrows();
        let controls = std::mem::replace(&mut inputs.controls, DMatrix::zeros(0, 0));
        inputs.controls = controls.resize_horizontally(nodes + gap, 0.0);
        inputs.controls.as_mut_slice().copy_within((node + 1) * channels..nodes * channels, (node + 1 + gap) * channels);
        if !self.is_window() {
            self.make_room(nodes + gap);
        }
    }

    /// Leaves the gap out: all that is ahead follows the step into a node, which is the last one taken.
    pub(crate) fn close_gap(&mut self, node: usize) {
        // Where a motion ends before its grid does, nodes ahead that are not of the given grid count as inserted too.
        let parts = node..node + self.ahead.parts.len();
        let from = self.trajectory.inserted.last().map_or(0, |last| last + 1);
        self.trajectory.inserted.extend(parts.filter(|&node| node >= from));
        let gap = std::mem::take(&mut self.ahead.gap);
        self.ahead.again();
        if gap == 0 {
            return;
        }
        let (steps, nodes) = (self.inputs.grid.steps.len(), self.inputs.grid.nodes());
        let Motion { inputs, .. } = self;
        inputs.grid.steps.copy_within(node + gap.., node);
        inputs.grid.steps.truncate(steps - gap);
        inputs.grid.steps.shrink_to_fit();
        let channels = inputs.controls.nrows();
        inputs.controls.as_mut_slice().copy_within((node + 1 + gap) * channels.., (node + 1) * channels);
        let controls = std::mem::replace(&mut inputs.controls, DMatrix::zeros(0, 0));
        inputs.controls = controls.resize_horizontally(nodes - gap, 0.0);
        if !self.is_window() {
            self.make_room(nodes - gap);
        }
    }

    /// Whether the trajectory is a window over a longer motion, which keeps its length.
    fn is_window(&self) -> bool {
        self.ahead.most_nodes < usize::MAX
    }

    /// Makes the trajectory have so many columns.
    pub(crate) fn make_room(&mut self, nodes: usize) {
        self.trajectory.resize(nodes);
        let blocks = std::mem::replace(&mut self.blocks, DMatrix::zeros(0, 0));
        self.blocks = blocks.resize_horizontally(nodes * self.trajectory.last_stage(), 0.0);
    }
}

impl ForwardSweep {
    #[cold]
    pub(crate) fn warn_of_halved_steps(&mut self) {
        let (inserted, grid) = (&self.motion.trajectory.inserted, &self.motion.inputs.grid);
        let Some(&first) = inserted.first() else { return };
        // Every part begins or ends at an inserted node.
        let lengths = inserted.iter().map(|&node| grid.steps[node - 1].abs().min(grid.steps[node].abs()));
        let shortest = lengths.fold(f64::INFINITY, f64::min);
        let time = grid.time(first - 1);
        let step = self.motion.step_of_whole(first);
        self.monitor.report.warn(Warning::HalvedSteps { step, time, inserted: inserted.len(), shortest });
    }
}
