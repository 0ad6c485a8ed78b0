//! The analysis of a pattern: the condensed unknowns, the order of the nodes, and the storage of the entries.

use super::condense::{Condensed, condense};
use super::graph::Graph;
use super::kernel::{Kernel, kernel};
use super::node::{Later, Node, Pair, PanelEntry, Shape};
use super::order::{Eliminated, order};
use super::pattern::{Group, Pattern};
use std::ops::Range;

/// A condensed unknown: entries [pivot, row, column], stored contiguously (a run); its position is its index.
#[derive(Debug, Clone)]
pub(super) struct Step {
    /// Start of the run among the stored entries.
    pub(super) start: usize,
    /// Positions of the neighbours when the unknown is eliminated, ascending.
    pub(super) neighbours: Vec<usize>,
    /// The indices at which the entries (i, j) of its neighbours are stored, by rows.
    pub(super) targets: Vec<usize>,
}

impl Step {
    /// The stored run.
    pub(super) fn run(&self) -> Range<usize> {
        self.start..self.start + 1 + 2 * self.neighbours.len()
    }
}

/// The unknowns of a group in the order of their elimination.
struct Members {
    unknowns: Vec<usize>,
    /// Number of the first ones for which the best rows are chosen.
    chosen: usize,
}

impl Members {
    /// The unknowns of a group of which `left` is true. If all multipliers have no entries on the diagonal, which those of constraints that may depend
    /// on others have, the best rows of these alone leave regular blocks of the coordinates.
    fn new(group: &Group, (left, coordinates): (&[bool], usize), has_diagonal: impl Fn(usize) -> bool) -> Self {
        let mut unknowns = Vec::from_iter(group.unknowns.iter().copied().filter(|&unknown| left[unknown]));
        let is_multiplier = |unknown: &usize| *unknown >= coordinates;
        let chosen = match group.chooses_pivots {
            false => 0,
            true if unknowns.iter().any(|unknown| is_multiplier(unknown) && has_diagonal(*unknown)) => unknowns.len(),
            true => {
                unknowns.sort_by_key(|unknown| !is_multiplier(unknown));
                unknowns.iter().filter(|unknown| is_multiplier(unknown)).count()
            }
        };
        Members { unknowns, chosen }
    }
}

/// The structure of the factorisation of all matrices with one pattern.
#[derive(Debug, Clone)]
pub(crate) struct Symbolic {
    positions: Vec<usize>,
    unknowns: Vec<usize>,
    entries: Vec<(usize, usize)>,
    owner: Vec<usize>,
    steps: Vec<Step>,
    nodes: Vec<Node>,
    /// Consecutive nodes with the same kernel.
    runs: Vec<(&'static dyn Kernel, Range<usize>)>,
    panel_entries: Vec<PanelEntry>,
    values_len: usize,
}

impl Symbolic {
    /// Analyses a pattern whose indices are in range and whose groups contain every unknown once.
    pub(crate) fn analyse(pattern: &Pattern) -> Self {
        debug_assert!(pattern.is_consistent(), "inconsistent groups or indices");
        let mut graph = pattern.graph();
        let condensed = condense(pattern, &mut graph);
        let mut left = vec![true; pattern.size];
        for step in &condensed {
            left[step.unknown] = false;
        }
        let diagonal = pattern.diagonal();
        let members = pattern
            .groups
            .iter()
            .map(|group| Members::new(group, (&left, pattern.coordinates), |unknown| diagonal[unknown]));
        let (members, chosen): (Vec<Vec<usize>>, Vec<usize>) =
            members.map(|Members { unknowns, chosen }| (unknowns, chosen)).unzip();
        let sizes: Vec<usize> = members.iter().map(Vec::len).collect();
        let quotient = graph.quotient(sizes.len(), &pattern.group_of());
        let order = order(&quotient, &sizes, &pattern.groups);
        let shapes = shapes(graph, &order, &members);

        let unknowns: Vec<usize> = (condensed.iter().map(|step| step.unknown))
            .chain(order.iter().flat_map(|node| members[node.group].iter().copied()))
            .collect();
        let positions = inverse(&unknowns);
        let mut nodes = lay_out_nodes(&order, &shapes, &sizes, condensed.len());
        order.iter().zip(&mut nodes).for_each(|(step, node)| node.chosen = chosen[step.group]);
        let values_len = nodes.iter().map(Node::panel_len).sum();
        let owner = (nodes.iter().enumerate()).flat_map(|(index, node)| std::iter::repeat_n(index, node.size)).collect();
        let mut symbolic = Self {
            steps: lay_out_steps(&condensed, &positions, values_len),
            positions,
            unknowns,
            entries: pattern.symmetric_entries(),
            owner,
            runs: runs(&nodes),
            panel_entries: nodes.iter().flat_map(|node| node.square().chain(node.sides())).collect(),
            nodes,
            values_len,
        };
        symbolic.find_targets();
        symbolic
    }

    /// Number of unknowns.
    pub(crate) fn size(&self) -> usize {
        self.unknowns.len()
    }

    /// Position of an unknown in right-hand sides and solutions: condensed unknowns first, then node by node.
    pub(crate) fn position(&self, unknown: usize) -> usize {
        self.positions[unknown]
    }

    /// The unknown at a position.
    pub(crate) fn unknown(&self, position: usize) -> usize {
        self.unknowns[position]
    }

    /// Slot of a varying entry in the values; None if its row or column is condensed or the entry is not in
    /// the pattern.
    pub(crate) fn slot(&self, row: usize, col: usize) -> Option<usize> {
        self.place(row, col).filter(|&place| place < self.values_len)
    }

    /// Number of condensed unknowns.
    pub(crate) fn condensed(&self) -> usize {
        self.steps.len()
    }

    /// Sizes and widths of the nodes in elimination order.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = (usize, usize)> {
        self.nodes.iter().map(|node| (node.size, node.width))
    }

    /// Number of values in the panels, Σ s² + 2 s r over the nodes.
    pub(crate) fn values_len(&self) -> usize {
        self.values_len
    }

    /// Number of stored entries: the panels, followed by the rows and columns of the condensed unknowns.
    pub(super) fn stored_len(&self) -> usize {
        self.steps.last().map_or(self.values_len, |step| step.run().end)
    }

    pub(super) fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Consecutive nodes of one kind, with their kernel.
    pub(super) fn runs(&self) -> impl DoubleEndedIterator<Item = (&'static dyn Kernel, &[Node])> {
        self.runs.iter().map(|(kernel, nodes)| (*kernel, &self.nodes[nodes.clone()]))
    }

    /// The index at which an entry of the pattern is stored; None if it is not in the pattern.
    pub(crate) fn place(&self, row: usize, col: usize) -> Option<usize> {
        self.entries.binary_search(&(row, col)).ok()?;
        self.stored(self.positions[row], self.positions[col])
    }

    /// The index at which the entry at two positions is stored, fill included; it belongs to the unknown that is eliminated first.
    fn stored(&self, row: usize, col: usize) -> Option<usize> {
        let (early, late) = (row.min(col), row.max(col));
        match self.steps.get(early) {
            Some(step) if row == col => Some(step.start),
            Some(step) => {
                let k = step.neighbours.binary_search(&late).ok()?;
                let column = if row > col { step.neighbours.len() } else { 0 };
                Some(step.start + 1 + column + k)
            }
            None => self.stored_in_panel(row, col),
        }
    }

    fn stored_in_panel(&self, row: usize, col: usize) -> Option<usize> {
        let (early, late) = (row.min(col), row.max(col));
        let node = self.owner_of(early);
        if late < node.end() {
            return Some(node.start + (col - node.first) * node.size + (row - node.first));
        }
        let b = (node.later.iter()).find(|b| (b.first..b.first + b.lines.len()).contains(&(late - node.end())))?;
        let line = b.lines.start + (late - node.end() - b.first);
        let lower = if row > col { node.width } else { 0 };
        let side = node.start + node.size * (node.size + lower);
        Some(side + line * node.size + (early - node.first))
    }

    /// All pairs of entries (i, j) and (j, i) of the panels, including the diagonal: the positions i, j and the indices of both entries.
    pub(super) fn panel_entries(&self) -> &[PanelEntry] {
        &self.panel_entries
    }

    fn owner_of(&self, position: usize) -> &Node {
        &self.nodes[self.owner[position - self.steps.len()]]
    }

    /// Finds the indices of all entries that eliminations update.
    fn find_targets(&mut self) {
        let targets: Vec<Vec<usize>> = (self.steps.iter())
            .map(|step| {
                let pairs = (step.neighbours.iter()).flat_map(|&i| step.neighbours.iter().map(move |&j| (i, j)));
                pairs.filter_map(|(i, j)| self.stored(i, j)).collect()
            })
            .collect();
        let pairs: Vec<Vec<Pair>> = self.nodes.iter().map(|node| self.pairs(node)).collect();
        for (step, targets) in self.steps.iter_mut().zip(targets) {
            debug_assert_eq!(targets.len(), step.neighbours.len().pow(2));
            step.targets = targets;
        }
        for (node, pairs) in self.nodes.iter_mut().zip(pairs) {
            node.pairs = pairs;
        }
    }

    fn pairs(&self, node: &Node) -> Vec<Pair> {
        let end = node.start + node.panel_len();
        let ordered = (node.later.iter().enumerate()).flat_map(|(k, b)| node.later[k + 1..].iter().map(move |c| (b, c)));
        ordered
            .filter_map(|(b, c)| {
                let (i, j) = (self.nodes[b.node].first, self.nodes[c.node].first);
                Some(Pair {
                    b: b.lines.clone(),
                    c: c.lines.clone(),
                    upper: self.stored(i, j)? - end,
                    lower: self.stored(j, i)? - end,
                })
            })
            .collect()
    }
}

fn inverse(permutation: &[usize]) -> Vec<usize> {
    let mut inverse = vec![0; permutation.len()];
    for (k, &p) in permutation.iter().enumerate() {
        inverse[p] = k;
    }
    inverse
}

/// Assigns runs of entries to the condensed unknowns, from `start` on.
fn lay_out_steps(condensed: &[Condensed], positions: &[usize], mut start: usize) -> Vec<Step> {
    let mut steps = Vec::with_capacity(condensed.len());
    for unknown in condensed {
        let mut neighbours: Vec<usize> = unknown.neighbours.iter().map(|&n| positions[n]).collect();
        neighbours.sort_unstable();
        let step = Step { start, neighbours, targets: Vec::new() };
        start = step.run().end;
        steps.push(step);
    }
    steps
}

/// The way in which each group couples when it is eliminated; `graph` is the graph of the unknowns.
fn shapes(mut graph: Graph, order: &[Eliminated], members: &[Vec<usize>]) -> Vec<Shape> {
    let shape = |node: &Eliminated| {
        let own = &members[node.group];
        let shape = match node.neighbours.as_slice() {
            [] => Shape::Linked,
            [later] if members[*later].len() != own.len() => Shape::Any,
            [later] if own.iter().all(|&u| !graph.adjacent(u, members[*later][0])) => Shape::Outer,
            [later] if members[*later].iter().all(|&u| !graph.adjacent(u, own[0])) => Shape::Inner,
            [_] => Shape::Linked,
            _ => Shape::Any,
        };
        own.iter().for_each(|&u| drop(graph.eliminate(u)));
        shape
    };
    order.iter().map(shape).collect()
}

/// Assigns positions, from `first` on, and panels to the nodes; the pairs are left empty.
fn lay_out_nodes(order: &[Eliminated], shapes: &[Shape], sizes: &[usize], mut first: usize) -> Vec<Node> {
    let mut rank = vec![0; sizes.len()];
    let mut nodes: Vec<Node> = Vec::with_capacity(order.len());
    let mut start = 0;
    for (index, node) in order.iter().enumerate() {
        rank[node.group] = index;
        let size = sizes[node.group];
        nodes.push(Node {
            first,
            size,
            width: node.neighbours.iter().map(|&g| sizes[g]).sum(),
            start,
            later: Vec::new(),
            pairs: Vec::new(),
            shape: shapes[index],
            chosen: 0,
        });
        first += size;
        start += nodes[index].panel_len();
    }
    for (index, node) in order.iter().enumerate() {
        let mut ranks: Vec<usize> = node.neighbours.iter().map(|&g| rank[g]).collect();
        ranks.sort_unstable();
        nodes[index].later = later(&nodes[index], &ranks, &nodes);
    }
    nodes
}

fn runs(nodes: &[Node]) -> Vec<(&'static dyn Kernel, Range<usize>)> {
    let mut first = 0;
    let kind = |node: &Node| (node.size, node.shape != Shape::Any, node.chosen > 0);
    let alike = nodes.chunk_by(|a, b| kind(a) == kind(b));
    alike
        .map(|run| {
            let nodes = first..first + run.len();
            first = nodes.end;
            (kernel(&run[0]), nodes)
        })
        .collect()
}

fn later(node: &Node, ranks: &[usize], nodes: &[Node]) -> Vec<Later> {
    let mut line = 0;
    let neighbours = ranks.iter().map(|&rank| {
        let b = &nodes[rank];
        let lines = line..line + b.size;
        line = lines.end;
        Later { node: rank, lines, first: b.first - node.end(), diagonal: b.start - (node.start + node.panel_len()) }
    });
    neighbours.collect()
}
