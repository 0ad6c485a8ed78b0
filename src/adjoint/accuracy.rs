//! Selection of the adjoint solutions that are refined iteratively.
//!
//! Factors without interchanges between nodes lose digits if a pivot is small, or if the losses of several multiply. The correction by a refinement
//! shows how many digits are lost: solutions are refined until the correction is small. After that one in many is refined, and those whose smallest
//! pivot is less than half of that before.

/// Corrections below this fraction of a solution are small: other rounding errors of the gradient have this size.
const SMALL: f64 = 1e-12;
/// One in this number of solutions is refined.
const LOOK_EVERY: usize = 128;

#[derive(Default)]
pub(super) struct Accuracy {
    /// Number of following solutions that need no refinement …
    trusted: usize,
    /// … unless their smallest pivot is below half of this.
    pivot: f64,
}

impl Accuracy {
    /// True if a solution with this smallest pivot should be refined.
    #[inline]
    pub(super) fn is_in_doubt(&mut self, pivot: f64) -> bool {
        let is_in_doubt = self.trusted == 0 || pivot < 0.5 * self.pivot;
        self.trusted = self.trusted.saturating_sub(1);
        is_in_doubt
    }

    /// Records a correction relative to its solution; NaN for a zero solution, which shows nothing.
    pub(super) fn note(&mut self, correction: f64, pivot: f64) {
        let is_small = correction <= SMALL;
        *self = if is_small { Accuracy { trusted: LOOK_EVERY - 1, pivot } } else { Accuracy::default() };
    }
}
