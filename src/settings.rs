//! Tolerances and limits.

use crate::{Error, Scheme};

/// How a simulation is solved; the defaults suit nearly every scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How nodes follow from each other.
    pub scheme: Scheme,
    /// Newton stops when the next correction of (v, σ) would be below this, relative to their size.
    ///
    /// It is estimated from the last correction and from how much that one reduced the residual.
    pub tolerance: f64,
    /// The most Newton iterations in one step.
    pub max_iterations: usize,
    /// The largest |Φ(q₀)| that is accepted, in the unit of Φ, which should be m or rad: (x² + y²)/R − R for x² + y² − R². What rounding of large
    /// coordinates leaves is accepted, too. An assembled start ([`Start::assembled`](crate::Start::assembled)) meets the usual one, whatever is set here. Later a |Φ| below it is no
    /// drift (see [`Warning::Drift`](crate::Warning::Drift)).
    pub position_tolerance: f64,
    /// The largest |dΦ/dt(q₀, v₀)| that is accepted, in m/s or rad/s.
    pub velocity_tolerance: f64,
    /// A step without a solution is halved, up to so many times (52 at most, as its length has no more digits); the grid that was taken is in
    /// [`Solver::inputs`](crate::Solver::inputs).
    pub max_halvings: usize,
    /// Position constraints are satisfied again at the ends of macro steps where ‖Φ‖∞ is this or more, in m or rad; 0.0 for all of them, infinite for never,
    /// as in the paper. On grids that are not composed every given step is a macro step; a node where the mechanism is flat to
    /// seven digits, so that branches of Φ = 0 cross, is passed over.
    ///
    /// The multipliers begin anew there too, and the order of a [`Composition`](crate::Composition) is kept (see `docs/long-and-hard-motions.md`). Kinetic
    /// energies must be quadratic in v for it. A projection costs as much as some five steps.
    pub drift_bound: f64,
    /// The multipliers begin anew after so many macro steps, counted from the start (of the whole motion, where a [part](crate::Grid::part) of one is computed),
    /// so that they do not grow without bound under a steady load; 0 for never. On grids that are not composed these are the given steps. A node where the mechanism is flat is passed over, as above.
    ///
    /// |σ| grows like ∫λ dt, and with it the error of a step, O(Δt² σ), until Newton fails; motions of many thousand steps want 1.
    /// With any number the energy of a conservative motion stays bounded (see `docs/long-and-hard-motions.md`).
    pub rebase_every: usize,
    /// Keep the adjoint variables of all nodes, for [`Solver::adjoint_variables`](crate::Solver::adjoint_variables).
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
    /// Refuses what no comparison would ever exceed or meet.
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
