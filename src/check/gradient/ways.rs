//! Derivatives along directions by all ways except the adjoint.

use num_dual::Dual64;
use std::cell::RefCell;

use super::super::direct::moved;
use super::super::ridders::ridders;
use super::directions::product;
use super::report::{CAUTION, DirectionReport};
use super::sizes::Terms;
use super::subject::Subject;
use super::taylor::FIRST_STEP;
use crate::check::Input;
use crate::{Cx, Error, Gradient, Hyper, Inputs, LiftedSolver, Real, Settings, Solver};

/// Maximum number of halvings of the difference step; smooth motions need three or four.
const HALVINGS: usize = 12;
/// Sufficient accuracies of differences of values and of gradients, because simulations are expensive.
const ENOUGH: [f64; 2] = [1e-8, 1e-10];
/// The step of second differences, relative to the direction.
const BENT_STEP: f64 = 1e-4;
/// Fractions of |J| and |d²J|. A tenth of a tolerance of 1e-9 of these is a few units in the last place of J, and the effect on dJ of
/// a relative change of the motion by 1e-14.
pub(super) const OF_VALUE: f64 = 1e-6;
const OF_CURVATURE: f64 = 1e-4;
/// Second differences below this fraction of |J| are rounding of J.
const SEEN: f64 = 16.0 * f64::EPSILON / (BENT_STEP * BENT_STEP);
/// Fraction of the terms of derivatives by step lengths and design variables. A tolerance of 1e-9 of it is the rounding error of a sum of some thousand terms.
const OF_TERMS: f64 = 1e-4;

/// Motions computed with another number type, and ordinary ones near the one at the inputs.
pub(super) struct Way<'a, R: Real> {
    subject: Subject<'a>,
    solver: LiftedSolver<R>,
    beside: RefCell<Solver>,
    /// True if the motion can be computed with this number type.
    pub goes_through: bool,
    /// The largest [`LiftedSolver::rounding`] of all motions.
    pub rounding: f64,
}

impl<'a, R: Real> Way<'a, R> {
    pub(super) fn new(subject: Subject<'a>) -> Result<Self, Error> {
        let solver = subject.lifted()?;
        // Initial values are moved off the constraints.
        let free = f64::INFINITY;
        let settings = Settings { position_tolerance: free, velocity_tolerance: free, ..subject.settings };
        let beside = RefCell::new(subject.solver(settings));
        Ok(Way { subject, solver, beside, goes_through: true, rounding: 0.0 })
    }

    /// J computed with this number type.
    fn value(&mut self, inputs: &Inputs<R>) -> Result<R, Error> {
        self.solver.simulate(inputs)?;
        self.rounding = self.rounding.max(self.solver.rounding());
        self.solver.value_of(self.subject.which)
    }

    /// Value read from the motion at x + s d; NaN unless it uses the same steps and restarts as the one at x (J is another function then).
    pub(super) fn beside(&self, direction: &Inputs, s: f64, read: impl Fn(&mut Solver) -> Result<f64, Error>) -> f64 {
        let mut solver = self.beside.borrow_mut();
        let moves = solver.simulate(&self.subject.inputs.along(direction, |x, d| x + s * d)).is_ok();
        if moves && solver.moves_like(self.solver.real()) { read(&mut solver).unwrap_or(f64::NAN) } else { f64::NAN }
    }

    /// Ridders' differences of the value read, with their error estimate; steps without a motion are left out.
    fn differences(&self, direction: &Inputs, enough: f64, read: impl Fn(&mut Solver) -> Result<f64, Error>) -> (f64, f64) {
        let along = |s| (s, vec![self.beside(direction, s, &read)]);
        let (derivative, error) = ridders(along, (FIRST_STEP, HALVINGS), enough, 1);
        (derivative[0], error[0])
    }
}

/// Ways to compute dJ along a direction.
pub(super) struct Ways<'a> {
    terms: Terms,
    dual: Way<'a, Dual64>,
    complex: Way<'a, Cx>,
}

impl<'a> Ways<'a> {
    pub(super) fn new(subject: Subject<'a>, terms: Terms) -> Result<Self, Error> {
        Ok(Ways { terms, dual: Way::new(subject.clone())?, complex: Way::new(subject)? })
    }

    /// The largest [`LiftedSolver::rounding`] of all motions.
    pub(super) fn rounding(&self) -> f64 {
        self.dual.rounding.max(self.complex.rounding)
    }

    /// dJ along a direction by direct differentiation.
    pub(super) fn direct(&mut self, direction: &Inputs) -> Result<f64, Error> {
        Ok(self.dual.value(&moved(self.dual.subject.inputs, direction, Dual64::new)?)?.eps)
    }

    /// Compares the gradient along a direction with direct differentiation, Im J(x + i h d)/h, and differences.
    pub(super) fn compare(
        &mut self,
        name: String,
        direction: &Inputs,
        gradient: &Gradient,
        tolerance: f64,
    ) -> Result<DirectionReport, Error> {
        const STEP: f64 = 1e-30;
        let Subject { inputs, which, .. } = self.dual.subject;
        let (adjoint, size) = product(gradient, direction);
        let direct = self.direct(direction)?;
        let complex_step = self.complex.value(&moved(inputs, direction, |x, d| Cx::new(x, STEP * d))?)?.0.im / STEP;
        let (differences, error) = self.dual.differences(direction, ENOUGH[0], |solver| solver.value_of(which));
        let (floor, nearby) = self.floor(direction, gradient.value);
        let values = [adjoint, direct, complex_step, differences];
        Ok(DirectionReport::new(name, values, error, [size, floor, nearby], tolerance))
    }

    /// The size below which dJ along a direction is rounding of J, of its own terms, or (as at an optimum) of the motion; and the size of dJ
    /// nearby, as far as its terms and d²J show.
    pub(super) fn floor(&self, direction: &Inputs, value: f64) -> (f64, f64) {
        let [above, below] = [BENT_STEP, -BENT_STEP].map(|s| self.value_along(direction, s));
        // J may be zero at this point only. NaN is ignored.
        let value_around = value.abs().max(above.abs()).max(below.abs());
        let curvature = (above - 2.0 * value + below).abs() / (BENT_STEP * BENT_STEP);
        // Without neighbouring motions d²J is unknown.
        let curvature = if curvature.is_finite() { curvature } else { 0.0 };
        let terms = self.terms.along(direction);
        let is_seen = curvature > SEEN * value_around;
        let floor = OF_VALUE * value_around + OF_TERMS * terms + OF_CURVATURE * curvature;
        (floor, terms.max(if is_seen { curvature } else { 0.0 }))
    }

    /// J(x + s d); NaN if there is no motion like the one at x.
    pub(super) fn value_along(&self, direction: &Inputs, s: f64) -> f64 {
        self.dual.beside(direction, s, |solver| solver.value_of(self.dual.subject.which))
    }
}

impl Way<'_, Hyper> {
    /// aᵀH b by hyper-dual numbers or, if these are not supported, by differences of gradients; and its error, 0 for the former.
    pub(super) fn product(&mut self, [a, b]: [&Inputs; 2]) -> Result<(f64, f64), Error> {
        if self.goes_through {
            match self.by_hyper([a, b]) {
                Err(Error::NoHyperDual) => self.goes_through = false,
                found => return found.map(|value| (value, 0.0)),
            }
        }
        let slope = |solver: &mut Solver| Ok(product(solver.gradient_of(self.subject.which)?, a).0);
        let (value, error) = self.differences(b, ENOUGH[1], slope);
        Ok((value, CAUTION * error))
    }

    fn by_hyper(&mut self, directions: [&Inputs; 2]) -> Result<f64, Error> {
        let mut lifted = self.subject.inputs.lift::<Hyper>();
        for (part, direction) in (1..).zip(directions) {
            let mut direction = direction.clone();
            for input in Input::all(self.subject.inputs) {
                let d = *input.of(&mut direction);
                input.of(&mut lifted).add_to_part(part, d);
            }
        }
        Ok(self.value(&lifted)?.part(3))
    }
}
