//! [`PhiAlong`]: Φ(q, t; b) with what it changes by along a direction, and that by one more argument, by hyper-dual numbers.

use crate::System;
use crate::number::{Hyper, Real};
use crate::system::{Given, NodeView};

/// The parts of the numbers: along the direction, by the argument, and both.
pub(super) const ALONG: usize = 2;
const BY_ARGUMENT: usize = 1;
pub(super) const BOTH: usize = 3;

/// The arguments of Φ, and its values.
pub(super) struct PhiAlong {
    q: Vec<Hyper>,
    u: Vec<Hyper>,
    t: Hyper,
    design: Vec<Hyper>,
    no_v: Vec<Hyper>,
    no_sigma: Vec<Hyper>,
    phi: Vec<Hyper>,
}

impl PhiAlong {
    pub(super) fn new(system: &System) -> Self {
        let zeros = |len| vec![Hyper::from(0.0); len];
        let (n, m) = (system.n(), system.m());
        PhiAlong {
            q: zeros(n),
            u: zeros(system.k()),
            t: Hyper::from(0.0),
            design: zeros(system.parameters().len()),
            no_v: zeros(n),
            no_sigma: zeros(m),
            phi: zeros(m),
        }
    }

    /// At a point, along a direction of its coordinates, time and parameters.
    pub(super) fn set(&mut self, at: &NodeView<f64>, along: &NodeView<f64>) {
        let number = |x: f64, dot: f64| {
            let mut number = Hyper::from(x);
            number.add_to_part(ALONG, dot);
            number
        };
        let lists =
            [(&mut self.q, at.q, along.q), (&mut self.u, at.u, along.u), (&mut self.design, at.design, along.design)];
        for (own, x, dot) in lists {
            own.iter_mut().zip(x.iter().zip(dot)).for_each(|(own, (x, dot))| *own = number(*x, *dot));
        }
        self.t = number(at.t, along.t);
    }

    /// Adds to the part of the numbers that belongs to a parameter, or behind them to time.
    pub(super) fn vary(&mut self, parameter: usize, by: f64) {
        self.design.get_mut(parameter).unwrap_or(&mut self.t).add_to_part(BY_ARGUMENT, by);
    }

    pub(super) fn evaluate(&mut self, system: &System) -> &[Hyper] {
        let given = Given { u: &self.u, t: self.t, design: &self.design };
        system.phi(&given.at(&self.q, &self.no_v, &self.no_sigma), &mut self.phi);
        &self.phi
    }
}
