//! [`Stepper`]: solves one stage after another.

use crate::motion::{Clock, Motion, column};
use crate::node::{Newton, Predictor};
use crate::scheme::known_part;
use crate::{Scheme, System};

/// (v, σ) of the last level of a continuation and of the previous one.
pub(crate) struct Continuation {
    pub(super) last: Vec<f64>,
    pub(super) before: Vec<f64>,
    /// The last node counted by the warning.
    pub(crate) counted: usize,
}

impl Continuation {
    fn new(n: usize, m: usize) -> Self {
        Continuation { last: vec![0.0; n + m], before: vec![0.0; n + m], counted: 0 }
    }
}

/// Newton's method with its first guess, and the current node problem.
pub(crate) struct Stepper {
    pub(crate) newton: Newton,
    pub(crate) predictor: Predictor,
    pub(crate) continuation: Continuation,
    /// The first node that may be used for extrapolation.
    pub(crate) smooth_from: usize,
    /// The current node, and the times before it and at it.
    node: usize,
    clocks: [Clock; 2],
    /// The current stage.
    pub(crate) stage: usize,
    /// The known part of the stage, q̄ and p̄, and σ₋.
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

    /// Sets up a node problem with h = 0 from this state.
    pub(crate) fn set_start(&mut self, q: &[f64], p_star: &[f64], sigma: &[f64]) {
        self.start_q.copy_from_slice(q);
        self.start_p.copy_from_slice(p_star);
        self.start_sigma.copy_from_slice(sigma);
    }

    /// Sets the clock at this node, which is the last known one.
    pub(crate) fn set_clock(&mut self, node: usize, clock: Clock) {
        (self.node, self.clocks) = (node, [clock; 2]);
    }

    /// The clock at the current node.
    pub(crate) fn clock(&self) -> Clock {
        self.clocks[1]
    }

    /// h = Δt a_ss of the current stage.
    pub(crate) fn half_step(&self, scheme: &Scheme, dt: f64) -> f64 {
        dt * scheme.a(self.stage, self.stage)
    }

    /// Makes stage s of a step of length `dt` into column k the current one: sets its time, its known part, and its controls if it is between nodes.
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
