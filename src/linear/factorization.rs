//! The interface of a direct solver: all that the rest of the crate uses.

use super::kernel::RightSide;
use super::symbolic::Symbolic;

/// A vanishing pivot: the matrix is singular, or nearly so, where `unknown` is eliminated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Breakdown {
    /// The unknown, in the caller's numbering.
    pub(crate) unknown: usize,
    /// The pivot.
    pub(crate) pivot: f64,
    /// The magnitude with which the pivot was compared.
    pub(crate) scale: f64,
}

/// Direct solution of systems with a sequence of matrices S of one pattern.
///
/// The values of S are stored in the slots that [`Symbolic::slot`] returns. Vectors are ordered by position; the condensed unknowns come first,
/// and the solver does not use them.
pub(crate) trait Factorization {
    /// Allocates for matrices of a pattern; all later calls must use the same pattern and do not allocate.
    fn new(symbolic: &Symbolic) -> Self;

    /// The values by slot. All must be set before every call of `factor`, which may overwrite them.
    fn values_mut(&mut self) -> &mut [f64];

    /// Factorises S and solves with it; `magnitudes`, by position, have already been added up in the diagonal.
    ///
    /// # Errors
    /// A pivot is not finite, or is negligible compared with the magnitudes that were added up in it; the right-hand side is then lost.
    fn factor(&mut self, symbolic: &Symbolic, magnitudes: &[f64], with: RightSide<'_>) -> Result<(), Breakdown>;

    /// Solves S x = r in place.
    fn solve(&self, symbolic: &Symbolic, x: &mut [f64]);

    /// Solves Sᵀ x = r in place.
    fn solve_transposed(&self, symbolic: &Symbolic, x: &mut [f64]);

    /// The largest ratio, at least 1, of the magnitudes that were added up in a pivot to the pivot.
    fn worst_loss(&self) -> f64;

    /// The magnitudes that were added up in the pivots, by position.
    fn magnitudes(&self) -> &[f64];

    /// The reciprocal pivots, by position.
    fn reciprocal_pivots<'a>(&'a self, symbolic: &'a Symbolic) -> impl Iterator<Item = f64> + 'a;
}
