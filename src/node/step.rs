//! The unknowns of a step, and the reasons for which it can fail.

use crate::linear::Breakdown;

/// The unknowns of a step and the quantities that follow from them; v and σ hold the first guess.
pub(crate) struct Unknowns<'a> {
    pub(crate) q: &'a mut [f64],
    pub(crate) v: &'a mut [f64],
    pub(crate) sigma: &'a mut [f64],
    /// 𝓛_q + Q.
    pub(crate) p_star_dot: &'a mut [f64],
}

/// The reason why a step has no solution.
pub(crate) enum StepFailure {
    Singular(Breakdown),
    Diverged {
        iterations: usize,
        residual: f64,
        unknown: usize,
        /// For a rejected solution: the difference of its velocities from the guess, relative to the sizes of both.
        jump: Option<f64>,
    },
    /// The projection onto Φ = 0 does not converge.
    Projection {
        iterations: usize,
        correction: f64,
    },
    /// The kinetic energy has a term linear in v, which projections do not support: the coordinate and T_v(q, 0).
    LinearEnergy {
        coordinate: usize,
        momentum: f64,
    },
    NotFinite,
}

impl StepFailure {
    /// True if more iterations might have succeeded.
    pub(crate) fn is_unfinished(&self) -> bool {
        matches!(self, StepFailure::Diverged { residual, .. } if residual.is_finite())
    }
}
