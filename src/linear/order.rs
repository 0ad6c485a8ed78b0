//! The order in which the groups are eliminated.

use super::graph::Graph;
use super::pattern::Group;

/// A group at its elimination, with the groups it is coupled to then.
#[derive(Debug, Clone)]
pub(super) struct Eliminated {
    pub(super) group: usize,
    pub(super) neighbours: Vec<usize>,
}

/// Orders the nonempty groups by minimum fill, a group's `after` going before it.
///
/// Ties go to the lowest height above the leaves, so that independent branches (the two ends of a chain, too) are
/// eliminated side by side and the processor can overlap them; then to the minimum degree and the lowest index. Fill and
/// degree are measured in unknowns (`sizes`). Chains and trees get no fill, which the degree alone would not ensure. If a cycle of `after`
/// blocks all groups that are left, the condition is waived for one step.
pub(super) fn order(mut graph: Graph, sizes: &[usize], groups: &[Group]) -> Vec<Eliminated> {
    let mut done: Vec<bool> = sizes.iter().map(|&size| size == 0).collect();
    let mut order = Vec::new();
    let mut heights = vec![0; sizes.len()];
    loop {
        let degree = |g| graph.neighbours(g).map(|n| sizes[n]).sum::<usize>();
        let cost = |&g: &usize| (fill(&graph, sizes, g), heights[g], degree(g));
        let left = || (0..sizes.len()).filter(|&g| !done[g]);
        let free = left().filter(|&g| groups[g].after.iter().all(|&a| done[a]));
        let Some(group) = free.min_by_key(cost).or(left().min_by_key(cost)) else {
            return order;
        };
        let neighbours = graph.eliminate(group);
        done[group] = true;
        for &n in &neighbours {
            heights[n] = heights[n].max(heights[group] + 1);
        }
        order.push(Eliminated { group, neighbours });
    }
}

/// Σ s_a s_b over the neighbours a, b of `group` that are not adjacent yet.
fn fill(graph: &Graph, sizes: &[usize], group: usize) -> usize {
    let pairs =
        (graph.neighbours(group).enumerate()).flat_map(|(k, a)| graph.neighbours(group).take(k).map(move |b| (a, b)));
    pairs.filter(|&(a, b)| !graph.adjacent(a, b)).map(|(a, b)| sizes[a] * sizes[b]).sum()
}
