//! The choice of the unknowns that are condensed: eliminated one by one, ahead of all groups.

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
    let mut search = Search {
        original: graph.clone(),
        diagonal: pattern.diagonal(),
        group_of: pattern.group_of(),
        pattern,
        graph,
        gone: vec![false; pattern.size],
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
}

impl Search<'_> {
    /// Condenses what can be among the unknowns with (or without) a structurally nonzero diagonal.
    fn pass(&mut self, diagonal: bool, condensed: &mut Vec<Condensed>) {
        for unknown in 0..self.pattern.size {
            let candidate = self.pattern.constant[unknown] && !self.gone[unknown];
            if candidate && self.diagonal[unknown] == diagonal && self.has_pivot(unknown) && self.adds_no_group_edge(unknown)
            {
                let neighbours = self.graph.eliminate(unknown);
                self.gone[unknown] = true;
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
        let mut groups: Vec<usize> = self.graph.neighbours(unknown).map(|n| self.group_of[n]).collect();
        groups.sort_unstable();
        groups.dedup();
        match groups[..] {
            [] | [_] => true,
            [a, b] => self.adjacent(a, b),
            _ => false,
        }
    }

    fn adjacent(&self, a: usize, b: usize) -> bool {
        let mut members = self.pattern.groups[a].unknowns.iter();
        members.any(|&u| self.graph.neighbours(u).any(|n| self.group_of[n] == b))
    }
}
