//! Second derivatives of an element: their places in the tangent matrix K of a step and in adjoint products.
//!
//! With D± = (∂_v ± h ∂_q, ∂_σ), the tangent matrix of a step is K(h) = D₋ D₊ᵀ 𝓛 − h D₊ᵀ Q:
//!
//! ```text
//!   K_vv = 𝓛_vv + h 𝓛_vq − h (𝓛_qv + Q_v) − h² (𝓛_qq + Q_q)
//!   K_vσ = Φ_qᵀ − h (dΦ/dt)_qᵀ          K_σv = Φ_q + h (dΦ/dt)_q          K_σσ = 0
//! ```
//!
//! The part of K due to 𝓛 satisfies K(−h) = K(h)ᵀ.

use super::kind::ElementKind;

/// A block of second derivatives.
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

/// One entry of a block; row and column are numbered within the element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockEntry {
    pub block: Block,
    pub row: usize,
    pub col: usize,
    /// Whether the entry also represents (col, row).
    pub mirrored: bool,
}

impl Block {
    /// The factor of the block's entries in K(h).
    pub fn in_tangent(self, h: f64) -> f64 {
        match self {
            Block::Vv | Block::PhiQ => 1.0,
            Block::Vq | Block::PhiDotQ => h,
            Block::ForceV => -h,
            Block::Qq | Block::PhiDotQq | Block::ForceQ => -h * h,
            Block::PhiQq => 0.0,
        }
    }

    /// Whether the block contributes to K. σᵀΦ_qq does not: h 𝓛_vq and −h 𝓛_qv cancel.
    pub fn is_in_tangent(self) -> bool {
        self != Block::PhiQq
    }

    /// Whether the rows of the block are equations.
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

    /// All entries of the blocks of an element with n coordinates and m equations, in the order of [`Jet::blocks`](super::kind::Jet::blocks).
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

    /// The sign with which the entry also appears at (col, row) of K.
    pub fn sign_of_mirrored(&self) -> Option<f64> {
        match self.block {
            Block::Vv | Block::Qq | Block::PhiDotQq => self.mirrored.then_some(1.0),
            Block::Vq | Block::PhiDotQ => Some(-1.0),
            Block::PhiQ => Some(1.0),
            Block::ForceV | Block::ForceQ | Block::PhiQq => None,
        }
    }
}
