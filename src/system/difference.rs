//! [`Differences`]: formulas that depend on coordinates by their differences alone, as those of springs, cables and distances between points do.
//!
//! Of a function f of z = q_b − q_a the derivatives by q_a are those by q_b with the opposite sign. So those by q_b alone are computed:
//!
//! ```text
//!   f_b = f_z,   f_a = −f_z          f_bb = f_aa = f_zz,   f_ab = f_ba = −f_zz
//! ```

use super::block::{Block, BlockEntry};
use super::formula::Component;
use crate::program::{Graph, Node};

/// Of each coordinate b, the coordinate a if the formula depends on q_b − q_a alone; and whether it is such an a.
#[derive(Clone, Debug)]
pub(super) struct Pairs(Vec<Role>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Alone,
    /// b, with the number of a.
    Relative(usize),
    /// a.
    Reference,
}

impl Pairs {
    /// Of so many coordinates none depends on another.
    pub(super) fn none(n: usize) -> Self {
        Pairs(vec![Role::Alone; n])
    }

    /// Coordinates whose derivatives in every row are opposite, and not all zero.
    pub(super) fn find<'a>(graph: &Graph, n: usize, rows: impl Iterator<Item = &'a [Node]> + Clone) -> Self {
        let mut pairs = Pairs::none(n);
        let is_opposite = |a: usize, b: usize| {
            let is_zero = |row: &[Node]| graph.is_zero(row[a]) && graph.is_zero(row[b]);
            let mut rows = rows.clone().filter(|row| !is_zero(row)).peekable();
            rows.peek().is_some() && rows.all(|row| graph.are_opposite(row[a], row[b]))
        };
        let negatives = |i: usize| rows.clone().filter(|row| graph.is_negative(row[i])).count();
        for b in 0..n {
            let Some(a) = (0..b).find(|&a| pairs.0[a] == Role::Alone && is_opposite(a, b)) else { continue };
            // The one whose derivatives have fewer signs.
            let (b, a) = if negatives(a) < negatives(b) { (a, b) } else { (b, a) };
            (pairs.0[b], pairs.0[a]) = (Role::Relative(a), Role::Reference);
        }
        pairs
    }

    /// What a coordinate is relative to; None if it is a reference itself.
    fn reference(&self, i: usize) -> Option<Option<usize>> {
        match self.0[i] {
            Role::Alone => Some(None),
            Role::Relative(a) => Some(Some(a)),
            Role::Reference => None,
        }
    }
}

/// The differences on which 𝓛_v and the force, and their derivatives by v and q, depend.
#[derive(Clone, Debug)]
pub(super) struct Differences {
    pub(super) momentum: Pairs,
    pub(super) force: Pairs,
    pub(super) v: Pairs,
    pub(super) q: Pairs,
}

impl Differences {
    /// Of what depends on velocities as on coordinates, or not at all.
    pub(super) fn of_coordinates(q: Pairs) -> Self {
        Differences { momentum: q.clone(), force: q.clone(), v: q.clone(), q }
    }

    /// The entries that stand for others as well, like ones together, and the others without those.
    pub(super) fn entries(&self, all: Vec<(BlockEntry, Node)>) -> (Vec<RelativeEntry>, Vec<Node>) {
        let relative = all.into_iter().filter_map(|(entry, node)| Some((self.entry(entry)?, node)));
        let mut entries: Vec<(RelativeEntry, Node)> = relative.collect();
        entries.sort_by_key(|(of, _)| of.kind());
        entries.into_iter().unzip()
    }

    /// The components likewise: those that stand for their negatives, too, come first, and these negatives are what is given second.
    pub(super) fn components(&self, all: &[Component], nodes: &[Node]) -> (Vec<Component>, Vec<Component>, Vec<Node>) {
        let relative = all.iter().zip(nodes).filter_map(|(of, node)| Some((self.component(*of)?, *node)));
        let (first, rest): (Vec<_>, Vec<_>) = relative.partition(|((_, negative), _)| negative.is_some());
        let negatives = first.iter().filter_map(|((_, negative), _)| *negative).collect();
        let (components, nodes) = first.into_iter().chain(rest).map(|((of, _), node)| (of, node)).unzip();
        (components, negatives, nodes)
    }

    /// What an entry stands for; None if another stands for it.
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

    /// A component, and of which other one it is the negative; None if another stands for it.
    fn component(&self, of: Component) -> Option<(Component, Option<Component>)> {
        Some(match of {
            Component::Momentum(i) => (of, self.momentum.reference(i)?.map(Component::Momentum)),
            Component::Force(i) => (of, self.force.reference(i)?.map(Component::Force)),
            Component::Equation(_) => (of, None),
        })
    }
}

/// An entry of a block by coordinates b, and the coordinates a that its row and its column are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RelativeEntry {
    pub entry: BlockEntry,
    pub reference: [Option<usize>; 2],
}

impl RelativeEntry {
    /// How many plain entries it stands for: one, two or four.
    pub fn len(&self) -> usize {
        1 << self.reference.iter().flatten().count()
    }

    /// These: of several, first one half, then the other, which have the opposite sign.
    pub fn parts(&self) -> impl Iterator<Item = BlockEntry> {
        let BlockEntry { row, col, .. } = self.entry;
        let [row_of, col_of] = self.reference;
        let [plain, negative] = [[(Some(row), Some(col)), (row_of, col_of)], [(row_of, Some(col)), (Some(row), col_of)]];
        plain
            .into_iter()
            .chain(negative)
            .filter_map(move |(row, col)| Some(BlockEntry { row: row?, col: col?, ..self.entry }))
    }

    /// The same with their signs.
    pub fn signed_parts(&self) -> impl Iterator<Item = (f64, BlockEntry)> {
        let plain = self.len().div_ceil(2);
        self.parts().enumerate().map(move |(k, part)| (if k < plain { 1.0 } else { -1.0 }, part))
    }

    /// The parts of like entries: of all the first with its sign, then of all the second, and so on.
    pub fn parts_of(like: &[RelativeEntry]) -> impl Iterator<Item = (f64, Vec<BlockEntry>)> {
        let part = |k: usize| move |entry: &RelativeEntry| entry.signed_parts().nth(k);
        (0..like[0].len()).filter_map(move |k| {
            let (signs, parts): (Vec<f64>, Vec<BlockEntry>) = like.iter().filter_map(part(k)).unzip();
            Some((*signs.first()?, parts))
        })
    }

    /// Its block, whether it is mirrored, and whether its row and its column are relative to others.
    fn kind(&self) -> (Block, bool, [bool; 2]) {
        (self.entry.block, self.entry.mirrored, self.reference.map(|reference| reference.is_some()))
    }

    /// Whether another one belongs to the same block, and stands for as many entries likewise.
    pub fn is_like(&self, other: &RelativeEntry) -> bool {
        self.kind() == other.kind()
    }
}

impl From<BlockEntry> for RelativeEntry {
    fn from(entry: BlockEntry) -> Self {
        RelativeEntry { entry, reference: [None; 2] }
    }
}
