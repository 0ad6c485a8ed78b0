//! The structure of the matrix, as described by the caller.

use super::graph::Graph;

/// Structure of a square matrix K and of the grouping of its unknowns.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pattern {
    /// Number of unknowns.
    pub(crate) size: usize,
    /// Number of unknowns that are not multipliers, the first ones.
    pub(crate) coordinates: usize,
    /// Structural nonzeros (row, column), in any order; (i, j) also represents (j, i). A diagonal entry is
    /// listed only if it is structurally nonzero.
    pub(crate) entries: Vec<(usize, usize)>,
    /// Per unknown: true if its row and column keep their values between calls of `set_constant`.
    pub(crate) constant: Vec<bool>,
    /// Disjoint groups that together contain every unknown.
    pub(crate) groups: Vec<Group>,
}

/// Unknowns that are eliminated together.
#[derive(Debug, Clone, Default)]
pub(crate) struct Group {
    /// The unknowns of the group.
    pub(crate) unknowns: Vec<usize>,
    /// The parent in the tree to which branches refer; `None` for a root and for a group outside the tree.
    pub(crate) parent: Option<usize>,
    /// Branches that must be eliminated before this group.
    pub(crate) after: Vec<Branch>,
    /// True if the best pivots must be chosen, because coordinates without inertia have none of their own.
    pub(crate) chooses_pivots: bool,
}

/// A group, its parent, its parent's parent, …: `length` groups in total.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Branch {
    pub(crate) from: usize,
    pub(crate) length: usize,
}

impl Pattern {
    /// The graph of the off-diagonal entries.
    pub(super) fn graph(&self) -> Graph {
        let mut graph = Graph::new(self.size);
        for &(row, col) in &self.entries {
            graph.connect(row, col);
        }
        graph
    }

    /// Per unknown: true if its diagonal entry is structurally nonzero.
    pub(super) fn diagonal(&self) -> Vec<bool> {
        let mut diagonal = vec![false; self.size];
        for &(row, col) in &self.entries {
            diagonal[row] |= row == col;
        }
        diagonal
    }

    /// Per unknown: the index of its group.
    pub(crate) fn group_of(&self) -> Vec<usize> {
        let mut group_of = vec![0; self.size];
        for (g, group) in self.groups.iter().enumerate() {
            for &unknown in &group.unknowns {
                group_of[unknown] = g;
            }
        }
        group_of
    }

    /// Moves all unknowns of a group to another one.
    pub(crate) fn join(&mut self, own: usize, other: usize) {
        let Group { unknowns, after, .. } = &mut self.groups[own];
        let (unknowns, after) = (std::mem::take(unknowns), std::mem::take(after));
        let into = &mut self.groups[other];
        into.unknowns.extend(unknowns);
        into.unknowns.sort_unstable();
        into.after.extend(after);
        into.chooses_pivots = true;
    }

    /// The entries of the symmetrised pattern, in ascending order without duplicates.
    pub(super) fn symmetric_entries(&self) -> Vec<(usize, usize)> {
        let mirrored = self.entries.iter().map(|&(row, col)| (col, row));
        let mut entries: Vec<_> = self.entries.iter().copied().chain(mirrored).collect();
        entries.sort_unstable();
        entries.dedup();
        entries
    }

    /// True if every unknown is in exactly one group and every index is in range.
    pub(super) fn is_consistent(&self) -> bool {
        let mut seen = vec![0; self.size];
        for &unknown in self.groups.iter().flat_map(|group| &group.unknowns) {
            match seen.get_mut(unknown) {
                Some(count) => *count += 1,
                None => return false,
            }
        }
        let afters = self.groups.iter().flat_map(|group| group.after.iter().map(|branch| branch.from));
        let mut mentioned = afters.chain(self.groups.iter().filter_map(|group| group.parent));
        self.constant.len() == self.size
            && seen.iter().all(|&count| count == 1)
            && self.entries.iter().all(|&(i, j)| i < self.size && j < self.size)
            && mentioned.all(|g| g < self.groups.len())
    }
}
