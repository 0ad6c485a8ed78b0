//! What a step begins with and what it leads to.

use crate::linear::Breakdown;

/// The unknowns of a step and what follows from them; v and σ hold the first guess.
pub(crate) struct Unknowns<'a> {
    pub(crate) q: &'a mut [f64],
    pub(crate) v: &'a mut [f64],
    pub(crate) sigma: &'a mut [f64],
    /// 𝓛_q + Q.
    pub(crate) p_star_dot: &'a mut [f64],
}

/// Why a step has no solution.
pub(crate) enum StepFailure {
    Singular(Breakdown),
    Diverged {
        iterations: usize,
        residual: f64,
        unknown: usize,
        /// Of a solution that was refused: by how much its velocities differ from the guess, in sizes of both.
        jump: Option<f64>,
    },
    /// The projection onto Φ = 0.
    Projection {
        iterations: usize,
        correction: f64,
    },
    /// A kinetic energy with a term linear in v, which no projection knows: the coordinate and T_v(q, 0).
    LinearEnergy {
        coordinate: usize,
        momentum: f64,
    },
    NotFinite,
}

impl StepFailure {
    /// Whether more iterations might have done it.
    pub(crate) fn is_unfinished(&self) -> bool {
        matches!(self, StepFailure::Diverged { residual, .. } if residual.is_finite())
    }
}
