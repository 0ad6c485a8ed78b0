//! [`State`]: a node of a motion, passed to a callback during the computation.

use crate::forward::ForwardSweep;

/// The state at one node of a motion.
#[derive(Clone, Copy, Debug)]
pub struct State<'a> {
    /// Number of the node on the grid that is used.
    pub node: usize,
    /// Time t, s.
    pub time: f64,
    /// Coordinates q, m or rad.
    pub q: &'a [f64],
    /// Velocities v, m/s or rad/s.
    pub v: &'a [f64],
    /// Augmented momenta p*, N s or N m s.
    pub p_star: &'a [f64],
    /// Rates ṗ* of the augmented momenta, N or N m.
    pub p_star_dot: &'a [f64],
    /// Multipliers σ (impulses), N s or N m s.
    pub sigma: &'a [f64],
}

impl ForwardSweep {
    /// The state at a node within the window.
    pub(super) fn state(&self, node: usize) -> State<'_> {
        let k = node - self.motion.first;
        let y = self.motion.trajectory.columns(k);
        let time = self.motion.trajectory.times[k];
        State { node, time, q: y.q, v: y.v, p_star: y.p_star, p_star_dot: y.p_star_dot, sigma: y.sigma }
    }
}
