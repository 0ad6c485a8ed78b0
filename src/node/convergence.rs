//! [`Convergence`]: the stopping criterion of Newton's iteration.

use super::sizes::Sizes;

/// A residual below this fraction of its terms may be rounding if sums are long or masses differ greatly.
pub(super) const STALLED: f64 = 1e-10;
/// Relative corrections below this that have stopped shrinking may be rounding for any residual, for example with stiff springs or large angles.
pub(crate) const NOISE: f64 = 1e-8;

/// The state of an iteration, by its last correction and residual.
pub(super) struct Convergence {
    tolerance: f64,
    /// The relative residual below which a residual is rounding.
    rounding: f64,
    /// The residual of the last iterate, and the correction that led to it.
    sizes: Sizes,
    last: f64,
    /// The last residual, relative to its terms.
    pub(super) residual: f64,
    /// The estimated size of the next correction.
    pub(super) next: f64,
    /// True if the factors of this iteration suffice for the next one.
    pub(super) may_reuse: bool,
    /// True if the next correction to be judged is known to be rounding, after corrections have stopped shrinking.
    pub(super) is_noise: bool,
}

impl Convergence {
    /// The state before the first correction, with the residual of the guess.
    pub(super) fn new(tolerance: f64, rounding: f64, sizes: Sizes) -> Self {
        let (last, residual, next) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        Convergence { tolerance, rounding, sizes, last, residual, next, may_reuse: false, is_noise: false }
    }

    /// Continues from the residual of another iterate, because the last correction was shortened.
    pub(super) fn go_on_from(&mut self, sizes: Sizes) {
        (self.sizes, self.last) = (sizes, f64::INFINITY);
    }

    /// True if a relative correction is small and either has stopped shrinking or was not expected after the previous one.
    #[inline]
    pub(super) fn may_be_noise(&self, correction: f64) -> bool {
        correction <= NOISE && self.residual > STALLED && (correction > 0.5 * self.last || self.next <= self.tolerance)
    }

    /// True if a relative correction was the last one: the next would be below the tolerance, or the residual is rounding.
    ///
    /// Residuals are compared with their `terms`; momentum equations may also be violated by the rounding error of the `multipliers` in them.
    #[inline]
    pub(super) fn is_reached(&mut self, correction: f64, residual: Sizes, terms: Sizes, multipliers: f64) -> bool {
        let before = std::mem::replace(&mut self.sizes, residual).relative_to(terms);
        // Another correction gains nothing if corrections stop shrinking while the residual is close to rounding, or are rounding themselves.
        let is_stalled = correction > 0.25 * self.last && before <= STALLED || std::mem::take(&mut self.is_noise);
        self.last = correction;
        self.residual = residual.relative_to(terms);
        // The next correction would be smaller than this one by the ratio of the residuals.
        self.next = if self.residual == 0.0 { 0.0 } else { correction * (self.residual / before) };
        let of_multipliers = residual.v <= 2.0 * f64::EPSILON * multipliers && residual.sigma <= self.rounding * terms.sigma;
        // The ratio is half the relative change of K; with the old factors, twice the ratio would remain of the next correction.
        let left = 2.0 * self.residual / before;
        let would_do = left * self.next <= self.tolerance || left * self.residual <= self.rounding;
        // Soft equations may still be violated when corrections are already small because of stiff equations or an outdated K.
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

    /// The full correction leads to a residual of 1e6, the shortened one does not.
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
