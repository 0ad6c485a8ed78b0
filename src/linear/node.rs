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
}

/// How a node couples to later ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// To any.
    Any,
    /// To no later node but one of its own size.
    Linked,
    /// So, and not to the first unknown of that node.
    Outer,
    /// So, and with all its unknowns but the first.
    Inner,
}

/// A later neighbour b of a node.
#[derive(Debug, Clone)]
pub(super) struct Later {
    /// Its index among the nodes.
    pub(super) node: usize,
    /// Its columns of U, which are its rows of L too.
    pub(super) lines: Range<usize>,
    /// Its first unknown, counted from the end of the node's own.
    pub(super) first: usize,
    /// Start of its D, counted from the end of the node's panel.
    pub(super) diagonal: usize,
}

/// Two later neighbours b before c of a node.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub(super) b: Range<usize>,
    pub(super) c: Range<usize>,
    /// Start of block (b, c) in U of b, counted from the end of the node's panel.
    pub(super) upper: usize,
    /// Start of block (c, b) in L of b, counted from the end of the node's panel.
    pub(super) lower: usize,
}

/// The entries (i, j) and (j, i) of a panel: positions, and where the two are stored.
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

    /// Position behind the last unknown.
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
