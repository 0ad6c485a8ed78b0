//! [`Ahead`]: the part of a grid that is not computed yet.

/// The steps ahead of the current one, while steps are halved.
pub(crate) struct Ahead {
    /// True if a step was halved.
    pub(crate) is_halved: bool,
    pub(crate) gap: usize,
    /// Number of halvings of the current step, and those of the parts after it in its given step, the next one last.
    pub(crate) halvings: usize,
    pub(crate) parts: Vec<usize>,
    /// Steps up to this node are repeated as they were computed before.
    pub(crate) known: usize,
    /// Largest number of nodes for which there is memory.
    pub(crate) most_nodes: usize,
}

impl Ahead {
    pub(crate) fn new() -> Self {
        Ahead { is_halved: false, gap: 0, halvings: 0, parts: Vec::new(), known: 0, most_nodes: usize::MAX }
    }

    /// Forgets all steps except those of the given grid.
    pub(crate) fn forget(&mut self) {
        (self.gap, self.known) = (0, 0);
        self.again();
    }

    /// True if all nodes were computed before.
    pub(crate) fn is_known(&self, nodes: usize) -> bool {
        self.known + 1 == nodes
    }

    /// Begins to repeat the grid as far as it is known.
    pub(crate) fn again(&mut self) {
        (self.is_halved, self.halvings) = (false, 0);
        self.parts.clear();
    }
}
