//! Linear equations K x = r and Kᵀ x = r at given points, solved with the factors of the tangent matrix.

use super::linearisation::Linearisation;
use crate::System;
use crate::linear::{Breakdown, Factorization};
use crate::motion::Report;
use crate::number::add;
use crate::system::{Given, KnownPart, Pair};

impl<F: Factorization> Linearisation<F> {
    /// Assembles K(h) from given derivatives and factors it; returns the smallest pivot ratio.
    pub(crate) fn factor(&mut self, system: &System, h: f64, blocks: &[f64], report: &mut Report) -> Result<f64, Breakdown> {
        self.assemble(system, h, Some(blocks), report)?;
        self.matrix.factor(system.symbolic())?;
        Ok(self.watch_pivots(report))
    }

    /// Factors K(h) with the derivatives at the last evaluated point, including second ones; returns the smallest pivot ratio.
    pub(crate) fn factor_here(&mut self, system: &System, h: f64, report: &mut Report) -> Result<f64, Breakdown> {
        self.assemble(system, h, None, report)?;
        self.matrix.factor(system.symbolic())?;
        Ok(self.watch_pivots(report))
    }

    /// Factors K(h) as `factor` does and solves Kᵀ x = r in place, in the solver's order; returns the smallest pivot ratio.
    pub(crate) fn factor_and_solve_transposed(
        &mut self,
        system: &System,
        h: f64,
        blocks: &[f64],
        x: &mut [f64],
        report: &mut Report,
    ) -> Result<f64, Breakdown> {
        self.assemble(system, h, Some(blocks), report)?;
        self.matrix.factor_and_solve_transposed(system.symbolic(), x)?;
        Ok(self.watch_pivots(report))
    }

    /// Selects the constant part of K(h).
    pub(crate) fn select_step(&mut self, system: &System, h: f64) -> Result<(), Breakdown> {
        self.evaluation.set_step(system, h, &mut self.matrix)
    }

    /// Exchanges the current factors for `other`.
    pub(crate) fn exchange_factors(&mut self, other: &mut F) {
        self.matrix.exchange_factors(other);
    }

    /// The smallest pivot ratio of the current factors.
    pub(crate) fn worst_pivot(&self) -> f64 {
        self.matrix.worst_pivot()
    }

    /// Solves Kᵀ x = r in place with the last factors; returns their smallest pivot ratio.
    pub(crate) fn solve_transposed(&mut self, system: &System, x: &mut [f64], report: &mut Report) -> f64 {
        self.matrix.solve_transposed(system.symbolic(), x);
        self.watch_pivots(report)
    }

    /// Refines the solution x of Kᵀ x = r with the last factors; replaces r by x + K⁻ᵀ (r − Kᵀ x).
    ///
    /// Returns the size of the correction relative to that of x; NaN for x = 0.
    pub(crate) fn refine_transposed(
        &mut self,
        system: &System,
        h: f64,
        blocks: &[f64],
        x: &[f64],
        right: &mut [f64],
    ) -> f64 {
        self.transposed.subtract_product(system, &self.evaluation, h, blocks, x, right);
        self.matrix.solve_transposed(system.symbolic(), right);
        let (correction, size) = (self.weights.of_all(right), self.weights.of_all(x));
        add(right, x);
        if size.largest() > 0.0 { correction.relative_to(size) } else { f64::NAN }
    }

    #[inline]
    fn assemble(&mut self, system: &System, h: f64, blocks: Option<&[f64]>, report: &mut Report) -> Result<(), Breakdown> {
        self.evaluation.set_step(system, h, &mut self.matrix)?;
        let blocks = blocks.unwrap_or(&self.evaluation.blocks);
        self.evaluation.assemble(system, h, blocks, &mut self.matrix);
        report.factorisations += 1;
        Ok(())
    }

    #[inline]
    pub(super) fn watch_pivots(&self, report: &mut Report) -> f64 {
        let worst = self.matrix.worst_pivot();
        report.worst_pivot = report.worst_pivot.min(worst);
        worst
    }

    /// Computes the weights of unknowns and equations from the last pivots.
    pub(crate) fn weigh(&mut self, system: &System) {
        self.weights.set(system.positions(), self.matrix.reciprocal_pivots(system.symbolic()));
    }

    /// Factors K(h) at given v and σ.
    pub(crate) fn factor_at(
        &mut self,
        system: &System,
        from: &KnownPart,
        given: Given,
        (v, sigma): (&[f64], &[f64]),
        report: &mut Report,
    ) -> Result<(), Breakdown> {
        self.load(system, v, sigma);
        self.evaluation.subtract_nonlinear(system, from, given, &self.x, &mut self.delta, report);
        self.evaluation.second(system, report);
        self.factor_here(system, from.h, report).map(|_| ())
    }

    /// The unknown whose pivot lost the most digits in the last factorisation.
    pub(crate) fn worst_unknown(&self, system: &System) -> usize {
        self.matrix.worst_unknown(system.symbolic())
    }

    /// The weighted size of velocities, coordinates or changes of coordinates; the units of the latter differ.
    pub(crate) fn size_of(&self, v: &[f64]) -> f64 {
        self.weights.of_velocities(v.iter().copied())
    }

    /// Solves K x = r in place.
    pub(crate) fn solve(&mut self, system: &System, x: &mut Pair) {
        x.store(system.positions(), &mut self.delta);
        self.matrix.solve(system.symbolic(), &mut self.delta);
        x.load(system.positions(), &self.delta);
    }
}

impl Linearisation {
    /// True if the factored K(0) has more negative eigenvalues than constraints: then vᵀM v < 0 for some velocities that the constraints allow.
    pub(crate) fn has_negative_mass(&self, system: &System) -> bool {
        self.matrix.negative_eigenvalues(system.symbolic()) > system.m()
    }
}
