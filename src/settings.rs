//! Tolerances and limits.

/// How a simulation is solved; the defaults suit nearly every scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Newton stops when the next correction of (v, σ) would be below this, relative to their size.
    ///
    /// It is estimated from the last correction and from how much that one reduced the residual.
    pub tolerance: f64,
    /// The most Newton iterations in one step.
    pub max_iterations: usize,
    /// The largest |Φ(q₀)| that is accepted, in m or rad.
    pub position_tolerance: f64,
    /// The largest |dΦ/dt(q₀, v₀)| that is accepted, in m/s or rad/s.
    pub velocity_tolerance: f64,
    /// Keep the adjoint variables of all nodes, for [`Solver::adjoint_variables`](crate::Solver::adjoint_variables).
    pub keep_adjoint: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            tolerance: 1e-14,
            max_iterations: 25,
            position_tolerance: 1e-9,
            velocity_tolerance: 1e-9,
            keep_adjoint: false,
        }
    }
}
