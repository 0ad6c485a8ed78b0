//! One node of the block elimination.
//!
//! Its values form one contiguous panel. For s unknowns coupled to r later unknowns that is
//! D (s×s, by columns), U (s×r, by columns), L (r×s, by rows).

use std::ops::Range;

/// A node, its place among the unknowns and in the values, and the panels that it updates.
#[derive(Debug, Clone)]
pub(super) struct Node {
    /// Position of the first unknown.
    pub(super) first: usize,
    /// Number of unknowns s.
    pub(super) size: usize,
    /// Number of later unknowns r.
    pub(super) width: usize,
    /// Start of the panel in the values.
    pub(super) start: usize,
    /// Later neighbours in elimination order.
    pub(super) later: Vec<Later>,
    /// Pairs of later neighbours.
    pub(super) pairs: Vec<Pair>,
    pub(super) shape: Shape,
    /// Number of the first unknowns for which the best rows are chosen.
    pub(super) chosen: usize,
}

/// The way in which a node couples to later ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// Coupled to any later nodes.
    Any,
    /// Coupled to at most one later node, of equal size.
    Linked,
    /// As `Linked`, but not coupled to the first unknown of that node.
    Outer,
    /// As `Linked`, but the first unknown of this node is not coupled.
    Inner,
}

/// A later neighbour b of a node.
#[derive(Debug, Clone)]
pub(super) struct Later {
    /// The index of the neighbour among the nodes.
    pub(super) node: usize,
    /// The neighbour's columns of U, which are also its rows of L.
    pub(super) lines: Range<usize>,
    /// The neighbour's first unknown, relative to the end of this node's unknowns.
    pub(super) first: usize,
    /// Start of the neighbour's D, relative to the end of this node's panel.
    pub(super) diagonal: usize,
}

/// Two later neighbours b before c of a node.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub(super) b: Range<usize>,
    pub(super) c: Range<usize>,
    /// Start of block (b, c) in U of b, relative to the end of the node's panel.
    pub(super) upper: usize,
    /// Start of block (c, b) in L of b, relative to the end of the node's panel.
    pub(super) lower: usize,
}

/// The entries (i, j) and (j, i) of a panel: their positions, and the indices at which they are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct PanelEntry {
    pub(super) at: [u32; 2],
    pub(super) stored: [u32; 2],
}

impl PanelEntry {
    fn new(at: [usize; 2], stored: [usize; 2]) -> Self {
        PanelEntry { at: at.map(|position| position as u32), stored: stored.map(|place| place as u32) }
    }
}

impl Node {
    /// Number of values in the panel, s² + 2 s r.
    pub(super) fn panel_len(&self) -> usize {
        self.size * (self.size + 2 * self.width)
    }

    /// The position after the last unknown.
    pub(super) fn end(&self) -> usize {
        self.first + self.size
    }

    /// The entries of D.
    pub(super) fn square(&self) -> impl Iterator<Item = PanelEntry> {
        let (first, size, start) = (self.first, self.size, self.start);
        let pairs = (0..size).flat_map(|j| (0..=j).map(move |i| (i, j)));
        pairs.map(move |(i, j)| PanelEntry::new([first + i, first + j], [start + j * size + i, start + i * size + j]))
    }

    /// The entries of U and L.
    pub(super) fn sides(&self) -> impl Iterator<Item = PanelEntry> {
        let (first, size, end, upper) = (self.first, self.size, self.end(), self.start + self.size * self.size);
        let lower = upper + size * self.width;
        let lines = self.later.iter().flat_map(move |b| b.lines.clone().zip(end + b.first..));
        lines.flat_map(move |(line, other)| {
            (0..size).map(move |k| PanelEntry::new([first + k, other], [upper, lower].map(|side| side + line * size + k)))
        })
    }
}
