//! A matrix with a constant part: the condensed unknowns are eliminated once, the others at every factorisation.

use super::block_lu::BlockLu;
use super::constant::Constant;
use super::factorization::{Breakdown, Factorization};
use super::kernel::RightSide;
use super::symbolic::Symbolic;
use crate::number::larger;

/// The values of K = constant + varying entries, and the factors F of the part that is not condensed.
///
/// All calls must use the `Symbolic` that was passed to `new`.
#[derive(Debug, Clone)]
pub(crate) struct Matrix<F = BlockLu> {
    /// Constant parts, one of which is selected.
    constants: Vec<Constant>,
    current: usize,
    factors: F,
}

impl<F: Factorization> Matrix<F> {
    /// The zero matrix; later calls do not allocate.
    pub(crate) fn new(symbolic: &Symbolic) -> Self {
        Self { constants: vec![Constant::new(symbolic)], current: 0, factors: F::new(symbolic) }
    }

    /// Selects constant part number `which`.
    pub(crate) fn select(&mut self, which: usize) {
        self.current = which.min(self.constants.len() - 1);
    }

    fn constant(&self) -> &Constant {
        &self.constants[self.current]
    }

    /// Sets constant part number `which` from entries by [`place`](Symbolic::place), sums duplicates, condenses, and selects the part.
    ///
    /// A number that was not used before adds a part.
    ///
    /// # Errors
    /// The pivot of a condensed unknown is below 1e-13 of the magnitudes that were added up in it.
    pub(crate) fn set_constant(
        &mut self,
        symbolic: &Symbolic,
        which: usize,
        entries: impl Iterator<Item = (usize, f64)>,
    ) -> Result<(), Breakdown> {
        if which >= self.constants.len() {
            self.constants.push(Constant::new(symbolic));
        }
        self.select(which);
        self.constants[self.current].set(symbolic, entries)
    }

    /// Starts an assembly: the values are reset to the constant part. Varying entries are then added to the returned slice, by slot.
    pub(crate) fn reset(&mut self) -> &mut [f64] {
        let values = self.factors.values_mut();
        values.copy_from_slice(self.constants[self.current].image());
        values
    }

    /// Exchanges the present factors with `other`.
    pub(crate) fn exchange_factors(&mut self, other: &mut F) {
        std::mem::swap(&mut self.factors, other);
    }

    /// Factorises the assembled values.
    ///
    /// # Errors
    /// A pivot is not finite, or is negligible compared with the magnitudes that were added up in it.
    pub(crate) fn factor(&mut self, symbolic: &Symbolic) -> Result<(), Breakdown> {
        self.factor_with(symbolic, RightSide::None)
    }

    fn factor_with(&mut self, symbolic: &Symbolic, with: RightSide<'_>) -> Result<(), Breakdown> {
        self.factors.factor(symbolic, self.constants[self.current].scale(), with)
    }

    /// y −= S x for the unknowns that are not condensed, where S is the constant part after condensation.
    pub(crate) fn subtract_constant_product(&self, x: &[f64], y: &mut [f64]) {
        self.constant().subtract_reduced_product(x, y);
    }

    /// The largest |S_ij x_j| times the weight of row i (rows are numbered without the condensed unknowns).
    pub(crate) fn largest_constant_product(&self, x: &[f64], weight: impl Fn(usize) -> f64) -> f64 {
        self.constant().largest_reduced_product(x, weight)
    }

    /// Eliminates the condensed unknowns from a right-hand side.
    pub(crate) fn reduce(&self, x: &mut [f64]) {
        self.constant().forward(x);
    }

    /// Factorises the assembled values and solves for the unknowns that are not condensed, from a reduced right-hand side.
    ///
    /// # Errors
    /// As `factor`; `x` is then lost.
    pub(crate) fn factor_and_solve_reduced(&mut self, symbolic: &Symbolic, x: &mut [f64]) -> Result<(), Breakdown> {
        self.factor_with(symbolic, RightSide::Of(x))
    }

    /// Solves for the unknowns that are not condensed with the present factors, from a reduced right-hand side.
    pub(crate) fn solve_reduced(&self, symbolic: &Symbolic, x: &mut [f64]) {
        self.factors.solve(symbolic, x);
    }

    /// Computes the condensed unknowns from their reduced right-hand sides and the other unknowns.
    pub(crate) fn expand(&self, x: &mut [f64]) {
        self.constant().backward(x);
    }

    /// Smallest ratio, in (0, 1], of a pivot to the magnitudes added up in it, over the last `factor` and the condensation.
    pub(crate) fn worst_pivot(&self) -> f64 {
        larger(self.factors.worst_loss(), self.constant().worst()).recip()
    }

    /// The unknown whose pivot lost most digits, as far as the factors show.
    pub(crate) fn worst_unknown(&self, symbolic: &Symbolic) -> usize {
        let pivots = self.reciprocal_pivots(symbolic).zip(self.factors.magnitudes());
        let losses = pivots.map(|(reciprocal, magnitude)| magnitude * reciprocal.abs());
        let worst = losses.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(position, _)| position);
        symbolic.unknown(worst)
    }

    /// The reciprocal pivots by position.
    pub(crate) fn reciprocal_pivots<'a>(&'a self, symbolic: &'a Symbolic) -> impl Iterator<Item = f64> + 'a {
        self.constant().reciprocal_pivots().chain(self.factors.reciprocal_pivots(symbolic))
    }

    /// Solves K x = r with the present factors, for r in `x` by position.
    pub(crate) fn solve(&self, symbolic: &Symbolic, x: &mut [f64]) {
        self.reduce(x);
        self.solve_reduced(symbolic, x);
        self.expand(x);
    }

    /// Factorises the assembled values and solves Kᵀ x = r, for r in `x` by position.
    ///
    /// # Errors
    /// As `factor`; `x` is then lost.
    pub(crate) fn factor_and_solve_transposed(&mut self, symbolic: &Symbolic, x: &mut [f64]) -> Result<(), Breakdown> {
        self.constant().forward_transposed(x);
        self.factor_with(symbolic, RightSide::OfTransposed(x))?;
        self.constant().backward_transposed(x);
        Ok(())
    }

    /// Solves Kᵀ x = r with the present factors, for r in `x` by position.
    pub(crate) fn solve_transposed(&self, symbolic: &Symbolic, x: &mut [f64]) {
        self.constant().forward_transposed(x);
        self.factors.solve_transposed(symbolic, x);
        self.constant().backward_transposed(x);
    }
}

impl Matrix {
    /// The number of negative eigenvalues of the factorised matrix, which must be symmetric.
    pub(crate) fn negative_eigenvalues(&self, symbolic: &Symbolic) -> usize {
        let condensed = self.constant().reciprocal_pivots().filter(|pivot| *pivot < 0.0).count();
        condensed + self.factors.negative_eigenvalues(symbolic)
    }
}
