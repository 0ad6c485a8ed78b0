//! Division of the memory of a [`LongSolver`] into a window and checkpoints.

use super::LongSolver;
use crate::forward::{Checkpoint, HISTORY};
use crate::motion::{Refinement, Trajectory};
use crate::{Error, Settings};

/// Largest number of levels; with more, the additional work would outweigh the saved memory.
const MOST_LEVELS: usize = 4;
/// Number of nodes of the shortest useful window.
pub(super) const SHORTEST: usize = 16;

/// Division of the memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    /// Largest number of nodes of the grid.
    pub(super) nodes: usize,
    /// L, the number of nodes of the window.
    pub(super) window: usize,
    /// c, the number of checkpoints of a level.
    pub(super) checkpoints: usize,
    /// r, the number of levels.
    pub(super) levels: usize,
}

impl Plan {
    pub(super) const NONE: Plan = Plan { nodes: 0, window: 0, checkpoints: 0, levels: 0 };

    /// Number of nodes between two checkpoints of the first level.
    pub(super) fn part(&self) -> usize {
        (self.nodes - 1).div_ceil(self.checkpoints.max(1)).max(self.window)
    }
}

impl LongSolver {
    pub(super) fn bytes_per_node(&self) -> usize {
        let every = if self.leaves_out { 1 } else { self.settings.rebase_every };
        self.system.bytes_per_node(&Settings { rebase_every: every, ..self.settings })
    }

    /// The bytes stored for a grid of `nodes` nodes in addition to windows and checkpoints.
    pub(super) fn bytes_of_grid(&self, nodes: usize) -> usize {
        let number = size_of::<f64>();
        let inserted = nodes - self.given;
        // Inputs on the grid that is used, and gradients on the given grid.
        let columns = (nodes + self.sweeps.len() * self.given) * (1 + self.system.k()) * number;
        // While events are located, the grid that is tried is stored beside the one that is used.
        let columns = columns + if self.has_events { nodes * (1 + self.system.k()) * number } else { 0 };
        let columns = columns + self.timed_bytes;
        // The nodes and times of the given grid, to find those that kinks lie between.
        let columns =
            columns + if self.sweeps.len() > 1 && (self.follows || self.has_events) { 2 * number * self.given } else { 0 };
        // The list of inserted nodes may have a capacity of twice its length; if there are no sweeps, one refinement is still needed for the sums of
        // the motion.
        columns + 2 * inserted * size_of::<usize>() + self.sweeps.len().max(1) * Refinement::bytes(self.given, inserted)
    }

    /// Error with the memory that suffices for `nodes` nodes, or `least` if that is more.
    pub(super) fn too_little(&self, nodes: usize, least: usize) -> Error {
        let plan = |bytes| self.plan_within(bytes, nodes);
        let (mut too_few, mut needed) = (self.bytes, 2 * self.bytes + 1024);
        while plan(needed).is_none() {
            (too_few, needed) = (needed, 2 * needed);
        }
        while needed - too_few > needed / 100 {
            let middle = too_few + (needed - too_few) / 2;
            *(if plan(middle).is_some() { &mut needed } else { &mut too_few }) = middle;
        }
        Error::Memory { given: self.bytes, needed: needed.max(least) }
    }

    /// The plan with the fewest levels that covers a grid of `nodes` nodes within `bytes` bytes.
    pub(super) fn plan_within(&self, bytes: usize, nodes: usize) -> Option<Plan> {
        let stored = self.bytes_per_node();
        let len = Trajectory::<f64>::len_of_node(self.system.n(), self.system.m());
        let behind = self.system.m() + self.system.n();
        let checkpoint = (HISTORY * len + behind) * size_of::<f64>() + size_of::<Checkpoint>();
        let free = bytes.checked_sub(self.bytes_of_grid(nodes) + HISTORY * stored)?;
        // Without a backward sweep no checkpoints are needed.
        if self.sweeps.is_empty() {
            let window = nodes.min(free / stored);
            return (window >= SHORTEST.min(nodes)).then_some(Plan { nodes, window, checkpoints: 0, levels: 0 });
        }
        if free >= nodes * stored {
            return Some(Plan { nodes, window: nodes, checkpoints: 0, levels: 0 });
        }
        let plans = (1..=MOST_LEVELS).map(|levels| {
            let (window, checkpoints) = (free / 2 / stored, free / 2 / checkpoint / levels);
            Plan { nodes, window, checkpoints, levels }
        });
        let reach = |plan: &Plan| plan.window as f64 * (plan.checkpoints as f64).powi(plan.levels as i32);
        plans.into_iter().find(|plan| plan.window >= SHORTEST && reach(plan) >= nodes as f64)
    }
}
