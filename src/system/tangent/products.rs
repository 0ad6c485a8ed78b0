//! Products of second derivatives with vectors, for the rows of the adjoint equations and for changes along a direction.

use std::ops::Range;

use crate::number::{StridedDifference, by_fours};
use crate::system::formula::{Block, BlockEntry, Covector, Element, NodeView, RelativeEntry, StateRows, Sums};

/// A part of the adjoint rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    V,
    Q,
    Sigma,
}

/// An adjoint variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    C,
    D,
    E,
}

/// Selects terms of the adjoint rows by the row and the adjoint variable.
pub trait Wanted: Fn(Row, Variable) -> bool + Copy {}

impl<F: Fn(Row, Variable) -> bool + Copy> Wanted for F {}

/// All terms.
pub fn all(_: Row, _: Variable) -> bool {
    true
}

/// The terms of d alone.
pub fn of_force(_: Row, variable: Variable) -> bool {
    variable == Variable::D
}

/// The row ∂q alone.
pub fn row_q(row: Row, _: Variable) -> bool {
    row == Row::Q
}

impl Row {
    pub const ALL: [Row; 3] = [Row::V, Row::Q, Row::Sigma];

    fn of<'a>(self, along: &NodeView<'a, f64>) -> &'a [f64] {
        [along.v, along.q, along.sigma][self as usize]
    }

    pub fn of_mut(self, rows: &mut StateRows) -> &mut [f64] {
        match self {
            Row::V => &mut rows.v,
            Row::Q => &mut rows.q,
            Row::Sigma => &mut rows.sigma,
        }
    }
}

impl Variable {
    pub const ALL: [Variable; 3] = [Variable::C, Variable::D, Variable::E];

    fn of<'a>(self, with: &Covector<'a>) -> &'a [f64] {
        [with.c, with.d, with.e][self as usize]
    }
}

/// Whether B or Bᵀ is multiplied, for a block B.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Factor {
    Plain,
    Transposed,
}

impl Block {
    /// The contributions of a block to the adjoint equations ∂v, ∂q and ∂σ:
    ///
    /// ```text
    ///   v: 𝓛_vvᵀ c + (𝓛_qv + Q_v)ᵀ d + Φ_qᵀ e,   q: 𝓛_vqᵀ c + (𝓛_qq + Q_q)ᵀ d + (dΦ/dt)_qᵀ e,   σ: Φ_q c + (dΦ/dt)_q d
    /// ```
    #[inline(always)]
    fn terms(self, wanted: impl Wanted, mut term: impl FnMut(Row, Factor, Variable)) {
        use Factor::{Plain, Transposed};
        use Row::{Q, Sigma, V};
        use Variable::{C, D, E};
        let mut add = |to, factor, of| {
            if wanted(to, of) {
                term(to, factor, of);
            }
        };
        match self {
            Block::Vv => add(V, Transposed, C),
            Block::Vq => {
                add(V, Plain, D);
                add(Q, Transposed, C);
            }
            Block::Qq | Block::PhiDotQq | Block::ForceQ => add(Q, Transposed, D),
            Block::ForceV => add(V, Transposed, D),
            Block::PhiQq => {
                add(V, Transposed, D);
                add(Q, Transposed, C);
            }
            Block::PhiQ => {
                add(V, Transposed, E);
                add(Sigma, Plain, C);
            }
            Block::PhiDotQ => {
                add(Q, Transposed, E);
                add(Sigma, Plain, D);
            }
        }
    }
}

/// Second derivatives that are visited one by one; their products are inlined, so that only the wanted parts are computed.
pub trait Entries {
    /// Calls `visit` with the block of each entry at a node, its row and column in the scene's numbering, and its value.
    fn each(&self, blocks: &[f64], visit: impl FnMut(Block, [usize; 2], f64));

    /// Calls `add` with each contribution to the adjoint rows.
    #[inline(always)]
    fn pull_back(&self, blocks: &[f64], with: &Covector, wanted: impl Wanted, mut add: impl FnMut(Row, usize, f64)) {
        self.each(blocks, |block, [row, col], x| {
            block.terms(wanted, |to, factor, of| match factor {
                Factor::Plain => add(to, row, x * of.of(with)[col]),
                Factor::Transposed => add(to, col, x * of.of(with)[row]),
            });
        });
    }

    /// Calls `add` with each contribution to the changes of 𝓛_v (paired with c), 𝓛_q + Q (d) and dΦ/dt (e) along a direction of the state.
    #[inline(always)]
    fn push_forward(
        &self,
        blocks: &[f64],
        along: &NodeView<f64>,
        wanted: impl Wanted,
        mut add: impl FnMut(Variable, usize, f64),
    ) {
        self.each(blocks, |block, [row, col], x| {
            block.terms(wanted, |of, factor, to| match factor {
                Factor::Plain => add(to, col, x * of.of(along)[row]),
                Factor::Transposed => add(to, row, x * of.of(along)[col]),
            });
        });
    }
}

/// Values of one kind of block, and their places in the scene's numbering.
#[derive(Clone, Debug)]
pub struct Products {
    /// The block of the values, and whether they are mirrored.
    like: BlockEntry,
    values: Range<usize>,
    at: At,
}

#[derive(Clone, Debug)]
enum At {
    /// Row and column, for one entry of elements at equal distances.
    Strided([StridedDifference; 2]),
    /// Row and column of each value, and whether it is subtracted.
    Places(Vec<[u32; 2]>, bool),
}

impl Products {
    /// The products of all entries, ordered by entry and within an entry by element; the values start at `begin`.
    pub fn all(entries: &[RelativeEntry], elements: &[&Element], begin: usize) -> Vec<Products> {
        let (mut all, mut end, like) = (Vec::new(), begin, entries[0].entry);
        let strided: Vec<_> = entries.iter().map(|entry| strided(entry, elements)).collect();
        let mut rest = entries;
        for run in strided.chunk_by(|a, b| a.is_none() && b.is_none()) {
            let own;
            (own, rest) = rest.split_at(run.len());
            let values = end..end + own.len() * elements.len();
            end = values.end;
            if let Some(strided) = run[0] {
                all.push(Products { like, values, at: At::Strided(strided) });
                continue;
            }
            for (sign, parts) in RelativeEntry::parts_of(own) {
                let places = parts.iter().flat_map(|part| places(part, elements)).collect();
                all.push(Products { like, values: values.clone(), at: At::Places(places, sign < 0.0) });
            }
        }
        all
    }

    /// Adds the contributions to the adjoint rows.
    pub fn pull_back(&self, blocks: &[f64], with: &Covector, wanted: impl Wanted, rows: &mut StateRows) {
        self.like.block.terms(wanted, |to, factor, of| {
            self.add(&blocks[self.values.clone()], factor == Factor::Transposed, of.of(with), to.of_mut(rows));
        });
    }

    /// Adds the contributions to the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction of the state: the transpose of
    /// [`pull_back`](Self::pull_back).
    pub fn push_forward(&self, blocks: &[f64], (along, wanted): (&NodeView<f64>, impl Wanted), sums: &mut Sums<f64>) {
        let mut parts = sums.parts_mut();
        self.like.block.terms(wanted, |of, factor, to| {
            self.add(&blocks[self.values.clone()], factor == Factor::Plain, of.of(along), parts[to as usize]);
        });
    }

    /// Adds B `of` or Bᵀ `of` to `to`.
    #[inline]
    fn add(&self, x: &[f64], transposed: bool, of: &[f64], to: &mut [f64]) {
        let [transposed, plain] = [transposed || self.like.mirrored, !transposed || self.like.mirrored];
        match &self.at {
            At::Strided([row, col]) => {
                if transposed {
                    col.add_products(x, (*row, of), to);
                }
                if plain {
                    row.add_products(x, (*col, of), to);
                }
            }
            At::Places(places, false) => add_at::<false>(x, places, (transposed, plain), of, to),
            At::Places(places, true) => add_at::<true>(x, places, (transposed, plain), of, to),
        }
    }
}

/// Adds products at listed places, or subtracts them if `NEGATIVE`.
#[inline(always)]
fn add_at<const NEGATIVE: bool>(
    x: &[f64],
    places: &[[u32; 2]],
    (transposed, plain): (bool, bool),
    of: &[f64],
    to: &mut [f64],
) {
    let signed = |x: &f64| if NEGATIVE { -x } else { *x };
    if transposed {
        by_fours(x, places, |x, [row, col]| to[*col as usize] += signed(x) * of[*row as usize]);
    }
    if plain {
        by_fours(x, places, |x, [row, col]| to[*row as usize] += signed(x) * of[*col as usize]);
    }
}

/// Row and column of an entry, for each element.
fn places(entry: &BlockEntry, elements: &[&Element]) -> Vec<[u32; 2]> {
    elements.iter().map(|element| element.row_and_col(entry).map(|place| place as u32)).collect()
}

/// The first place and a common stride of rows and columns, and of the rows and columns subtracted from them; `None` if there is no common stride.
fn strided(relative: &RelativeEntry, elements: &[&Element]) -> Option<[StridedDifference; 2]> {
    let entry = relative.entry;
    let of = |which: usize, entry: &BlockEntry| places(entry, elements).iter().map(|place| place[which]).collect::<Vec<_>>();
    let [row, col] = relative.reference;
    let row_reference = row.map(|row| of(0, &BlockEntry { row, ..entry }));
    let col_reference = col.map(|col| of(1, &BlockEntry { col, ..entry }));
    let row = StridedDifference::new(&of(0, &entry), row_reference.as_deref())?;
    let col = StridedDifference::new(&of(1, &entry), col_reference.as_deref())?;
    (row.stride == col.stride).then_some([row, col])
}
