//! [`Linearisation`]: the equations of a step at a point, their tangent matrix K, and its factors.

use super::evaluation::Evaluation;
use super::sizes::UnitWeights;
use super::transposed::TransposedProduct;
use crate::System;
use crate::linear::{BlockLu, Factorization, Matrix};
use crate::motion::Report;
use crate::system::{Entries, Given, KnownPart, NodeView, Pair, Variable};

/// The equations of a step at a point; all vectors are in the solver's order, the condensed unknowns first.
pub(crate) struct Linearisation<F = BlockLu> {
    pub(crate) evaluation: Evaluation,
    pub(super) matrix: Matrix<F>,
    pub(super) condensed: usize,
    /// (v, σ) of the point.
    pub(super) x: Vec<f64>,
    /// Workspace for residuals and right-hand sides.
    pub(super) delta: Vec<f64>,
    pub(super) transposed: TransposedProduct,
    pub(crate) weights: UnitWeights,
}

impl<F: Factorization> Linearisation<F> {
    pub(crate) fn new(system: &System) -> Self {
        let zeros = || vec![0.0; system.n() + system.m()];
        let condensed = system.symbolic().condensed();
        Linearisation {
            evaluation: Evaluation::new(system),
            matrix: Matrix::new(system.symbolic()),
            condensed,
            x: zeros(),
            delta: zeros(),
            transposed: TransposedProduct::new(system),
            weights: UnitWeights::new((system.n(), system.m()), condensed),
        }
    }

    /// Writes 𝓛_v at a point, in the scene's order; the evaluation's blocks then belong to this point.
    pub(crate) fn l_v(&mut self, system: &System, at: &NodeView<f64>, l_v: &mut [f64], report: &mut Report) {
        self.load(system, at.v, at.sigma);
        let from = KnownPart { h: 0.0, q: at.q, p_star: &[], sigma: &[] };
        self.delta.fill(0.0);
        let given = Given::from(*at);
        self.evaluation.subtract_nonlinear(system, &from, given, &self.x, &mut self.delta, report);
        self.evaluation.second(system, report);
        self.evaluation.constants.l_v(at, l_v);
        l_v.iter_mut().zip(&system.positions().v).for_each(|(l_v, &position)| *l_v -= self.delta[position]);
    }

    /// Writes 𝓛_v and dΦ/dt at a point, in the scene's order; the evaluation's blocks then belong to this point.
    pub(crate) fn l_v_and_phi_dot(&mut self, system: &System, at: &NodeView<f64>, left: &mut Pair, report: &mut Report) {
        self.l_v(system, at, &mut left.v, report);
        left.sigma.fill(0.0);
        let (constants, add) = (&self.evaluation.constants, |_, j: usize, x: f64| left.sigma[j] += x);
        constants.push_forward(&[], at, |_, of| of == Variable::E, add);
        let positions = &system.positions().sigma;
        left.sigma.iter_mut().zip(positions).for_each(|(phi_dot, &position)| *phi_dot -= self.delta[position]);
    }

    pub(super) fn load(&mut self, system: &System, v: &[f64], sigma: &[f64]) {
        self.evaluation.begin();
        let positions = system.positions();
        positions.v.iter().zip(v).for_each(|(&position, &v)| self.x[position] = v);
        positions.sigma.iter().zip(sigma).for_each(|(&position, &sigma)| self.x[position] = sigma);
    }

    /// (v, σ) of the last iterate.
    pub(crate) fn iterate(&self, system: &System) -> Pair {
        let mut x = Pair::new(system.n(), system.m());
        x.load(system.positions(), &self.x);
        x
    }
}
