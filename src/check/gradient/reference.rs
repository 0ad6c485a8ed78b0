//! [`Reference`]: products aᵀH b another way than by the adjoint, through hyper-dual numbers or, where these do not go through, by differences of gradients.

use std::cell::RefCell;

use super::super::ridders::ridders;
use super::directions::{along, product};
use super::{CAUTION, FIRST_STEP, Subject, is_alike};
use crate::check::Input;
use crate::{Error, Hyper, Inputs, LiftedSolver, Real, Settings, Solver};

/// The most halvings of the differences' step, and how good they need be.
const HALVINGS: usize = 12;
const ENOUGH: f64 = 1e-10;

/// The solvers of both ways.
pub(super) struct Reference<'a> {
    subject: Subject<'a>,
    hyper: LiftedSolver<'a, Hyper>,
    real: RefCell<Solver<'a>>,
    /// Whether hyper-dual numbers do not go through.
    pub(super) is_differences: bool,
    /// The largest [`LiftedSolver::rounding`] of all motions on hyper-dual numbers.
    pub(super) rounding: f64,
}

impl<'a> Reference<'a> {
    pub(super) fn new(subject: Subject<'a>) -> Result<Self, Error> {
        let hyper = subject.lifted()?;
        // Initial values are moved off the constraints.
        let free = f64::INFINITY;
        let settings = Settings { position_tolerance: free, velocity_tolerance: free, ..subject.settings };
        let real = RefCell::new(Solver::new(subject.system, settings));
        Ok(Reference { subject, hyper, real, is_differences: false, rounding: 0.0 })
    }

    /// aᵀH b, and what it may be off by: nothing but rounding by hyper-dual numbers.
    pub(super) fn product(&mut self, [a, b]: [&Inputs; 2]) -> Result<(f64, f64), Error> {
        if !self.is_differences {
            match self.by_hyper([a, b]) {
                Err(Error::NoHyperDual) => self.is_differences = true,
                found => return found.map(|value| (value, 0.0)),
            }
        }
        let (value, error) = ridders(|s| (s, vec![self.slope(a, b, s)]), (FIRST_STEP, HALVINGS), ENOUGH, 1);
        Ok((value[0], CAUTION * error[0]))
    }

    fn by_hyper(&mut self, directions: [&Inputs; 2]) -> Result<f64, Error> {
        let inputs = self.subject.inputs;
        let mut lifted = inputs.lift::<Hyper>();
        for (part, direction) in (1..).zip(directions) {
            let mut direction = direction.clone();
            for input in Input::all(inputs) {
                let d = *input.of(&mut direction);
                input.of(&mut lifted).add_to_part(part, d);
            }
        }
        self.hyper.simulate(&lifted)?;
        self.rounding = self.rounding.max(self.hyper.rounding());
        Ok(self.hyper.value_of(self.subject.which)?.part(3))
    }

    /// dJ along a at x + s b; NaN where there is no motion like the one at x.
    fn slope(&self, a: &Inputs, b: &Inputs, s: f64) -> f64 {
        let (mut solver, here) = (self.real.borrow_mut(), self.hyper.real().trajectory());
        let moved = solver.simulate(&along(self.subject.inputs, b, s));
        if !moved.is_ok_and(|motion| is_alike(motion, here)) {
            return f64::NAN;
        }
        solver.gradient_of(self.subject.which).map_or(f64::NAN, |gradient| product(gradient, a).0)
    }
}
