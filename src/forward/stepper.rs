//! [`Stepper`]: what solves one stage after the other.

use super::Motion;
use super::continuation::Continuation;
use crate::motion::{Clock, column};
use crate::node::{Newton, Predictor};
use crate::scheme::known_part;
use crate::{Scheme, System};

/// Newton's method with its first guess, and the node problem at hand.
pub(crate) struct Stepper {
    pub(crate) newton: Newton,
    pub(crate) predictor: Predictor,
    pub(crate) continuation: Continuation,
    /// The first node that may be extrapolated from.
    pub(crate) smooth_from: usize,
    /// The node at hand, and the time before it and at it.
    node: usize,
    clocks: [Clock; 2],
    /// The stage at hand.
    pub(crate) stage: usize,
    /// Its known part, q̄ and p̄, and σ₋.
    pub(crate) start_q: Vec<f64>,
    pub(crate) start_p: Vec<f64>,
    pub(crate) start_sigma: Vec<f64>,
}

impl Stepper {
    pub(crate) fn new(system: &System, scheme: Scheme) -> Self {
        let (n, m) = (system.n(), system.m());
        Stepper {
            newton: Newton::new(system),
            predictor: Predictor::new(n, m),
            continuation: Continuation::new(n, m),
            smooth_from: 0,
            node: 0,
            clocks: [Clock::new(0.0); 2],
            stage: scheme.stages(),
            start_q: vec![0.0; n],
            start_p: vec![0.0; n],
            start_sigma: vec![0.0; m],
        }
    }

    /// A node problem with h = 0 from this state.
    pub(crate) fn set_start(&mut self, q: &[f64], p_star: &[f64], sigma: &[f64]) {
        self.start_q.copy_from_slice(q);
        self.start_p.copy_from_slice(p_star);
        self.start_sigma.copy_from_slice(sigma);
    }

    /// The clock at this node, which is the last one that is known.
    pub(crate) fn set_clock(&mut self, node: usize, clock: Clock) {
        (self.node, self.clocks) = (node, [clock; 2]);
    }

    /// The clock at the node at hand.
    pub(crate) fn clock(&self) -> Clock {
        self.clocks[1]
    }

    /// h = Δt a_ss of the stage at hand.
    pub(crate) fn half_step(&self, scheme: &Scheme, dt: f64) -> f64 {
        dt * scheme.a(self.stage, self.stage)
    }

    /// Makes stage s of a step of this length into column k the one at hand: its time, and controls if it lies between nodes, and its known part.
    #[inline]
    pub(crate) fn begin_stage(&mut self, motion: &mut Motion, k: usize, s: usize, dt: f64) {
        let Motion { trajectory, inputs, first, .. } = motion;
        if self.node < *first + k {
            (self.node, self.clocks[0]) = (*first + k, self.clocks[1]);
        }
        self.clocks[1] = self.clocks[0].after(dt);
        trajectory.times[k] = self.clocks[1].time();
        self.stage = s;
        if s < trajectory.last_stage() {
            trajectory.place_stage(k, s, dt, inputs.at_ends(*first + k));
        }
        let scheme = &trajectory.scheme;
        let (q, v) = (column(&trajectory.q, k - 1), column(&trajectory.v, k - 1));
        let (p_star, p_star_dot) = (column(&trajectory.p_star, k - 1), column(&trajectory.p_star_dot, k - 1));
        known_part((scheme, s), dt, (q, v), |j| trajectory.rates(k, j).0, &mut self.start_q);
        known_part((scheme, s), dt, (p_star, p_star_dot), |j| trajectory.rates(k, j).1, &mut self.start_p);
    }
}
