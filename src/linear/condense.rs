//! Choice of the condensed unknowns, which are eliminated one by one before all groups.

use std::collections::BTreeSet;

use super::graph::Graph;
use super::pattern::Pattern;

/// A condensed unknown and the unknowns that its elimination couples.
#[derive(Debug, Clone)]
pub(super) struct Condensed {
    pub(super) unknown: usize,
    pub(super) neighbours: Vec<usize>,
}

/// Chooses the condensed unknowns in the order of their elimination and removes them from `graph`.
///
/// A constant unknown is condensed if its pivot cannot vanish structurally and if its elimination joins
/// no two groups that are not adjacent already.
pub(super) fn condense(pattern: &Pattern, graph: &mut Graph) -> Vec<Condensed> {
    let diagonal = pattern.diagonal();
    let due = [true, false].map(|with| (0..pattern.size).filter(|&u| pattern.constant[u] && diagonal[u] == with).collect());
    let mut search = Search {
        original: graph.clone(),
        diagonal,
        group_of: pattern.group_of(),
        pattern,
        graph,
        gone: vec![false; pattern.size],
        due,
    };
    let mut condensed = Vec::new();
    loop {
        let before = condensed.len();
        search.pass(true, &mut condensed);
        if condensed.len() == before {
            search.pass(false, &mut condensed);
        }
        if condensed.len() == before {
            return condensed;
        }
    }
}

struct Search<'a> {
    pattern: &'a Pattern,
    original: Graph,
    diagonal: Vec<bool>,
    group_of: Vec<usize>,
    graph: &'a mut Graph,
    gone: Vec<bool>,
    /// Constant unknowns with and without a structurally nonzero diagonal that must be examined (again). All others cannot be condensed
    /// before one of their neighbours is.
    due: [BTreeSet<usize>; 2],
}

impl Search<'_> {
    /// Condenses unknowns with (or without) a structurally nonzero diagonal where possible, in ascending order.
    fn pass(&mut self, diagonal: bool, condensed: &mut Vec<Condensed>) {
        let mut from = 0;
        while let Some(&unknown) = self.due[usize::from(!diagonal)].range(from..).next() {
            from = unknown + 1;
            self.due[usize::from(!diagonal)].remove(&unknown);
            if self.has_pivot(unknown) && self.adds_no_group_edge(unknown) {
                let neighbours = self.graph.eliminate(unknown);
                self.gone[unknown] = true;
                for &n in neighbours.iter().filter(|&&n| self.pattern.constant[n]) {
                    self.due[usize::from(!self.diagonal[n])].insert(n);
                }
                condensed.push(Condensed { unknown, neighbours });
            }
        }
    }

    /// True if the diagonal is structurally nonzero, or if all coordinates coupled to the unknown are eliminated and have filled it.
    fn has_pivot(&self, unknown: usize) -> bool {
        let mut coordinates = self.original.neighbours(unknown).filter(|&n| self.diagonal[n]).peekable();
        self.diagonal[unknown] || (coordinates.peek().is_some() && coordinates.all(|n| self.gone[n]))
    }

    /// True if the neighbours lie in one group, or in two adjacent ones.
    fn adds_no_group_edge(&self, unknown: usize) -> bool {
        let mut groups = self.graph.neighbours(unknown).map(|n| self.group_of[n]);
        let Some(a) = groups.next() else { return true };
        let Some(b) = groups.find(|&b| b != a) else { return true };
        groups.all(|c| c == a || c == b) && self.adjacent((a, b), self.group_of[unknown])
    }

    /// Whether two groups are adjacent. They are if one of them is `own`, the group of an unknown that has neighbours in both.
    fn adjacent(&self, (a, b): (usize, usize), own: usize) -> bool {
        let members = |g: usize| self.pattern.groups[g].unknowns.iter();
        let degree = |g: usize| members(g).map(|&u| self.graph.degree(u)).sum::<usize>();
        let (few, many) = if degree(a) < degree(b) { (a, b) } else { (b, a) };
        own == a || own == b || members(few).any(|&u| self.graph.neighbours(u).any(|n| self.group_of[n] == many))
    }
}
