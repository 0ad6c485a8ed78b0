//! [`PhiAlong`]: Φ(q, t; b) with its change along a direction, and their derivatives with respect to one argument, by hyper-dual numbers.

use crate::System;
use crate::number::{Hyper, Real};
use crate::system::{NodeValues, NodeView};

/// The parts of the numbers: derivative along the direction, with respect to the argument, and both.
pub(crate) const ALONG: usize = 2;
const BY_ARGUMENT: usize = 1;
const BOTH: usize = 3;

/// The arguments of Φ, and its values.
pub(crate) struct PhiAlong {
    at: NodeValues<Hyper>,
    phi: Vec<Hyper>,
}

impl PhiAlong {
    pub(crate) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        PhiAlong { at: NodeValues::zeros((n, m, system.k()), system.parameters().len()), phi: vec![Hyper::from(0.0); m] }
    }

    /// Sets the point, and a direction of its coordinates, time and parameters.
    pub(crate) fn set(&mut self, at: &NodeView<f64>, along: &NodeView<f64>) {
        let number = |x: f64, dot: f64| {
            let mut number = Hyper::from(x);
            number.add_to_part(ALONG, dot);
            number
        };
        let NodeValues { q, u, t, design, .. } = &mut self.at;
        for (own, x, dot) in [(q, at.q, along.q), (u, at.u, along.u), (design, at.design, along.design)] {
            own.iter_mut().zip(x.iter().zip(dot)).for_each(|(own, (x, dot))| *own = number(*x, *dot));
        }
        *t = number(at.t, along.t);
    }

    /// Adds to the argument's part of a parameter, or of time for the index after the last parameter.
    fn vary(&mut self, parameter: usize, by: f64) {
        let NodeValues { design, t, .. } = &mut self.at;
        design.get_mut(parameter).unwrap_or(t).add_to_part(BY_ARGUMENT, by);
    }

    /// Adds the change of (Φ_b, Φ_t)ᵀ e, times a sign, along the direction.
    pub(crate) fn add_change(&mut self, system: &System, (e, sign): (&[f64], f64), (design, time): (&mut [f64], &mut f64)) {
        for p in 0..=design.len() {
            self.vary(p, 1.0);
            let changes = self.evaluate(system).iter().map(|phi| phi.part(BOTH));
            let own = sign * changes.zip(e).map(|(change, e)| change * e).sum::<f64>();
            self.vary(p, -1.0);
            *design.get_mut(p).unwrap_or(time) += own;
        }
    }

    pub(crate) fn evaluate(&mut self, system: &System) -> &[Hyper] {
        system.phi_on(&self.at.view(), &mut self.phi);
        &self.phi
    }
}
