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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    C,
    D,
    E,
}

/// Selects the parts of the adjoint rows to compute, and the adjoint variables that are not zero.
#[derive(Clone, Copy)]
pub struct Wanted(pub fn(Row, Variable) -> bool);

impl Wanted {
    pub const ALL: Wanted = Wanted(|_, _| true);
    /// The contributions of d alone.
    pub const OF_FORCE: Wanted = Wanted(|_, variable| matches!(variable, Variable::D));
    /// The row ∂q alone.
    pub const ROW_Q: Wanted = Wanted(|row, _| matches!(row, Row::Q));
}

/// Adds Bᵀ x or B x, for a block B, to a part of the adjoint rows.
struct Term {
    to: Row,
    of: Variable,
    transposed: bool,
}

impl Block {
    /// The contributions of a block to the adjoint equations ∂v, ∂q and ∂σ:
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

    /// Adds the contributions to the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction of the state: the transpose of
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
