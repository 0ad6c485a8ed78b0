//! Which solutions of adjoint equations are refined.
//!
//! Factors without interchanges between nodes lose digits where a pivot is small, or where the losses of several multiply. A refined solution
//! tells how many, by its correction: the next ones are refined too until the correction is small. Then one in many is looked at, and those
//! whose smallest pivot is smaller than it was so far.

/// Corrections below this fraction of a solution are left out: the gradient's other rounding is of their size.
const SMALL: f64 = 1e-12;
/// One in so many solutions is looked at.
const LOOK_EVERY: usize = 128;

#[derive(Default)]
pub(super) struct Accuracy {
    /// Solutions to come that need not be looked at …
    trusted: usize,
    /// … if their smallest pivot is not much below this.
    pivot: f64,
}

impl Accuracy {
    /// Whether the solution whose smallest pivot is this one should be refined.
    #[inline]
    pub(super) fn is_in_doubt(&mut self, pivot: f64) -> bool {
        let is_in_doubt = self.trusted == 0 || pivot < 0.5 * self.pivot;
        self.trusted = self.trusted.saturating_sub(1);
        is_in_doubt
    }

    /// Takes note of a correction relative to its solution; NaN if that is zero, from which nothing follows.
    pub(super) fn note(&mut self, correction: f64, pivot: f64) {
        let is_small = correction <= SMALL;
        *self = if is_small { Accuracy { trusted: LOOK_EVERY - 1, pivot } } else { Accuracy::default() };
    }
}
