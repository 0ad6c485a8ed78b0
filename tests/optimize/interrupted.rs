//! What stops methods on their way, or has no derivatives there: nothing is lost of what was found.

use super::common::assert_says;
use super::{Function, Given, everything_free};
use hamiltonian_adjoint::optimize::{
    Interval, Iterate, MotionProblem, Options, Outcome, Problem, Reason, Variables, augmented_lagrangian, homotopy,
    interior_point, lbfgs, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::{Error, Settings};
use std::ops::ControlFlow;

/// What is asked of a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Asked {
    Value,
    Gradient,
    Product,
}

/// A problem that gives an error instead of what is asked for, behind so many that it gave, or at points where `fails`.
struct Failing {
    given: Given,
    what: Asked,
    left: usize,
    fails: fn(&[f64]) -> bool,
    error: Error,
}

impl Failing {
    fn check(&mut self, what: Asked) -> Result<(), Error> {
        if what != self.what || !(self.fails)(&self.given.x) {
            return Ok(());
        }
        self.left = self.left.checked_sub(1).ok_or(self.error.clone())?;
        Ok(())
    }
}

impl Problem for Failing {
    fn variables(&self) -> usize {
        self.given.variables()
    }
    fn bounds(&self) -> Vec<Interval> {
        self.given.bounds()
    }
    fn constraints(&self) -> Vec<Interval> {
        self.given.constraints()
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        let value = self.given.evaluate(x, c);
        // Nothing is to be made of constraints where there is an error.
        self.check(Asked::Value).inspect_err(|_| c.fill(f64::NAN))?;
        value
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.check(Asked::Gradient)?;
        self.given.gradient(f, c, gradient)
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.check(Asked::Product)?;
        self.given.product(direction, product)
    }
}

/// Rosenbrock's valley, its two residuals, and x.
fn valley(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    let (a, b) = (10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
    g[..2].copy_from_slice(&[-40.0 * a * x[0] - 2.0 * b, 20.0 * a]);
    if let [first, second, third] = c {
        (*first, *second, *third) = (a, b, x[0]);
        g[2..].copy_from_slice(&[-20.0 * x[0], 10.0, -1.0, 0.0, 1.0, 0.0]);
    }
    a * a + b * b
}

type Method = fn(&mut Failing, &Options, &mut dyn FnMut(&Iterate, &[f64]) -> ControlFlow<()>) -> Result<Outcome, Error>;

const START: [f64; 2] = [-1.2, 1.0];

/// Methods with what must be of the two residuals and of x.
fn methods() -> [(Method, Vec<Interval>); 5] {
    let bounded = vec![Interval::FREE, Interval::FREE, Interval::at_most(0.5)];
    [
        (|problem, options, watch| lbfgs(problem, &START, options, watch), vec![]),
        (|problem, options, watch| augmented_lagrangian(problem, &START, options, watch), bounded.clone()),
        (|problem, options, watch| interior_point(problem, &START, options, watch), bounded.clone()),
        (|problem, options, watch| homotopy(problem, &START, options, &mut |_, _| Ok(()), watch), bounded),
        (
            |problem, options, watch| Ok(levenberg_marquardt(problem, &START, options, watch)?.outcome),
            vec![Interval::ZERO, Interval::ZERO, Interval::FREE],
        ),
    ]
}

fn failing(constraints: &[Interval], (what, left): (Asked, usize), fails: fn(&[f64]) -> bool, error: Error) -> Failing {
    Failing { given: Given::new(valley, vec![Interval::FREE; 2], constraints.to_vec()), what, left, fails, error }
}

/// An interrupted motion was taken for one without a value: methods went on with shorter and shorter steps.
#[test]
fn whoever_stops_a_simulation_stops_the_method() {
    for (k, (method, constraints)) in methods().iter().enumerate() {
        for what in [Asked::Value, Asked::Gradient, Asked::Product] {
            for left in [1, 5, 8, 13].into_iter().filter(|left| what != Asked::Product || *left > 1) {
                let interrupted = Error::Interrupted { done: 1, of: 2 };
                let mut problem = failing(constraints, (what, left), |_| true, interrupted);
                let mut last = Vec::new();
                let mut watch = |_: &Iterate, x: &[f64]| {
                    last = x.to_vec();
                    ControlFlow::Continue(())
                };
                let outcome = method(&mut problem, &Options::default(), &mut watch).expect("an outcome");
                if problem.left > 0 || outcome.reason.is_converged() {
                    continue;
                }
                assert_eq!(outcome.reason, Reason::Interrupted, "{k}: {outcome:?}");
                if last.is_empty() {
                    // At the start itself.
                    assert!(left == 1 && outcome.iterations == 0 && outcome.value.is_infinite(), "{k} {what:?} {outcome:?}");
                    continue;
                }
                assert_eq!(outcome.x, last, "{k}: {what:?} {left}");
                let numbers = [&outcome.constraints[..], &[outcome.value, outcome.violation]].concat();
                assert!(numbers.iter().all(|x| x.is_finite()), "{k}: {outcome:?}");
                assert!(matches!(outcome.first_failure, Some(Error::Interrupted { .. })), "{k}: {outcome:?}");
                assert!(outcome.failures <= 3, "{k}: {outcome:?}");
            }
        }
    }
    // The same of a motion.
    let (system, inputs, free) = everything_free();
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let mut left = 100;
    problem.solver.watch(move |_| {
        left -= 1;
        if left < 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let start = problem.start();
    let options = Options { stationarity: 0.0, ..Options::default() };
    let outcome = augmented_lagrangian(&mut problem, &start, &options, &mut silent).expect("an outcome");
    assert_eq!(outcome.reason, Reason::Interrupted, "{outcome:?}");
}

fn undefined() -> Error {
    Error::NotFinite { what: "the test's derivative".into(), value: f64::NAN }
}

#[test]
fn a_trial_without_a_gradient_is_no_abort() {
    for (k, (method, constraints)) in methods().iter().enumerate() {
        // A quarter of all points, by their last digits, but not the start.
        let mut problem = failing(constraints, (Asked::Gradient, 0), |x| x[0].to_bits() % 4 == 1, undefined());
        let options = Options { stationarity: 1e-6, ..Options::default() };
        let outcome = method(&mut problem, &options, &mut silent).expect("an outcome");
        assert!(outcome.reason.is_converged() && outcome.failures > 0, "{k}: {outcome:?}");
        let expected = if outcome.constraints.is_empty() || k == 4 { [1.0, 1.0] } else { [0.5, 0.25] };
        assert!(outcome.x.iter().zip(expected).all(|(x, of)| (x - of).abs() < 1e-3), "{k}: {outcome:?}");
        assert_says(&outcome.first_failure.expect("a failure"), &["the test's derivative"]);
    }
}

#[test]
fn where_second_derivatives_end_the_point_is_kept() {
    let bounded = [Interval::FREE, Interval::FREE, Interval::at_most(0.5)];
    let mut problem = failing(&bounded, (Asked::Product, 0), |x| x[0] > 0.0, undefined());
    let outcome = interior_point(&mut problem, &START, &Options::default(), &mut silent).expect("an outcome");
    assert_eq!(outcome.reason, Reason::NoDerivative, "{outcome:?}");
    assert!(outcome.x[0] > 0.0 && outcome.value < 1.5, "{outcome:?}");
    assert_says(&outcome.first_failure.expect("a failure"), &["the test's derivative"]);
    // At the start nothing can be done.
    let mut problem = failing(&bounded, (Asked::Product, 0), |_| true, undefined());
    let outcome = interior_point(&mut problem, &START, &Options::default(), &mut silent).expect("an outcome");
    assert_eq!(outcome.reason, Reason::NoStart, "{outcome:?}");
    assert_says(&outcome.first_failure.expect("no second derivatives"), &["the test's derivative"]);
}

#[test]
fn a_start_beside_its_bound_is_moved_by_as_much_as_has_a_value() {
    // (x − 0.002)² on [0, 0.005], and nothing beyond.
    let narrow: Function = |x, _, g| {
        g[0] = 2.0 * (x[0] - 2e-3);
        if x[0] > 5e-3 { f64::NAN } else { 1.0 + (x[0] - 2e-3).powi(2) }
    };
    let mut problem = Given::new(narrow, vec![Interval::at_least(0.0)], vec![]);
    let outcome = interior_point(&mut problem, &[1e-4], &Options::default(), &mut silent).expect("a value at the start");
    assert!(outcome.x[0] <= 5e-3, "{outcome:?}");
}
