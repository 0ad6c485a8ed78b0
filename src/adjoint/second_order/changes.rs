//! Changes along a direction that the backward sweep needs: of the assembly of the start, and of restarts.

use crate::system::{NodeView, Pair};

/// (ẇ, ν̇) and (v̇₀, μ̇).
pub(super) struct AssemblyChange {
    pub(super) moved: Pair,
    pub(super) velocity: Pair,
}

/// The directions of the state at the end of a step, of (w, ν), of q after the projection, and of s.
pub(super) struct RestartChange {
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) sigma: Vec<f64>,
    pub(super) p_star_dot: Vec<f64>,
    pub(super) projection: Pair,
    pub(super) q_behind: Vec<f64>,
    pub(super) begin: Vec<f64>,
}

impl RestartChange {
    pub(super) fn new(n: usize, m: usize) -> Self {
        let zeros = |len| vec![0.0; len];
        let [q, v, p_star_dot, q_behind] = [zeros(n), zeros(n), zeros(n), zeros(n)];
        RestartChange { q, v, sigma: zeros(m), p_star_dot, projection: Pair::new(n, m), q_behind, begin: zeros(m) }
    }

    /// Sets the directions at the end of a step, without a projection.
    pub(super) fn at_end(mut self, end: &NodeView<f64>) -> Self {
        let ends = [(&mut self.q, end.q), (&mut self.q_behind, end.q), (&mut self.v, end.v)];
        ends.into_iter().chain([(&mut self.sigma, end.sigma)]).for_each(|(own, of)| own.copy_from_slice(of));
        self.p_star_dot.copy_from_slice(end.p_star_dot);
        self.projection.v.fill(0.0);
        self.projection.sigma.fill(0.0);
        self
    }
}
