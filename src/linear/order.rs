//! The order in which the groups are eliminated.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::fill::Fill;
use super::graph::Graph;
use super::pattern::Group;
use super::waiting::Waiting;

/// A group when it is eliminated, with the groups it is then coupled to.
#[derive(Debug, Clone)]
pub(super) struct Eliminated {
    pub(super) group: usize,
    pub(super) neighbours: Vec<usize>,
}

/// Groups are chosen by the smallest cost: whether the group must wait, fill, height, degree, index.
type Cost = (bool, usize, usize, usize, usize);

/// Orders the nonempty groups by minimum fill; the groups in `after` of a group precede it.
///
/// Ties are resolved by the smallest height above the leaves, so that independent branches (also the two ends of a chain) are
/// eliminated alternately and the processor can overlap them; then by the minimum degree and the smallest index. Fill and
/// degree are measured in unknowns (`sizes`). Chains and trees get no fill, which the degree alone would not ensure. If a cycle of `after`
/// blocks all remaining groups, the condition is waived for one step.
pub(super) fn order(graph: &Graph, sizes: &[usize], groups: &[Group]) -> Vec<Eliminated> {
    let mut left = Left::new(graph, sizes, groups);
    let mut order = Vec::with_capacity(groups.len());
    while let Some(group) = left.cheapest() {
        let neighbours = left.eliminate(group);
        order.push(Eliminated { group, neighbours });
    }
    order
}

/// The groups that are not eliminated yet.
struct Left<'a> {
    fill: Fill<'a>,
    waiting: Waiting,
    heights: Vec<usize>,
    done: Vec<bool>,
    /// Costs of the groups; outdated ones remain in the heap and are skipped.
    costs: BinaryHeap<Reverse<Cost>>,
    changed: Vec<usize>,
}

impl<'a> Left<'a> {
    fn new(graph: &Graph, sizes: &'a [usize], groups: &[Group]) -> Self {
        let mut left = Left {
            fill: Fill::new(graph, sizes),
            waiting: Waiting::new(groups),
            heights: vec![0; sizes.len()],
            done: sizes.iter().map(|&size| size == 0).collect(),
            costs: BinaryHeap::new(),
            changed: Vec::new(),
        };
        (0..sizes.len()).filter(|&g| sizes[g] == 0).for_each(|g| left.waiting.done(g, |_| ()));
        (0..sizes.len()).for_each(|g| left.put(g));
        left
    }

    fn cost(&self, g: usize) -> Cost {
        (self.waiting.waits(g), self.fill.of(g), self.heights[g], self.fill.degree(g), g)
    }

    /// Adds a remaining group with its present cost.
    fn put(&mut self, g: usize) {
        if !self.done[g] {
            self.costs.push(Reverse(self.cost(g)));
        }
    }

    /// Removes and returns the group with the smallest cost.
    fn cheapest(&mut self) -> Option<usize> {
        while let Some(Reverse(cost)) = self.costs.pop() {
            let group = cost.4;
            if !self.done[group] && cost == self.cost(group) {
                return Some(group);
            }
        }
        None
    }

    /// Eliminates a group and returns its neighbours.
    fn eliminate(&mut self, group: usize) -> Vec<usize> {
        let mut changed = std::mem::take(&mut self.changed);
        let neighbours = self.fill.eliminate(group, &mut changed);
        self.done[group] = true;
        for &n in &neighbours {
            self.heights[n] = self.heights[n].max(self.heights[group] + 1);
        }
        self.waiting.done(group, |freed| changed.push(freed));
        changed.iter().for_each(|&g| self.put(g));
        self.changed = changed;
        neighbours
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::pattern::Branch;
    use crate::linear::samples::Random;

    /// The order by definition: all costs are computed again for every elimination.
    fn by_definition(mut graph: Graph, sizes: &[usize], groups: &[Group]) -> Vec<usize> {
        let mut done: Vec<bool> = sizes.iter().map(|&size| size == 0).collect();
        let mut heights = vec![0; sizes.len()];
        let mut order = Vec::new();
        loop {
            let waits = |g: usize| {
                groups[g].after.iter().any(|branch| {
                    let up = std::iter::successors(Some(branch.from), |&g| groups[g].parent);
                    up.take(branch.length).any(|g| !done[g])
                })
            };
            let cost = |&g: &usize| {
                let near: Vec<usize> = graph.neighbours(g).collect();
                let pairs = near.iter().enumerate().flat_map(|(k, &a)| near[..k].iter().map(move |&b| (a, b)));
                let fill: usize = pairs.filter(|&(a, b)| !graph.adjacent(a, b)).map(|(a, b)| sizes[a] * sizes[b]).sum();
                (waits(g), fill, heights[g], near.iter().map(|&n| sizes[n]).sum::<usize>())
            };
            let Some(group) = (0..sizes.len()).filter(|&g| !done[g]).min_by_key(cost) else { return order };
            done[group] = true;
            for n in graph.eliminate(group) {
                heights[n] = heights[n].max(heights[group] + 1);
            }
            order.push(group);
        }
    }

    #[test]
    fn costs_kept_up_to_date_give_the_order_of_costs_found_anew() {
        let random = &mut Random(3);
        for case in 0..300 {
            let count = 1 + random.below(30);
            let sizes: Vec<usize> = (0..count).map(|_| random.below(4)).collect();
            let mut graph = Graph::new(count);
            let mut groups = vec![Group::default(); count];
            for g in 0..count {
                groups[g].parent = (g > 0 && random.below(8) > 0).then(|| random.below(g));
                if let Some(parent) = groups[g].parent.filter(|_| sizes[g] > 0) {
                    graph.connect(g, parent);
                }
            }
            for _ in 0..random.below(2 * count) {
                graph.connect(random.below(count), random.below(count));
            }
            // Some groups wait for branches of all lengths, also in cycles.
            for _ in 0..random.below(count) {
                let branch = Branch { from: random.below(count), length: random.below(6) };
                groups[random.below(count)].after.push(branch);
            }
            let ours: Vec<usize> = order(&graph, &sizes, &groups).iter().map(|node| node.group).collect();
            assert_eq!(ours, by_definition(graph, &sizes, &groups), "case {case}: {sizes:?} {groups:?}");
        }
    }
}
