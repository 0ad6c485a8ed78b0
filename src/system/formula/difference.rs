//! [`Differences`]: detection of formulas that depend on differences of coordinates only, such as those of springs, cables and distances.
//!
//! The derivatives of a function f of z = q_b − q_a with respect to q_a are the negatives of those with respect to q_b. Only the latter are computed:
//!
//! ```text
//!   f_b = f_z,   f_a = −f_z          f_bb = f_aa = f_zz,   f_ab = f_ba = −f_zz
//! ```

use super::block::{Block, BlockEntry};
use super::differentiated::Component;
use crate::program::{Graph, Node};

/// The role of each coordinate: unpaired, b of a difference q_b − q_a, or a of one.
#[derive(Clone, Debug)]
pub(in crate::system) struct Pairs(Vec<Role>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Alone,
    /// Coordinate b; contains the number of coordinate a.
    Relative(usize),
    /// Coordinate a.
    Reference,
}

impl Pairs {
    /// No pairs among `n` coordinates.
    pub(in crate::system) fn none(n: usize) -> Self {
        Pairs(vec![Role::Alone; n])
    }

    /// Finds pairs of coordinates whose derivatives are opposite in every row, and not all zero.
    pub(in crate::system) fn find<'a>(graph: &Graph, n: usize, rows: impl Iterator<Item = &'a [Node]> + Clone) -> Self {
        let mut pairs = Pairs::none(n);
        let is_opposite = |a: usize, b: usize| {
            let is_zero = |row: &[Node]| graph.is_zero(row[a]) && graph.is_zero(row[b]);
            let mut rows = rows.clone().filter(|row| !is_zero(row)).peekable();
            rows.peek().is_some() && rows.all(|row| graph.are_opposite(row[a], row[b]))
        };
        let negatives = |i: usize| rows.clone().filter(|row| graph.negated(row[i]).is_some()).count();
        for b in 0..n {
            let Some(a) = (0..b).find(|&a| pairs.0[a] == Role::Alone && is_opposite(a, b)) else { continue };
            // The coordinate whose derivatives have fewer minus signs becomes b.
            let (b, a) = if negatives(a) < negatives(b) { (a, b) } else { (b, a) };
            (pairs.0[b], pairs.0[a]) = (Role::Relative(a), Role::Reference);
        }
        pairs
    }

    /// The coordinate a that coordinate i is relative to, if any; outer `None` if i is a reference itself.
    fn reference(&self, i: usize) -> Option<Option<usize>> {
        match self.0[i] {
            Role::Alone => Some(None),
            Role::Relative(a) => Some(Some(a)),
            Role::Reference => None,
        }
    }
}

/// Differences on which 𝓛_v and the force depend, and differences of v and of q.
#[derive(Clone, Debug)]
pub(in crate::system) struct Differences {
    pub(in crate::system) momentum: Pairs,
    pub(in crate::system) force: Pairs,
    pub(in crate::system) v: Pairs,
    pub(in crate::system) q: Pairs,
}

impl Differences {
    /// The same pairs for velocities as for coordinates; also used for formulas that do not depend on velocities.
    pub(in crate::system) fn of_coordinates(q: Pairs) -> Self {
        Differences { momentum: q.clone(), force: q.clone(), v: q.clone(), q }
    }

    /// The entries that must be computed, sorted by kind; the other entries follow from these by a change of sign.
    pub(in crate::system) fn entries(&self, all: Vec<(BlockEntry, Node)>) -> (Vec<RelativeEntry>, Vec<Node>) {
        let relative = all.into_iter().filter_map(|(entry, node)| Some((self.entry(entry)?, node)));
        let mut entries: Vec<(RelativeEntry, Node)> = relative.collect();
        entries.sort_by_key(|(of, _)| of.kind());
        entries.into_iter().unzip()
    }

    /// The components that must be computed: first those whose negatives are components as well, which are returned second.
    pub(in crate::system) fn components(
        &self,
        all: &[Component],
        nodes: &[Node],
    ) -> (Vec<Component>, Vec<Component>, Vec<Node>) {
        let relative = all.iter().zip(nodes).filter_map(|(of, node)| Some((self.component(*of)?, *node)));
        let (first, rest): (Vec<_>, Vec<_>) = relative.partition(|((_, negative), _)| negative.is_some());
        let negatives = first.iter().filter_map(|((_, negative), _)| *negative).collect();
        let (components, nodes) = first.into_iter().chain(rest).map(|((of, _), node)| (of, node)).unzip();
        (components, negatives, nodes)
    }

    /// The relative entry for an entry; `None` if another entry represents it.
    fn entry(&self, entry: BlockEntry) -> Option<RelativeEntry> {
        let rows = match entry.block {
            Block::Vv | Block::Vq => Some(&self.momentum),
            Block::Qq | Block::ForceV | Block::ForceQ => Some(&self.force),
            Block::PhiQq | Block::PhiDotQq => Some(&self.q),
            Block::PhiQ | Block::PhiDotQ => None,
        };
        let cols = if matches!(entry.block, Block::Vv | Block::ForceV) { &self.v } else { &self.q };
        let row = rows.map_or(Some(None), |rows| rows.reference(entry.row))?;
        Some(RelativeEntry { entry, reference: [row, cols.reference(entry.col)?] })
    }

    /// A component and the component that is its negative, if any; `None` if another component represents it.
    fn component(&self, of: Component) -> Option<(Component, Option<Component>)> {
        Some(match of {
            Component::Momentum(i) => (of, self.momentum.reference(i)?.map(Component::Momentum)),
            Component::Force(i) => (of, self.force.reference(i)?.map(Component::Force)),
            Component::Equation(_) => (of, None),
        })
    }
}

/// An entry of a block at coordinates b, and the coordinates a that its row and its column are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RelativeEntry {
    pub entry: BlockEntry,
    pub reference: [Option<usize>; 2],
}

impl RelativeEntry {
    /// The number of plain entries that this entry represents: one, two or four.
    pub fn len(&self) -> usize {
        1 << self.reference.iter().flatten().count()
    }

    /// The plain entries: if there are several, the first half has the sign of this entry and the second half the opposite sign.
    pub fn parts(&self) -> impl Iterator<Item = BlockEntry> {
        let BlockEntry { row, col, .. } = self.entry;
        let [row_of, col_of] = self.reference;
        let [plain, negative] = [[(Some(row), Some(col)), (row_of, col_of)], [(row_of, Some(col)), (Some(row), col_of)]];
        plain
            .into_iter()
            .chain(negative)
            .filter_map(move |(row, col)| Some(BlockEntry { row: row?, col: col?, ..self.entry }))
    }

    /// The plain entries with their signs.
    pub fn signed_parts(&self) -> impl Iterator<Item = (f64, BlockEntry)> {
        let plain = self.len().div_ceil(2);
        self.parts().enumerate().map(move |(k, part)| (if k < plain { 1.0 } else { -1.0 }, part))
    }

    /// The plain entries of like entries: the first of each with its sign, then the second of each, and so on.
    pub fn parts_of(like: &[RelativeEntry]) -> impl Iterator<Item = (f64, Vec<BlockEntry>)> {
        let part = |k: usize| move |entry: &RelativeEntry| entry.signed_parts().nth(k);
        (0..like[0].len()).filter_map(move |k| {
            let (signs, parts): (Vec<f64>, Vec<BlockEntry>) = like.iter().filter_map(part(k)).unzip();
            Some((*signs.first()?, parts))
        })
    }

    /// The block, whether the entry is mirrored, and whether its row and its column are relative.
    fn kind(&self) -> (Block, bool, [bool; 2]) {
        (self.entry.block, self.entry.mirrored, self.reference.map(|reference| reference.is_some()))
    }

    /// Whether another entry belongs to the same block and represents plain entries in the same way.
    pub fn is_like(&self, other: &RelativeEntry) -> bool {
        self.kind() == other.kind()
    }
}

impl From<BlockEntry> for RelativeEntry {
    fn from(entry: BlockEntry) -> Self {
        RelativeEntry { entry, reference: [None; 2] }
    }
}
