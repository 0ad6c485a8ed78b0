//! Products of second derivatives with vectors: the rows of the adjoint equations, and changes along a direction.

use std::ops::Range;

use super::batch::{Covector, StateRows, Sums};
use super::block::{Block, BlockEntry};
use super::difference::RelativeEntry;
use super::element::Element;
use super::view::NodeView;
use crate::number::{StridedDifference, by_fours};

/// A part of the adjoint rows, and of the adjoint variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    V,
    Q,
    Sigma,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    C,
    D,
    E,
}

/// Which parts of the adjoint rows are wanted, and which variables are not zero.
#[derive(Clone, Copy)]
pub struct Wanted(pub fn(Row, Variable) -> bool);

impl Wanted {
    pub const ALL: Wanted = Wanted(|_, _| true);
    /// What d alone contributes.
    pub const OF_FORCE: Wanted = Wanted(|_, variable| matches!(variable, Variable::D));
    /// The row ∂q.
    pub const ROW_Q: Wanted = Wanted(|row, _| matches!(row, Row::Q));
}

/// Adds Bᵀ x, or B x, of a block B to a part of the adjoint rows.
struct Term {
    to: Row,
    of: Variable,
    transposed: bool,
}

impl Block {
    /// What a block contributes to the adjoint equations ∂v, ∂q and ∂σ:
    ///
    /// ```text
    ///   v: 𝓛_vvᵀ c + (𝓛_qv + Q_v)ᵀ d + Φ_qᵀ e,   q: 𝓛_vqᵀ c + (𝓛_qq + Q_q)ᵀ d + (dΦ/dt)_qᵀ e,   σ: Φ_q c + (dΦ/dt)_q d
    /// ```
    const fn terms(self) -> &'static [Term] {
        use Row::{Q, Sigma, V};
        use Variable::{C, D, E};
        const fn transposed(to: Row, of: Variable) -> Term {
            Term { to, of, transposed: true }
        }
        const fn plain(to: Row, of: Variable) -> Term {
            Term { to, of, transposed: false }
        }
        match self {
            Block::Vv => const { &[transposed(V, C)] },
            Block::Vq => const { &[plain(V, D), transposed(Q, C)] },
            Block::Qq | Block::PhiDotQq | Block::ForceQ => const { &[transposed(Q, D)] },
            Block::ForceV => const { &[transposed(V, D)] },
            Block::PhiQq => const { &[transposed(V, D), transposed(Q, C)] },
            Block::PhiQ => const { &[transposed(V, E), plain(Sigma, C)] },
            Block::PhiDotQ => const { &[transposed(Q, E), plain(Sigma, D)] },
        }
    }
}

/// Values of one block, and where they stand in the scene's numbering.
#[derive(Clone, Debug)]
pub struct Products {
    /// Their block, and whether they are mirrored.
    like: BlockEntry,
    values: Range<usize>,
    at: At,
}

#[derive(Clone, Debug)]
enum At {
    /// Row and column, of one entry of like elements.
    Strided([StridedDifference; 2]),
    /// Row and column of each value, and whether it is subtracted there.
    Places(Vec<[u32; 2]>, bool),
}

impl Products {
    /// Those of like entries, entry by entry and of each element by element, whose values begin at `begin`.
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

    /// Adds to the adjoint rows what they contribute.
    pub fn pull_back(&self, blocks: &[f64], with: &Covector, wanted: Wanted, rows: &mut StateRows) {
        for term in self.like.block.terms().iter().filter(|term| wanted.0(term.to, term.of)) {
            let to = match term.to {
                Row::V => &mut rows.v,
                Row::Q => &mut rows.q,
                Row::Sigma => &mut rows.sigma,
            };
            let of = match term.of {
                Variable::C => with.c,
                Variable::D => with.d,
                Variable::E => with.e,
            };
            self.add(&blocks[self.values.clone()], term.transposed, of, to);
        }
    }

    /// Adds to the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction of the state what they contribute: the transpose of
    /// [`pull_back`](Self::pull_back).
    pub fn push_forward(&self, blocks: &[f64], (along, wanted): (&NodeView<f64>, Wanted), sums: &mut Sums<f64>) {
        let [l_v, force, phi_dot] = sums.parts_mut();
        for term in self.like.block.terms().iter().filter(|term| wanted.0(term.to, term.of)) {
            let of = match term.to {
                Row::V => along.v,
                Row::Q => along.q,
                Row::Sigma => along.sigma,
            };
            let to: &mut [f64] = match term.of {
                Variable::C => l_v,
                Variable::D => force,
                Variable::E => phi_dot,
            };
            self.add(&blocks[self.values.clone()], !term.transposed, of, to);
        }
    }

    /// Adds B of, or Bᵀ of.
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

/// Adds products at listed places, or subtracts them.
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

/// Row and column of an entry of each element.
fn places(entry: &BlockEntry, elements: &[&Element]) -> Vec<[u32; 2]> {
    elements.iter().map(|element| element.row_and_col(entry).map(|place| place as u32)).collect()
}

/// Rows and columns, and what they are relative to, at equal distances of their own, the same for all.
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
