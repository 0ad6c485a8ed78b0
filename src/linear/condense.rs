//! The choice of the unknowns that are condensed: eliminated one by one, ahead of all groups.

use std::collections::BTreeSet;

use super::graph::Graph;
use super::pattern::Pattern;

/// A condensed unknown and the unknowns that its elimination couples.
#[derive(Debug, Clone)]
pub(super) struct Condensed {
    pub(super) unknown: usize,
    pub(super) neighbours: Vec<usize>,
}

/// Chooses the condensed unknowns in the order of their elimination and takes them out of `graph`.
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
    /// Constant unknowns with and without a structurally nonzero diagonal that have to be looked at (again): of all others it is known that
    /// they cannot be condensed before a neighbour is.
    due: [BTreeSet<usize>; 2],
}

impl Search<'_> {
    /// Condenses what can be among the unknowns with (or without) a structurally nonzero diagonal, in ascending order.
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

    /// The diagonal is structurally nonzero, or all coordinates that touch it are gone and have filled it.
    fn has_pivot(&self, unknown: usize) -> bool {
        let mut coordinates = self.original.neighbours(unknown).filter(|&n| self.diagonal[n]).peekable();
        self.diagonal[unknown] || (coordinates.peek().is_some() && coordinates.all(|n| self.gone[n]))
    }

    /// The neighbours lie in one group, or in two that are adjacent.
    fn adds_no_group_edge(&self, unknown: usize) -> bool {
        let mut groups = self.graph.neighbours(unknown).map(|n| self.group_of[n]);
        let Some(a) = groups.next() else { return true };
        let Some(b) = groups.find(|&b| b != a) else { return true };
        groups.all(|c| c == a || c == b) && self.adjacent((a, b), self.group_of[unknown])
    }

    /// Whether two groups are adjacent, which they are if an unknown of the one, as the one in question, has neighbours in the other.
    fn adjacent(&self, (a, b): (usize, usize), own: usize) -> bool {
        let members = |g: usize| self.pattern.groups[g].unknowns.iter();
        let degree = |g: usize| members(g).map(|&u| self.graph.degree(u)).sum::<usize>();
        let (few, many) = if degree(a) < degree(b) { (a, b) } else { (b, a) };
        own == a || own == b || members(few).any(|&u| self.graph.neighbours(u).any(|n| self.group_of[n] == many))
    }
}
