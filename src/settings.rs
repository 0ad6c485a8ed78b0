//! Tolerances and limits.

use crate::{Error, Scheme};

/// Settings of a simulation; the defaults suit nearly every scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The integration scheme.
    pub scheme: Scheme,
    /// Tolerance of Newton's method: it stops when the next correction of (v, σ), relative to the size of (v, σ), would be smaller than
    /// this value.
    ///
    /// The next correction is estimated from the last one and from the reduction of the residual.
    pub tolerance: f64,
    /// Largest number of Newton iterations in one step.
    pub max_iterations: usize,
    /// Largest |Φ(q₀)| accepted at the start, in the unit of Φ, which should be m or rad (write (x² + y²)/R − R, not x² + y² − R²). A
    /// violation that is only the rounding error of large coordinates is also accepted. An assembled start
    /// ([`Start::assembled`](crate::Start::assembled)) satisfies the default tolerance, independently of this setting. During the motion
    /// |Φ| below this value does not count as drift ([`Warning::Drift`](crate::Warning::Drift)).
    pub position_tolerance: f64,
    /// Largest |dΦ/dt(q₀, v₀)| accepted at the start, m/s or rad/s.
    pub velocity_tolerance: f64,
    /// Largest number of times that a step without a solution is halved (at most 52, the number of binary digits of its length);
    /// [`Solver::inputs`](crate::Solver::inputs) contains the grid that was used.
    pub max_halvings: usize,
    /// Bound of ‖Φ‖∞, m or rad. If ‖Φ‖∞ reaches it at the end of a macro step ([`Grid::stages`](crate::Grid::stages)), positions are
    /// projected onto Φ = 0 there. With 0.0 they are projected after every macro step, with infinity never, as in the paper. On a grid
    /// without a composition ([`Grid::composed`](crate::Grid::composed)) every step of the given grid is a macro step. A node is skipped if
    /// its configuration agrees to about seven digits with one in which branches of Φ = 0 cross, such as a flat parallelogram.
    ///
    /// A projection also resets the multipliers and keeps the order of a [`Composition`](crate::Composition) (see
    /// `docs/long-and-hard-motions.md`). The kinetic energy must be quadratic in v. A projection costs about as much as five steps.
    pub drift_bound: f64,
    /// Number of macro steps after which the multipliers are reset, so that they do not grow without bound under a steady load; 0 for
    /// never. Macro steps are counted from the start of the whole motion, also in a [part](crate::Grid::part) of it. On a grid without a
    /// composition every step of the given grid is a macro step. A node is skipped if its configuration agrees to about seven digits with
    /// one in which branches of Φ = 0 cross.
    ///
    /// The absolute value of σ grows like ∫λ dt, where λ are the reactions. The error of a step, O(Δt² σ), grows with it, until Newton's
    /// method fails. Use 1 for motions of many thousand steps. With any number above 0 the energy of a conservative motion stays bounded
    /// (see `docs/long-and-hard-motions.md`).
    pub rebase_every: usize,
    /// True to store the adjoint variables of all nodes for [`Solver::adjoint_variables`](crate::Solver::adjoint_variables).
    pub keep_adjoint: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            scheme: Scheme::TRAPEZOIDAL,
            tolerance: 1e-14,
            max_iterations: 25,
            position_tolerance: 1e-9,
            velocity_tolerance: 1e-9,
            max_halvings: 10,
            drift_bound: f64::INFINITY,
            rebase_every: 0,
            keep_adjoint: false,
        }
    }
}

impl Settings {
    /// Returns an error for tolerances and limits that are not usable.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.scheme.check()?;
        let bounds = [
            ("tolerance", self.tolerance),
            ("position_tolerance", self.position_tolerance),
            ("velocity_tolerance", self.velocity_tolerance),
            ("drift_bound", self.drift_bound),
        ];
        let refused =
            |name: &str, value, must_be| Err(Error::Parameter { what: format!("`Settings::{name}`"), value, must_be });
        match bounds.into_iter().find(|(_, bound)| bound.is_nan() || *bound < 0.0) {
            Some((name, value)) => refused(name, value, "a number that is not negative"),
            None if self.tolerance.is_infinite() => refused("tolerance", self.tolerance, "finite"),
            None if self.max_iterations == 0 => refused("max_iterations", 0.0, "1 or more"),
            None => Ok(()),
        }
    }
}
