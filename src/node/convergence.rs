//! [`Convergence`]: whether Newton's iteration is at its end.

use super::sizes::Sizes;

/// Below this fraction of its terms a residual may be rounding, where the sums are long or the masses far apart.
pub(super) const STALLED: f64 = 1e-10;
/// Relative corrections below this that have stopped shrinking may be rounding, whatever the residual: of stiff springs, of large angles.
pub(crate) const NOISE: f64 = 1e-8;

/// What the corrections and residuals of an iteration have come to.
pub(super) struct Convergence {
    tolerance: f64,
    /// The relative residual below which there is nothing but rounding.
    rounding: f64,
    /// The residual of the last iterate, and the correction that led to it.
    sizes: Sizes,
    last: f64,
    /// The residual, relative to its terms.
    pub(super) residual: f64,
    /// What the next correction would be.
    pub(super) next: f64,
    /// Whether the factors of this iteration will do for the next one.
    pub(super) may_reuse: bool,
    /// Whether the correction that is judged next is rounding, as one that has stopped shrinking may be.
    pub(super) is_noise: bool,
}

impl Convergence {
    /// Before the first correction, with the residual of the guess.
    pub(super) fn new(tolerance: f64, rounding: f64, sizes: Sizes) -> Self {
        let (last, residual, next) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        Convergence { tolerance, rounding, sizes, last, residual, next, may_reuse: false, is_noise: false }
    }

    /// Goes on from the residual of another iterate: the correction that was judged last was not taken as it was.
    pub(super) fn go_on_from(&mut self, sizes: Sizes) {
        (self.sizes, self.last) = (sizes, f64::INFINITY);
    }

    /// Whether a relative correction is small and has stopped shrinking, or comes where none was to come.
    #[inline]
    pub(super) fn may_be_noise(&self, correction: f64) -> bool {
        correction <= NOISE && self.residual > STALLED && (correction > 0.5 * self.last || self.next <= self.tolerance)
    }

    /// Whether a relative correction was the last one: the next would be below the tolerance, or nothing but rounding is left of the residual.
    ///
    /// Residuals are compared with their `terms`; momenta may differ by rounding of the reactions in them, of the size of the `multipliers`.
    #[inline]
    pub(super) fn is_reached(&mut self, correction: f64, residual: Sizes, terms: Sizes, multipliers: f64) -> bool {
        let before = std::mem::replace(&mut self.sizes, residual).relative_to(terms);
        // Once there is nothing but rounding in the residual, or in corrections that stop shrinking, nothing is left to gain.
        let is_stalled = correction > 0.25 * self.last && before <= STALLED || std::mem::take(&mut self.is_noise);
        self.last = correction;
        self.residual = residual.relative_to(terms);
        // The next correction would be smaller than this one as the residual is.
        self.next = if self.residual == 0.0 { 0.0 } else { correction * (self.residual / before) };
        let of_multipliers = residual.v <= 2.0 * f64::EPSILON * multipliers && residual.sigma <= self.rounding * terms.sigma;
        // The ratio is half the relative change of K, and that is what the old factors would leave of the next correction.
        let left = 2.0 * self.residual / before;
        let would_do = left * self.next <= self.tolerance || left * self.residual <= self.rounding;
        // Soft equations may be far from solved where stiff ones, or a K that is not that of the new point, hardly correct any more.
        let is_small = self.next <= self.tolerance;
        self.may_reuse = !self.may_reuse && !is_small && would_do;
        is_small && self.residual <= STALLED || self.residual <= self.rounding || of_multipliers || is_stalled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(v: f64) -> Sizes {
        Sizes { v, sigma: 0.0 }
    }

    #[test]
    fn quadratic_convergence_ends_when_the_next_correction_is_below_the_tolerance() {
        let mut convergence = Convergence::new(1e-14, 1e-16, sizes(1e-2));
        let steps = [(1e-2, 1e-4), (1e-4, 1e-8), (1e-8, 1e-16)];
        let ends = steps.map(|(correction, residual)| {
            convergence.is_reached(correction, sizes(residual), Sizes { v: 1.0, sigma: 1.0 }, 0.0)
        });
        assert_eq!(ends, [false, false, true]);
    }

    /// The whole correction led to a residual of 1e6, of which nothing is left in what was taken.
    #[test]
    fn a_correction_that_was_not_taken_says_nothing_of_the_next() {
        let mut convergence = Convergence::new(1e-14, 1e-16, sizes(2.0));
        let terms = Sizes { v: 1.0, sigma: 1.0 };
        assert!(!convergence.is_reached(1.0, sizes(1e6), terms, 0.0));
        convergence.go_on_from(sizes(1.0));
        assert!(!convergence.is_reached(1e-5, sizes(1e-4), terms, 0.0));
    }

    #[test]
    fn corrections_that_stop_shrinking_close_to_rounding_are_the_end() {
        let mut convergence = Convergence::new(1e-18, 1e-18, sizes(1e-11));
        let terms = Sizes { v: 1.0, sigma: 1.0 };
        assert!(!convergence.is_reached(1e-9, sizes(1e-11), terms, 0.0));
        assert!(convergence.is_reached(8e-10, sizes(1e-11), terms, 0.0));
    }

    #[test]
    fn old_factors_are_used_once_at_most() {
        let mut convergence = Convergence::new(1e-14, 1e-18, sizes(1e-6));
        let terms = Sizes { v: 1.0, sigma: 1.0 };
        assert!(!convergence.is_reached(1e-6, sizes(1e-12), terms, 0.0));
        assert!(convergence.may_reuse);
        assert!(!convergence.is_reached(1e-12, sizes(1e-13), terms, 0.0));
        assert!(!convergence.may_reuse);
    }
}
