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

use super::jet::ElementKind;
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
        let [here, there] = self.like.in_tangent(h);
        // Not 0 · x: at h = 0 derivatives of forces have no part in K, finite or not.
        if here == 0.0 && there == 0.0 {
            return;
        }
        if here == there {
            by_fours(x, slots, |x, slots| slots.iter().for_each(|&slot| values[slot as usize] += here * x));
            return;
        }
        by_fours(x, slots, |x, slots| values[slots[0] as usize] += here * x);
        if there != 0.0 {
            by_fours(x, slots, |x, slots| values[slots[1] as usize] += there * x);
        }
    }
}
