//! Groups that wait for whole branches of a tree. The time to find them hardly depends on the lengths of the branches.
//!
//! A group waits at the lowest group of its branch that is not done. When that one is done, all groups waiting there move up together to the
//! next one above, except those whose branches end before it; a heap returns the one with the deepest end first.

use std::collections::BinaryHeap;

use super::pattern::Group;

/// The parent of a root.
const GROUND: usize = usize::MAX;

/// The waiting groups, and where they wait.
pub(super) struct Waiting {
    parent: Vec<usize>,
    depth: Vec<usize>,
    /// For a group that is done, a group further up with only done groups between them; otherwise the group itself.
    above: Vec<usize>,
    /// The groups that wait at each group, sorted by the depth of the uppermost group of their branch.
    here: Vec<BinaryHeap<(usize, usize)>>,
    /// The number of branches for which each group waits.
    left: Vec<usize>,
}

impl Waiting {
    /// Initially, all groups wait for all their branches.
    pub(super) fn new(groups: &[Group]) -> Self {
        let parent: Vec<usize> = groups.iter().map(|group| group.parent.unwrap_or(GROUND)).collect();
        let depth = depths(&parent);
        let mut waiting = Waiting {
            parent,
            depth,
            above: (0..groups.len()).collect(),
            here: vec![BinaryHeap::new(); groups.len()],
            left: vec![0; groups.len()],
        };
        for (g, group) in groups.iter().enumerate() {
            for branch in group.after.iter().filter(|branch| branch.length > 0) {
                let end = (waiting.depth[branch.from] + 1).saturating_sub(branch.length).max(1);
                waiting.here[branch.from].push((end, g));
                waiting.left[g] += 1;
            }
        }
        waiting
    }

    /// Whether a group must not be eliminated yet.
    pub(super) fn waits(&self, g: usize) -> bool {
        self.left[g] > 0
    }

    /// Marks a group as done, and passes the groups that no longer wait to `freed`.
    pub(super) fn done(&mut self, g: usize, mut freed: impl FnMut(usize)) {
        self.above[g] = self.parent[g];
        let next = self.next(g);
        let depth = if next == GROUND { 0 } else { self.depth[next] };
        let mut here = std::mem::take(&mut self.here[g]);
        while let Some((_, waiting)) = here.peek().copied().filter(|(end, _)| *end > depth) {
            here.pop();
            self.left[waiting] -= 1;
            if self.left[waiting] == 0 {
                freed(waiting);
            }
        }
        if next != GROUND {
            self.here[next].append(&mut here);
        }
    }

    /// The first group that is not done on the path from here to the root.
    fn next(&mut self, mut g: usize) -> usize {
        while g != GROUND && self.above[g] != g {
            let above = self.above[g];
            if above != GROUND {
                self.above[g] = self.above[above];
            }
            g = above;
        }
        g
    }
}

/// The number of groups on the path from each group to its root, both included.
fn depths(parent: &[usize]) -> Vec<usize> {
    let mut depth = vec![0; parent.len()];
    let mut path = Vec::new();
    for from in 0..parent.len() {
        let mut g = from;
        while g != GROUND && depth[g] == 0 {
            path.push(g);
            g = parent[g];
        }
        let mut below = if g == GROUND { 0 } else { depth[g] };
        while let Some(g) = path.pop() {
            below += 1;
            depth[g] = below;
        }
    }
    depth
}
