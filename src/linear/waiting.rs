//! What has to wait for whole branches of a tree: found out in time that hardly depends on how long they are.
//!
//! A group waits below the lowest group of its branch that is not done. When that one is done, all that wait there move up together to the
//! next one above, except those whose branches end before it: a list that the deepest end comes out of first.

use std::collections::BinaryHeap;

use super::pattern::Group;

/// Beyond the root.
const GROUND: usize = usize::MAX;

/// Which groups wait, and where.
pub(super) struct Waiting {
    parent: Vec<usize>,
    depth: Vec<usize>,
    /// Of a group that is done, one further up with none but done ones between; itself of any other.
    above: Vec<usize>,
    /// Those that wait at a group, by the depth of the uppermost one that they wait for.
    here: Vec<BinaryHeap<(usize, usize)>>,
    /// For how many branches each group waits.
    left: Vec<usize>,
}

impl Waiting {
    /// All groups wait for all their branches.
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

    /// Takes note that a group is done, and shows those that need not wait any more.
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

    /// The first group from here to the root that is not done.
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

/// How many groups there are from each to its root, itself included.
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
