//! dJ along a direction, by every way that is not the adjoint, sharing one real motion.

use num_dual::Dual64;
use std::cell::RefCell;

use super::super::direct::moved;
use super::super::ridders::ridders;
use super::directions::along;
use super::{FIRST_STEP, Subject, is_alike};
use crate::{Cx, Error, Inputs, LiftedSolver, Solver};

/// The most halvings of the differences' step; easy motions need three or four.
const HALVINGS: usize = 12;
/// The differences need not be better than this: simulations cost.
const ENOUGH: f64 = 1e-8;
/// The step of second differences, relative to the direction.
const BENT_STEP: f64 = 1e-4;
/// A tenth of a tolerance of 1e-9 of these parts of |J| and |d²J| is some units in the last place of J, and what a relative change of the motion by
/// 1e-14 makes of dJ.
pub(super) const OF_VALUE: f64 = 1e-6;
const OF_CURVATURE: f64 = 1e-4;
/// Below this part of |J|, second differences are rounding of J.
const SEEN: f64 = 16.0 * f64::EPSILON / (BENT_STEP * BENT_STEP);
/// A tolerance of 1e-9 of this part of the terms of derivatives by step lengths is what rounding makes of the sum of some thousand of them.
const OF_TERMS: f64 = 1e-4;

/// The solvers of the three ways.
pub(super) struct Ways<'a> {
    subject: Subject<'a>,
    /// How large the terms of dJ/dΔt are, step by step.
    of_steps: Vec<f64>,
    dual: LiftedSolver<'a, Dual64>,
    complex: LiftedSolver<'a, Cx>,
    real: RefCell<Solver<'a>>,
    /// The largest [`LiftedSolver::rounding`] of all motions.
    pub(super) rounding: f64,
}

impl<'a> Ways<'a> {
    pub(super) fn new(subject: Subject<'a>, of_steps: Vec<f64>) -> Result<Self, Error> {
        let real = RefCell::new(Solver::new(subject.system, subject.settings));
        Ok(Ways { subject, of_steps, dual: subject.lifted()?, complex: subject.lifted()?, real, rounding: 0.0 })
    }

    /// Direct differentiation.
    pub(super) fn direct(&mut self, direction: &Inputs) -> Result<f64, Error> {
        self.dual.simulate(&moved(self.subject.inputs, direction, Dual64::new)?)?;
        self.rounding = self.rounding.max(self.dual.rounding());
        Ok(self.dual.value_of(self.subject.which)?.eps)
    }

    /// Im J(x + i h d)/h.
    pub(super) fn complex_step(&mut self, direction: &Inputs) -> Result<f64, Error> {
        const STEP: f64 = 1e-30;
        self.complex.simulate(&moved(self.subject.inputs, direction, |x, d| Cx::new(x, STEP * d))?)?;
        self.rounding = self.rounding.max(self.complex.rounding());
        Ok(self.complex.value_of(self.subject.which)?.0.im / STEP)
    }

    /// Ridders' differences, with their error estimate; a step without a motion is left out.
    pub(super) fn differences(&mut self, direction: &Inputs) -> (f64, f64) {
        let (derivative, error) = ridders(|s| (s, vec![self.value_along(direction, s)]), (FIRST_STEP, HALVINGS), ENOUGH, 1);
        (derivative[0], error[0])
    }

    /// The size below which dJ along a direction is rounding of J, of its own terms, or of the motion where dJ passes zero, as at an optimum; and what dJ
    /// is nearby, as far as its own terms and d²J tell.
    pub(super) fn floor(&self, direction: &Inputs, value: f64) -> (f64, f64) {
        let [above, below] = [BENT_STEP, -BENT_STEP].map(|s| self.value_along(direction, s));
        // J may be zero here alone. NaN is left out.
        let value_around = value.abs().max(above.abs()).max(below.abs());
        let curvature = (above - 2.0 * value + below).abs() / (BENT_STEP * BENT_STEP);
        // Without a motion there, nothing is known of it.
        let curvature = if curvature.is_finite() { curvature } else { 0.0 };
        let terms = self.of_steps.iter().zip(&direction.grid.steps).map(|(size, d)| (size * d).powi(2)).sum::<f64>().sqrt();
        let is_seen = curvature > SEEN * value_around;
        let floor = OF_VALUE * value_around + OF_TERMS * terms + OF_CURVATURE * curvature;
        (floor, terms.max(if is_seen { curvature } else { 0.0 }))
    }

    /// J(x + s d); NaN where there is no motion like the one at x.
    pub(super) fn value_along(&self, direction: &Inputs, s: f64) -> f64 {
        let (mut solver, here) = (self.real.borrow_mut(), self.dual.real().trajectory());
        let moved = solver.simulate(&along(self.subject.inputs, direction, s));
        if moved.is_ok_and(|motion| is_alike(motion, here)) {
            solver.value_of(self.subject.which).unwrap_or(f64::NAN)
        } else {
            f64::NAN
        }
    }
}
