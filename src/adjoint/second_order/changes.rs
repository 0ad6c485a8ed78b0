//! Changes along a direction that the backward sweep needs: of the assembly of the start, and of events.

use crate::system::{NodeView, Pair};

/// (ẇ, ν̇) and (v̇₀, μ̇).
pub(super) struct AssemblyChange {
    pub(super) moved: Pair,
    pub(super) velocity: Pair,
}

/// The direction of the end of a step that precedes an event, and numbers of the event.
#[derive(Default)]
pub(super) struct EventChange {
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) sigma: Vec<f64>,
    pub(super) p_star_dot: Vec<f64>,
    pub(super) numbers: Vec<f64>,
}

impl EventChange {
    /// Sets the direction of the end of the step.
    pub(super) fn set_end(&mut self, end: &NodeView<f64>) {
        let EventChange { q, v, sigma, p_star_dot, .. } = self;
        for (own, of) in [(q, end.q), (v, end.v), (sigma, end.sigma), (p_star_dot, end.p_star_dot)] {
            own.clear();
            own.extend_from_slice(of);
        }
    }
}
