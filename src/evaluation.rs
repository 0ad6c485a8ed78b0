//! The mechanics at one point in real numbers: what is constant, what is sinusoidal, and what dual numbers differentiate.
//!
//! 𝓛_v, 𝓛_q + Q and dΦ/dt are linear functions plus a nonlinear part N; the tangent matrix K(h) is a constant plus N′(h). Only
//! N and N′ are evaluated at every iteration.

use crate::System;
use crate::linear::{BlockLu, Breakdown};
use crate::system::{At, Constants, Covector, Pair, Rows, Sines, Sums};
use crate::trajectory::Report;

/// All elements of a system for one set of design variables, and their values at the point evaluated last.
pub(crate) struct Evaluation {
    pub(crate) constants: Constants,
    sines: Sines,
    /// The nonlinear part N.
    pub(crate) sums: Sums<f64>,
    /// What N′ is made of: (sin q, cos q) of the sinusoidal constraints, second derivatives of the other elements.
    pub(crate) blocks: Vec<f64>,
    triplets: Vec<(usize, usize, f64)>,
    /// The half step whose constants the matrix holds.
    assembled_for: Option<f64>,
}

impl Evaluation {
    pub(crate) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        Evaluation {
            constants: Constants::new(n, m, system.k()),
            sines: system.sines().clone(),
            sums: Sums::new(n, m),
            blocks: vec![0.0; system.block_len()],
            triplets: Vec::new(),
            assembled_for: None,
        }
    }

    /// Takes over the values of the design variables.
    pub(crate) fn set_design(&mut self, system: &System, design: &[f64]) {
        system.constants(design, &mut self.constants);
        self.sines.set_coefficients(&mut self.constants.waves);
        self.assembled_for = None;
    }

    /// N and what N′ is made of.
    pub(crate) fn nonlinear(&mut self, system: &System, at: &At<f64>, report: &mut Report) {
        self.sums.clear();
        let (angles, mut rest) = self.blocks.split_at_mut(self.sines.block_len());
        self.sines.evaluate(at.q, at.v, at.sigma, &mut self.sums, angles);
        report.sine_evaluations += self.sines.angles();
        for (batch, len) in system.differentiated() {
            let (own, after) = rest.split_at_mut(len);
            batch.evaluate(at, &mut self.sums, own);
            report.element_evaluations += batch.varying();
            rest = after;
        }
    }

    /// Gives the matrix the constant part of K(h).
    pub(crate) fn set_step(&mut self, system: &System, h: f64, matrix: &mut BlockLu) -> Result<(), Breakdown> {
        if self.assembled_for != Some(h) {
            self.constants.tangent(h, &mut self.triplets);
            matrix.set_constant(system.symbolic(), &self.triplets)?;
            self.assembled_for = Some(h);
        }
        Ok(())
    }

    /// Assembles K(h) from its constants and from derivatives that were evaluated at (v, σ).
    pub(crate) fn assemble(
        &self,
        system: &System,
        h: f64,
        blocks: &[f64],
        (v, sigma): (&[f64], &[f64]),
        matrix: &mut BlockLu,
    ) {
        matrix.reset();
        let (angles, mut rest) = blocks.split_at(self.sines.block_len());
        self.sines.scatter(angles, v, sigma, h, matrix.values_mut());
        for (batch, len) in system.differentiated() {
            let (own, after) = rest.split_at(len);
            batch.scatter(own, h, matrix.values_mut());
            rest = after;
        }
    }

    /// y := N′(h) x at the point evaluated last.
    pub(crate) fn multiply(&self, system: &System, h: f64, (v, sigma): (&[f64], &[f64]), x: &Pair, y: &mut Pair) {
        y.clear();
        let (angles, mut rest) = self.blocks.split_at(self.sines.block_len());
        self.sines.multiply(angles, v, sigma, h, x, y);
        for (batch, len) in system.differentiated() {
            let (own, after) = rest.split_at(len);
            batch.multiply(own, h, x, y);
            rest = after;
        }
    }

    /// The adjoint rows of all elements (see [`tangent`](crate::system)) for any c, d, e.
    pub(crate) fn pull_back(&self, system: &System, at: (&[f64], &[f64]), blocks: &[f64], with: &Covector, rows: &mut Rows) {
        rows.clear();
        self.constants.pull_back(with, rows);
        self.pull_back_nonlinear(system, at, blocks, with, rows);
    }

    /// Adds the adjoint rows of the nonlinear part.
    pub(crate) fn pull_back_nonlinear(
        &self,
        system: &System,
        (v, sigma): (&[f64], &[f64]),
        blocks: &[f64],
        with: &Covector,
        rows: &mut Rows,
    ) {
        let (angles, mut rest) = blocks.split_at(self.sines.block_len());
        self.sines.pull_back(angles, v, sigma, with, rows);
        for (batch, len) in system.differentiated() {
            let (own, after) = rest.split_at(len);
            batch.pull_back(own, with, rows);
            rest = after;
        }
    }
}
