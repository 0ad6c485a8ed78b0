//! [`PhiAlong`]: Φ(q, t; b) with its change along a direction, and their derivatives with respect to one argument, by hyper-dual numbers.

use crate::System;
use crate::number::{Hyper, Real};
use crate::system::{NodeValues, NodeView};

/// The parts of the numbers: derivative along the direction, with respect to the argument, and both.
pub(super) const ALONG: usize = 2;
const BY_ARGUMENT: usize = 1;
pub(super) const BOTH: usize = 3;

/// The arguments of Φ, and its values.
pub(super) struct PhiAlong {
    at: NodeValues<Hyper>,
    phi: Vec<Hyper>,
}

impl PhiAlong {
    pub(super) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        PhiAlong { at: NodeValues::zeros((n, m, system.k()), system.parameters().len()), phi: vec![Hyper::from(0.0); m] }
    }

    /// Sets the point, and a direction of its coordinates, time and parameters.
    pub(super) fn set(&mut self, at: &NodeView<f64>, along: &NodeView<f64>) {
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
    pub(super) fn vary(&mut self, parameter: usize, by: f64) {
        let NodeValues { design, t, .. } = &mut self.at;
        design.get_mut(parameter).unwrap_or(t).add_to_part(BY_ARGUMENT, by);
    }

    pub(super) fn evaluate(&mut self, system: &System) -> &[Hyper] {
        system.phi_on(&self.at.view(), &mut self.phi);
        &self.phi
    }
}
