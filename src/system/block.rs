//! Second derivatives of an element: where they belong in the tangent matrix K of a step, and in adjoint products.
//!
//! With D± = (∂_v ± h ∂_q, ∂_σ), the tangent matrix of a step is K(h) = D₋ D₊ᵀ 𝓛 − h D₊ᵀ Q:
//!
//! ```text
//!   K_vv = 𝓛_vv + h 𝓛_vq − h (𝓛_qv + Q_v) − h² (𝓛_qq + Q_q)
//!   K_vσ = Φ_qᵀ − h (dΦ/dt)_qᵀ          K_σv = Φ_q + h (dΦ/dt)_q          K_σσ = 0
//! ```
//!
//! What comes from 𝓛 obeys K(−h) = K(h)ᵀ.

use std::ops::Range;

use super::batch::{Covector, StateRows, Sums};
use super::jet::ElementKind;
use super::view::NodeView;
use crate::number::by_fours;

/// One kind of second derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Block {
    /// 𝓛_vv.
    Vv,
    /// 𝓛_vq = 𝓛_qvᵀ.
    Vq,
    /// 𝓛_qq of an energy.
    Qq,
    /// Q_v.
    ForceV,
    /// Q_q.
    ForceQ,
    /// σᵀΦ_qq = 𝓛_vq = 𝓛_qv of a constraint.
    PhiQq,
    /// σᵀ(dΦ/dt)_qq.
    PhiDotQq,
    /// Φ_q; its rows are equations.
    PhiQ,
    /// (dΦ/dt)_q.
    PhiDotQ,
}

/// One entry of a block, by the element's own numbers of row and column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockEntry {
    pub block: Block,
    pub row: usize,
    pub col: usize,
    /// Whether it stands for (col, row) as well.
    pub mirrored: bool,
}

impl Block {
    /// Whether its rows are equations.
    pub fn has_equations(self) -> bool {
        matches!(self, Block::PhiQ | Block::PhiDotQ)
    }
}

impl BlockEntry {
    pub fn new(block: Block, row: usize, col: usize) -> Self {
        BlockEntry { block, row, col, mirrored: false }
    }

    /// An entry on or below the diagonal of a symmetric block.
    pub fn symmetric(block: Block, row: usize, col: usize) -> Self {
        BlockEntry { block, row, col, mirrored: row != col }
    }

    /// All entries of the blocks of a kind with n coordinates and m equations, in the order of [`Jet::blocks`](super::jet::Jet::blocks).
    pub fn all(kind: ElementKind, n: usize, m: usize) -> Vec<BlockEntry> {
        let square = |block| (0..n * n).map(move |k| BlockEntry::new(block, k / n, k % n));
        let rows = |block| (0..m * n).map(move |k| BlockEntry::new(block, k / n, k % n));
        match kind {
            ElementKind::Kinetic => square(Block::Vv).chain(square(Block::Vq)).chain(square(Block::Qq)).collect(),
            ElementKind::Potential => square(Block::Qq).collect(),
            ElementKind::Applied => square(Block::ForceV).chain(square(Block::ForceQ)).collect(),
            ElementKind::Holonomic => {
                let squares = square(Block::PhiQq).chain(square(Block::PhiDotQq));
                squares.chain(rows(Block::PhiQ)).chain(rows(Block::PhiDotQ)).collect()
            }
        }
    }

    /// Its factors in K(h): at (row, col), and at (col, row).
    pub fn in_tangent(&self, h: f64) -> [f64; 2] {
        let mirrored = |factor: f64| [factor, if self.mirrored { factor } else { 0.0 }];
        match self.block {
            Block::Vv => mirrored(1.0),
            Block::Vq => [h, -h],
            Block::Qq | Block::PhiDotQq => mirrored(-h * h),
            Block::ForceV => [-h, 0.0],
            Block::ForceQ => [-h * h, 0.0],
            Block::PhiQq => [0.0; 2],
            Block::PhiQ => [1.0; 2],
            Block::PhiDotQ => [h, -h],
        }
    }
}

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

/// Entries of one block that follow each other, mirrored ones or others.
#[derive(Clone, Debug)]
pub struct BlockRun {
    /// Their block, and whether they are mirrored.
    pub like: BlockEntry,
    pub entries: Range<usize>,
}

impl BlockRun {
    /// The runs of a list.
    pub fn all(entries: &[BlockEntry]) -> Vec<BlockRun> {
        let mut begin = 0;
        let runs = entries.chunk_by(|a, b| (a.block, a.mirrored) == (b.block, b.mirrored));
        runs.map(|run| {
            begin += run.len();
            BlockRun { like: run[0], entries: begin - run.len()..begin }
        })
        .collect()
    }

    /// Adds its values to K at two lists of slots, (row, column) and (column, row).
    #[inline]
    pub fn scatter(&self, x: &[f64], slots: &[[u32; 2]], h: f64, values: &mut [f64]) {
        if self.like.block == Block::PhiQq {
            return;
        }
        let [here, there] = self.like.in_tangent(h);
        by_fours(x, slots, |x, slots| values[slots[0] as usize] += here * x);
        if there != 0.0 {
            by_fours(x, slots, |x, slots| values[slots[1] as usize] += there * x);
        }
    }

    /// Adds to the adjoint rows what values at some places, in the scene's numbering, contribute.
    #[inline]
    pub fn pull_back(&self, x: &[f64], places: &[[u32; 2]], with: &Covector, wanted: Wanted, rows: &mut StateRows) {
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
            self.add_product((x, places), term.transposed, of, to);
        }
    }

    /// Adds B of, or Bᵀ of.
    #[inline(always)]
    fn add_product(&self, (x, places): (&[f64], &[[u32; 2]]), transposed: bool, of: &[f64], to: &mut [f64]) {
        if transposed || self.like.mirrored {
            by_fours(x, places, |x, [row, col]| to[*col as usize] += x * of[*row as usize]);
        }
        if !transposed || self.like.mirrored {
            by_fours(x, places, |x, [row, col]| to[*row as usize] += x * of[*col as usize]);
        }
    }

    /// Adds to the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction of the state what values at some places contribute: the transpose of
    /// [`pull_back`](Self::pull_back).
    #[inline]
    pub fn push_forward(
        &self,
        x: &[f64],
        places: &[[u32; 2]],
        (along, wanted): (&NodeView<f64>, Wanted),
        sums: &mut Sums<f64>,
    ) {
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
            self.add_product((x, places), !term.transposed, of, to);
        }
    }
}
