//! [`Reference`]: products aᵀH b another way than by the adjoint, through hyper-dual numbers or, where these do not go through, by differences of gradients.

use std::cell::RefCell;

use super::super::ridders::ridders;
use super::directions::{along, product};
use super::{CAUTION, FIRST_STEP};
use crate::check::Input;
use crate::{Error, Hyper, Inputs, LiftedSolver, Real, Settings, Solver, System};

/// The most halvings of the differences' step, and how good they need be.
const HALVINGS: usize = 12;
const ENOUGH: f64 = 1e-10;

/// The solvers of both ways.
pub(super) struct Reference<'a> {
    inputs: &'a Inputs,
    /// J (0) or an output (from 1 on).
    which: usize,
    hyper: LiftedSolver<'a, Hyper>,
    real: RefCell<Solver<'a>>,
    /// Whether hyper-dual numbers do not go through.
    pub(super) is_differences: bool,
}

impl<'a> Reference<'a> {
    pub(super) fn new(system: &'a System, inputs: &'a Inputs, settings: Settings, which: usize) -> Result<Self, Error> {
        let hyper = LiftedSolver::new(system, inputs, settings)?;
        // Initial values are moved off the constraints.
        let settings = Settings { position_tolerance: f64::INFINITY, velocity_tolerance: f64::INFINITY, ..settings };
        let real = RefCell::new(Solver::new(system, settings));
        Ok(Reference { inputs, which, hyper, real, is_differences: false })
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
        let mut lifted = self.inputs.lift::<Hyper>();
        for (part, direction) in (1..).zip(directions) {
            let mut direction = direction.clone();
            for input in Input::all(self.inputs) {
                let d = *input.of(&mut direction);
                input.of(&mut lifted).add_to_part(part, d);
            }
        }
        self.hyper.simulate(&lifted)?;
        Ok(self.hyper.value_of(self.which)?.part(3))
    }

    /// dJ along a at x + s b; NaN where there is no motion.
    fn slope(&self, a: &Inputs, b: &Inputs, s: f64) -> f64 {
        let mut solver = self.real.borrow_mut();
        if solver.simulate(&along(self.inputs, b, s)).is_err() {
            return f64::NAN;
        }
        solver.gradient_of(self.which).map_or(f64::NAN, |gradient| product(gradient, a).0)
    }
}
