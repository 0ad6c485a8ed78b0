//! Kᵀ x from the derivatives of which K is assembled, for the residual of the adjoint equations Kᵀ x = r.
//!
//! The factors of a nearly singular K give x with an error of ε/p² (p the smallest pivot ratio), since the rounding of one equation's large terms
//! reaches all others. One step of iterative refinement, x += K⁻ᵀ (r − Kᵀ x), reduces the error of every equation to the rounding of its own terms
//! (Skeel, *Math. Comp.* 35 (1980), 817–832), as Newton's corrections do for the motion itself.

use super::evaluation::Evaluation;
use crate::System;
use crate::system::{Covector, Pair, StateRows};

/// Workspace for Kᵀ x.
pub(crate) struct TransposedProduct {
    /// x = (c, e), and d = −h c.
    x: Pair,
    d: Vec<f64>,
    rows: StateRows,
}

impl TransposedProduct {
    pub(crate) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        TransposedProduct { x: Pair::new(n, m), d: vec![0.0; n], rows: StateRows::new(n, m) }
    }

    /// r −= K(h)ᵀ x, both in the solver's order.
    pub(crate) fn subtract_product(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        h: f64,
        blocks: &[f64],
        x: &[f64],
        right: &mut [f64],
    ) {
        let positions = system.positions();
        self.x.load(positions, x);
        self.d.iter_mut().zip(&self.x.v).for_each(|(d, c)| *d = -h * c);
        let with = Covector { c: &self.x.v, d: &self.d, e: &self.x.sigma };
        evaluation.pull_back(system, blocks, &with, &mut self.rows);
        evaluation.pull_back_compliance(&self.x.sigma, &mut self.rows.sigma);
        for (&position, (v, q)) in positions.v.iter().zip(self.rows.v.iter().zip(&self.rows.q)) {
            right[position] -= v + h * q;
        }
        positions.sigma.iter().zip(&self.rows.sigma).for_each(|(&position, row)| right[position] -= row);
    }
}
