//! The data of a node problem: everything in the equations of a node that is known before its unknowns are computed.
//!
//! Find (v, σ) with 𝓛_v − h (𝓛_q + Q) = p̄ and dΦ/dt = 0 at q = q̄ + h v.

use crate::system::formula::NodeView;

/// The known part (q̄, p̄, h) of a node problem, and σ₋ for compliances.
#[derive(Clone, Copy)]
pub(crate) struct KnownPart<'a> {
    pub(crate) h: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p_star: &'a [f64],
    pub(crate) sigma: &'a [f64],
}

/// Quantities that stay constant while a node problem is solved.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a, R = f64> {
    pub(crate) u: &'a [R],
    pub(crate) t: R,
    pub(crate) design: &'a [R],
}

impl<'a, R> Given<'a, R> {
    /// The arguments of the equations at a state (q, v, σ).
    #[inline]
    pub(crate) fn at(self, q: &'a [R], v: &'a [R], sigma: &'a [R]) -> NodeView<'a, R> {
        NodeView::of_equations([q, v, sigma], (self.u, self.t, self.design))
    }
}

impl<'a> From<NodeView<'a, f64>> for Given<'a> {
    fn from(NodeView { u, t, design, .. }: NodeView<'a, f64>) -> Self {
        Given { u, t, design }
    }
}
