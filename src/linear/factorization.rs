//! What a direct solver has to do, and all that the rest of the crate knows of it.

use super::symbolic::Symbolic;

/// A pivot that vanishes: the matrix is singular, or nearly so, where `unknown` is eliminated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Breakdown {
    /// The unknown, in the caller's numbering.
    pub(crate) unknown: usize,
    /// The pivot found.
    pub(crate) pivot: f64,
    /// The magnitude it had to be compared with.
    pub(crate) scale: f64,
}

/// What is solved for along with a factorisation, in place.
#[derive(Debug)]
pub(crate) enum RightSide<'a> {
    None,
    /// r of S x = r.
    Of(&'a mut [f64]),
    /// r of Sᵀ x = r.
    OfTransposed(&'a mut [f64]),
}

/// Direct solution with a sequence of matrices S of one pattern.
///
/// The values of S stand in the slots that [`Symbolic::slot`] tells. Vectors go by positions; the condensed unknowns come first
/// in them and are none of the solver's business.
pub(crate) trait Factorization {
    /// For matrices of a pattern; all calls take the same one, and nothing is allocated after this.
    fn new(symbolic: &Symbolic) -> Self;

    /// The values by slots, all to be set before every `factor`, which may overwrite them.
    fn values_mut(&mut self) -> &mut [f64];

    /// Factors S and solves with it; `magnitudes` were added up in the diagonal before, by positions.
    ///
    /// # Errors
    /// A pivot that is not finite or vanishes against the magnitudes that were added up in it; the right-hand side is then lost.
    fn factor(&mut self, symbolic: &Symbolic, magnitudes: &[f64], with: RightSide<'_>) -> Result<(), Breakdown>;

    /// Solves S x = r in place.
    fn solve(&self, symbolic: &Symbolic, x: &mut [f64]);

    /// Solves Sᵀ x = r in place.
    fn solve_transposed(&self, symbolic: &Symbolic, x: &mut [f64]);

    /// The largest ratio, at least 1, of the magnitudes that were added up in a pivot to the pivot.
    fn worst_loss(&self) -> f64;

    /// The magnitudes that were added up in the pivots, by positions.
    fn magnitudes(&self) -> &[f64];

    /// The reciprocal pivots in the order of their positions.
    fn reciprocal_pivots<'a>(&'a self, symbolic: &'a Symbolic) -> impl Iterator<Item = f64> + 'a;
}
