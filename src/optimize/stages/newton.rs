//! Newton's method for the barrier problem in stages. Slacks t of the inequality rows J, with the curvature Σ of their barrier, are eliminated:
//!
//! ```text
//!   H + Σ_v + JᵀΣJ,   g + Jᵀ(∂φ/∂t + Σ (c − t));      dt = J dv + c − t,   dw = Σ dt + ∂φ/∂t − w
//! ```

use nalgebra::{DMatrix, DVector};

use super::method::Method;
use super::problem::{Multipliers, Residuals};
use super::riccati::{Blocks, Direction, Factors, ROWS, Sides};
use crate::Error;

/// Estimated multipliers above this size, relative to the largest derivative of the cost if it is above 1, are replaced by zero.
const LARGE: f64 = 1e3;
/// Shifts of the Hessian: the first one, the smallest and the largest one, and factors between trials.
const FIRST_SHIFT: f64 = 1e-4;
const LEAST_SHIFT: f64 = 1e-20;
const MOST_SHIFT: f64 = 1e20;
const FASTER: f64 = 100.0;
const FAST: f64 = 8.0;
const SLOWER: f64 = 1.0 / 3.0;

/// A step: the change of y and of the multipliers.
pub(super) struct Step {
    pub y: Vec<f64>,
    pub multipliers: Multipliers,
}

/// The matrices of all stages, and the curvature of the barrier.
pub(super) struct Kkt {
    blocks: Vec<Blocks>,
    free: Vec<usize>,
    curvature: Vec<f64>,
}

/// A factorised [`Kkt`].
pub(super) struct Newton<'k> {
    kkt: &'k Kkt,
    factors: Factors<'k>,
    /// The shift of the Hessian.
    pub shift: f64,
}

impl Kkt {
    /// The factors without a shift; `None` if the inertia is not that of a minimum.
    pub(super) fn factors(&self) -> Option<Newton<'_>> {
        Some(Newton { kkt: self, factors: Factors::new(&self.blocks, &self.free, 0.0)?, shift: 0.0 })
    }
}

impl Newton<'_> {
    /// The step for residuals of the constraints.
    pub(super) fn step(&self, method: &Method<'_>, residuals: &Residuals) -> Step {
        let mut gradient = method.gradient_of_value();
        method.add_constraints(&method.multipliers, &mut gradient);
        self.solve(method, &gradient, residuals)
    }

    /// The step for a gradient by y and residuals of the constraints.
    pub(super) fn solve(&self, method: &Method<'_>, gradient: &[f64], residuals: &Residuals) -> Step {
        let residual = |i: usize| residuals.rows[method.inequalities[i].stage][method.inequalities[i].row];
        let curvature = |i: usize| self.kkt.curvature[method.slack(i)];
        let slopes = |i: usize| gradient[method.slack(i)] + curvature(i) * residual(i);
        let mut sides = method.sides(&self.factors, gradient, slopes);
        sides.residuals.defects.clone_from_slice(&residuals.defects);
        for (k, equalities) in method.equalities.iter().enumerate() {
            sides.residuals.rows[k].iter_mut().zip(equalities).for_each(|(e, &row)| *e = residuals.rows[k][row]);
        }
        let direction = self.factors.solve(&sides);
        let slacks: Vec<f64> = (0..method.inequalities.len()).map(|i| method.change(&direction, i) + residual(i)).collect();
        let rows = method.all_rows(&direction, |i| curvature(i) * slacks[i] + gradient[method.slack(i)]);
        let y = direction.v.iter().flat_map(|v| v.iter().copied()).chain(slacks.iter().copied()).collect();
        Step { y, multipliers: Multipliers { costates: direction.multipliers.costates, rows } }
    }
}

impl Method<'_> {
    /// The matrices at the current point, with exact Hessians.
    ///
    /// # Errors
    /// A point without second derivatives.
    pub(super) fn kkt(&mut self) -> Result<Kkt, Error> {
        let hessians = self.problem.hessians(self.scale, &self.multipliers)?;
        let curvature = self.barrier.curvature(&self.y);
        Ok(self.kkt_of(hessians, curvature))
    }

    pub(super) fn kkt_of(&self, hessians: Vec<DMatrix<f64>>, curvature: Vec<f64>) -> Kkt {
        let shape = self.problem.shape();
        let mut blocks: Vec<Blocks> = Vec::with_capacity(hessians.len());
        for (k, (mut hessian, of)) in hessians.into_iter().zip(&self.linear).enumerate() {
            let mut rows = of.rows.select_rows(&self.equalities[k]);
            let (mut dynamics, mut shifted) = (of.dynamics.clone(), shape.shifted[k].clone());
            (0..hessian.nrows()).for_each(|i| hessian[(i, i)] += curvature[self.first[k] + i]);
            for (i, at) in self.inequalities.iter().enumerate().filter(|(_, at)| at.stage == k) {
                let row = of.rows.row(at.row);
                hessian.gemm_tr(curvature[self.slack(i)], &row, &row, 1.0);
            }
            for i in (0..hessian.nrows()).filter(|&i| self.is_held(k, i)) {
                hessian.fill_row(i, 0.0);
                hessian.fill_column(i, 0.0);
                hessian[(i, i)] = 1.0;
                dynamics.fill_column(i, 0.0);
                rows.fill_column(i, 0.0);
                shifted[i] = 0.0;
            }
            blocks.push(Blocks { hessian, dynamics, rows, shifted });
        }
        Kkt { blocks, free: shape.of_whole.clone(), curvature }
    }

    /// Factorises with the first shift of the Hessian that makes the step a direction of descent; `None` if none does. Far from feasible points, where
    /// a shift also shortens steps, negative curvature across rows with small derivatives is shifted, too.
    pub(super) fn factorise<'k>(&mut self, kkt: &'k Kkt, is_near: bool) -> Option<Newton<'k>> {
        let factors = |shift: f64| match is_near {
            true => Factors::new(&kkt.blocks, &kkt.free, shift),
            false => Factors::weighted(&kkt.blocks, &kkt.free, shift, ROWS[0]),
        };
        let mut shift = 0.0;
        while shift <= MOST_SHIFT {
            if let Some(factors) = factors(shift) {
                if shift > 0.0 {
                    self.shift = shift;
                }
                return Some(Newton { kkt, factors, shift });
            }
            shift = match (shift, self.shift) {
                (0.0, 0.0) => FIRST_SHIFT,
                (0.0, last) => (SLOWER * last).max(LEAST_SHIFT),
                (shift, 0.0) => FASTER * shift,
                (shift, _) => FAST * shift,
            };
        }
        None
    }

    /// Estimates the multipliers of the constraints by least squares; zero if they are large.
    pub(super) fn estimate_multipliers(&mut self) {
        self.multipliers = Multipliers::zeros(self.problem.shape());
        let hessians = self.problem.shape().bounds.iter().map(|of| DMatrix::identity(of.len(), of.len())).collect();
        let mut curvature = vec![0.0; self.y.len()];
        curvature[self.slack(0)..].fill(1.0);
        let kkt = self.kkt_of(hessians, curvature);
        let Some(factors) = Factors::new(&kkt.blocks, &kkt.free, 0.0) else { return };
        let mut gradient = self.gradient_of_cost();
        self.barrier.add_multipliers(&mut gradient);
        self.add_constraints(&self.multipliers, &mut gradient);
        let slope = |i: usize| gradient[self.slack(i)];
        let direction = factors.solve(&self.sides(&factors, &gradient, slope));
        let rows = self.all_rows(&direction, |i| slope(i) + self.change(&direction, i));
        let estimated = Multipliers { costates: direction.multipliers.costates, rows };
        if !self.are_large(&estimated) {
            self.multipliers = estimated;
        }
    }

    /// True for multipliers that are large compared with the derivatives of the cost, as they are where the constraints contradict each other.
    pub(super) fn are_large(&self, multipliers: &Multipliers) -> bool {
        let steepest = self.gradient_of_cost().iter().fold(1.0f64, |most, g| most.max(g.abs()));
        multipliers.largest() > LARGE * steepest
    }

    /// Right-hand sides for a gradient by y, with the slopes by the slacks, which are eliminated.
    fn sides(&self, factors: &Factors<'_>, gradient: &[f64], slopes: impl Fn(usize) -> f64) -> Sides {
        let mut sides = factors.zero();
        for (k, side) in sides.gradients.iter_mut().enumerate() {
            side.iter_mut().zip(&gradient[self.first[k]..]).for_each(|(side, g)| *side = *g);
        }
        for (i, at) in self.inequalities.iter().enumerate() {
            let row = self.linear[at.stage].rows.row(at.row);
            sides.gradients[at.stage].axpy(slopes(i), &row.transpose(), 1.0);
        }
        for (k, side) in sides.gradients.iter_mut().enumerate() {
            (0..side.len()).filter(|&i| self.is_held(k, i)).for_each(|i| side[i] = 0.0);
        }
        sides
    }

    /// J dv of an inequality.
    fn change(&self, direction: &Direction, i: usize) -> f64 {
        let at = self.inequalities[i];
        self.linear[at.stage].rows.row(at.row).transpose().dot(&direction.v[at.stage])
    }

    /// Multipliers of all rows: of equalities from the direction, of inequalities by their numbers.
    fn all_rows(&self, direction: &Direction, of_inequality: impl Fn(usize) -> f64) -> Vec<DVector<f64>> {
        let mut all = Multipliers::zeros(self.problem.shape()).rows;
        for (k, rows) in self.equalities.iter().enumerate() {
            rows.iter().zip(direction.multipliers.rows[k].iter()).for_each(|(&row, x)| all[k][row] = *x);
        }
        for (i, at) in self.inequalities.iter().enumerate() {
            all[at.stage][at.row] = of_inequality(i);
        }
        all
    }
}
