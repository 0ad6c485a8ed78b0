//! Halving of steps that have no solution, repeatedly if necessary: the motion continues on a grid that is recorded as it is computed.
//!
//! From the first halved step on, the lists of the inputs contain the computed steps, a gap, and the steps ahead:
//!
//! ```text
//!   ├── taken ──┤   gap   ├── ahead ──┤
//! ```
//!
//! Computing a step moves it across the gap; halving one adds its second half to the steps ahead. Both take the same time for any length of the
//! lists, because a gap that is used up is enlarged in proportion to them. At the end no step is ahead, and the gap is removed.

use nalgebra::DMatrix;

use super::computed::Motion;
use super::{Refinement, column_mut};
use crate::{Inputs, Settings};

/// Largest number of halvings of a step; shorter parts would be lost in its rounding.
const MOST_HALVINGS: usize = 52;
/// Smallest number of nodes in a gap, and number of grid nodes for one node in it.
const GAP: (usize, usize) = (16, 2);

impl Motion {
    /// The number of nodes of the grid, as far as it is known.
    pub(crate) fn nodes(&self) -> usize {
        self.inputs.grid.nodes() - self.ahead.gap
    }

    /// The relation between the computed grid and the given grid.
    pub(crate) fn refinement(&self) -> Refinement {
        let Inputs { grid, events, .. } = &self.inputs;
        Refinement::new((&grid.steps, events), grid.around, &self.trajectory.inserted)
    }

    /// Number (from 1) of the given step that contains or ends at `node`, counted in the longer motion of which this motion is a part; 0 at the start
    /// of this motion.
    pub(crate) fn step_of_whole(&self, node: usize) -> usize {
        if node == 0 { 0 } else { self.node_of_whole(node) }
    }

    /// The number of the given node at or after a node, in the longer motion of which this one is a part.
    pub(crate) fn node_of_whole(&self, node: usize) -> usize {
        self.inputs.grid.around[0] + node - self.trajectory.inserted.partition_point(|&inserted| inserted < node)
    }

    /// The number of macro steps of the whole motion before a node; `None` if no macro step ends there.
    pub(crate) fn macro_steps(&self, node: usize) -> Option<usize> {
        let inserted = &self.trajectory.inserted;
        let before = inserted.partition_point(|&inserted| inserted < node);
        if inserted.get(before) == Some(&node) { None } else { self.inputs.grid.macro_steps(node - before) }
    }

    /// True if a macro step ends at a node, or if it was inserted into a step that is none of several.
    pub(crate) fn ends_macro_step(&self, node: usize) -> bool {
        self.inputs.grid.stages == 1 || self.macro_steps(node).is_some()
    }

    /// The length of the given step that contains the current step, which ends at `node`.
    pub(crate) fn given_length(&self, node: usize) -> f64 {
        self.length(node) * 2f64.powi(self.ahead.halvings as i32)
    }

    /// Makes the step that ends at a node the current one.
    #[inline]
    pub(crate) fn take(&mut self, node: usize) {
        if self.ahead.is_halved {
            self.ahead.halvings = self.ahead.parts.pop().unwrap_or(0);
            self.carry(node + self.ahead.gap, node);
        }
    }

    /// Keeps the step that ends at this node, because it has a solution.
    #[inline]
    pub(crate) fn keep(&mut self, node: usize) {
        if !self.ahead.parts.is_empty() {
            self.trajectory.inserted.push(node);
        }
    }

    /// True if the motion has reached this node before.
    pub(crate) fn has_been_at(&self, node: usize) -> bool {
        node <= self.ahead.known
    }

    /// Forgets the compliances of the start and of unknown nodes; those chosen at known nodes are used again.
    pub(crate) fn forget_compliance(&mut self) {
        let known = self.ahead.known;
        self.trajectory.compliance.retain(|part| 0 < part.from && part.from <= known);
    }

    /// Marks the nodes before this one as known.
    pub(crate) fn know(&mut self, node: usize) {
        self.ahead.known = self.ahead.known.max(node - 1);
    }

    /// Returns the current step to the steps ahead.
    pub(crate) fn put_back(&mut self, node: usize) {
        self.carry(node, node + self.ahead.gap);
        if self.ahead.halvings > 0 {
            self.ahead.parts.push(self.ahead.halvings);
        }
    }

    /// Takes the given steps and controls behind a node that was computed; steps before it keep their halvings, and all others are forgotten.
    pub(crate) fn retake(&mut self, node: usize, given: &Inputs) {
        let inserted = self.trajectory.inserted.partition_point(|&inserted| inserted <= node);
        self.trajectory.inserted.truncate(inserted);
        self.trajectory.compliance.retain(|part| part.from <= node);
        self.ahead.forget();
        self.ahead.known = node;
        let (before, nodes) = (node - inserted, given.grid.nodes() + inserted);
        let Motion { inputs, .. } = self;
        inputs.grid.steps.truncate(node);
        inputs.grid.steps.extend_from_slice(&given.grid.steps[before..]);
        if inputs.controls.ncols() != nodes {
            let controls = std::mem::replace(&mut inputs.controls, DMatrix::zeros(0, 0));
            inputs.controls = controls.resize_horizontally(nodes, 0.0);
        }
        inputs.controls.columns_mut(node + 1, nodes - node - 1).copy_from(&given.controls.columns_range(before + 1..));
        if !self.is_window() && self.trajectory.times.len() != nodes {
            self.make_room(nodes);
        }
    }

    /// Copies the step that ends at `from`, and the controls at its end, to the step that ends at `to`.
    fn carry(&mut self, from: usize, to: usize) {
        let Motion { inputs, .. } = self;
        inputs.grid.steps[to - 1] = inputs.grid.steps[from - 1];
        let channels = inputs.controls.nrows();
        inputs.controls.as_mut_slice().copy_within(from * channels..(from + 1) * channels, to * channels);
    }

    /// True if the step that ends at a node may be halved.
    pub(crate) fn may_halve(&self, node: usize, settings: &Settings) -> bool {
        // Shorter steps would end where they begin, up to rounding.
        let (t, dt) = (self.time(node - 1), self.length(node));
        let most = settings.max_halvings.min(MOST_HALVINGS);
        node > self.ahead.known && self.ahead.halvings < most && t + 0.25 * dt != t
    }

    /// Inserts a node in the middle of the current step, which ended at `node`, with the mean of the controls at its ends.
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

    /// Moves the steps after a node, to make room before them.
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

    /// Removes the gap: the steps ahead follow the step that ends at a node, which is the last one computed.
    pub(crate) fn close_gap(&mut self, node: usize) {
        // If a motion ends before its grid does, nodes ahead that are not in the given grid count as inserted too.
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

    /// True if the trajectory is a window over a longer motion, which keeps its length.
    fn is_window(&self) -> bool {
        self.ahead.most_nodes < usize::MAX
    }

    /// Resizes the trajectory to a number of columns.
    pub(crate) fn make_room(&mut self, nodes: usize) {
        self.trajectory.resize(nodes);
        let blocks = std::mem::replace(&mut self.blocks, DMatrix::zeros(0, 0));
        self.blocks = blocks.resize_horizontally(nodes * self.trajectory.last_stage(), 0.0);
    }
}
