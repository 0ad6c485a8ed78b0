//! Costs, residuals, constraints and scales whose squares are beyond the range of numbers, or near it.

use super::common::assert_says;
use super::flat::Quadratic;
use hamiltonian_adjoint::optimize::{
    Free, Interval, Options, Outcome, Problem, Reason, Variables, augmented_lagrangian, interior_point, lbfgs,
    levenberg_marquardt, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Error, Grid, Inputs, Scene};
use nalgebra::DMatrix;

/// Any start was stationary where the square of its gradient is infinite, or zero.
#[test]
fn costs_of_any_size_are_minimised() {
    for size in [1e-280, 1e-170, 1e-120, 1.0, 1e104, 1e112, 1e118, 1e160, 1e200, 1e290] {
        for start in [0.0, 1.0, 7.0] {
            let h = DMatrix::from_diagonal(&nalgebra::dvector![size, 4.0 * size]);
            let mut problem = Quadratic::new(h, &[-3.0 * size, 4.0 * size], vec![Interval::FREE, Interval::at_least(-9.0)]);
            for method in [lbfgs, augmented_lagrangian, interior_point] {
                let outcome = method(&mut problem, &[start; 2], &Options::default(), &mut silent).expect("fits");
                let is_there = (outcome.x[0] - 3.0).abs() < 1e-5 && (outcome.x[1] + 1.0).abs() < 1e-5;
                assert!(outcome.reason == Reason::Stationary && is_there, "{size:e} from {start}: {outcome:?}");
            }
        }
    }
}

/// Residuals b (a x − 1) and b (a x − 2).
struct Residuals {
    a: f64,
    b: f64,
}

impl Problem for Residuals {
    fn variables(&self) -> usize {
        1
    }
    fn constraints(&self) -> Vec<Interval> {
        vec![Interval::ZERO; 2]
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        c.copy_from_slice(&[1.0, 2.0].map(|at| self.b * (self.a * x[0] - at)));
        Ok(0.0)
    }
    fn gradient(&mut self, _: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient[0] = self.a * self.b * (c[0] + c[1]);
        Ok(())
    }
}

/// Derivatives whose squares are zero were none: the start was stationary, and standard errors infinite.
#[test]
fn a_fit_takes_small_derivatives_for_what_they_are() {
    for (a, b) in [(1.0, 1.0), (1e-100, 1.0), (1e-170, 1.0), (1e-300, 1.0), (1e150, 1.0), (1.0, 1e-100), (1.0, 1e150)] {
        let fit = levenberg_marquardt(&mut Residuals { a, b }, &[0.0], &Options::default(), &mut silent).expect("fits");
        assert_eq!(fit.outcome.reason, Reason::Stationary, "{a:e} {b:e}");
        assert!((fit.outcome.x[0] * a - 1.5).abs() < 1e-6 && fit.undetermined().is_empty(), "{:?}", fit.outcome);
        // Of two numbers that are 1 apart: half of it.
        let errors = fit.standard_errors().expect("determined");
        assert!((errors[0] * a - 0.5).abs() < 1e-6, "{a:e} {b:e}: {errors:?}");
    }
    for (a, b) in [(1.0, 1e-160), (1.0, 1e-200), (1e-312, 1.0)] {
        let fit = levenberg_marquardt(&mut Residuals { a, b }, &[0.0], &Options::default(), &mut silent).expect("fits");
        let Outcome { reason, first_failure, .. } = fit.outcome;
        let is_overflow = matches!(first_failure, Some(Error::Overflow { .. }));
        assert!(reason == Reason::NoStart && is_overflow, "{a:e} {b:e}: {reason:?} {first_failure:?}");
    }
}

/// c = k x ≥ 0 beside a steep objective: the largest penalty was taken for a proof.
#[test]
fn large_units_of_constraints_do_not_make_them_infeasible() {
    struct Steep(f64, f64);
    impl Problem for Steep {
        fn variables(&self) -> usize {
            1
        }
        fn constraints(&self) -> Vec<Interval> {
            vec![Interval::at_least(0.0)]
        }
        fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
            (self.1, c[0]) = (x[0], self.0 * x[0]);
            Ok(0.625 * x[0] * x[0] + 8.582282348829732 * x[0] - 5.0)
        }
        fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
            gradient[0] = f * (1.25 * self.1 + 8.582282348829732) + c[0] * self.0;
            Ok(())
        }
    }
    for unit in [1.0, 1e2, 1e4, 1e5, 1e6, 2e6, 1e7, 1e8, 1e9] {
        for start in [1.0, -1.0, 0.3] {
            let outcome =
                augmented_lagrangian(&mut Steep(unit, 0.0), &[start], &Options::default(), &mut silent).expect("fits");
            assert!(outcome.reason != Reason::Infeasible && outcome.x[0].abs() < 1e-8, "{unit:e} from {start}: {outcome:?}");
        }
    }
}

/// They became infinite, and were none.
#[test]
fn bounds_beyond_the_range_of_numbers_are_refused() {
    let mut scene = Scene::new();
    let stiffness = scene.design("k", 2.0);
    let body = scene.body("c", 1.0, 0.1, [0.0; 3]);
    scene.spring_damper("spring", Body::GROUND.at(-1.0, 0.0), body.at(0.0, 0.0), stiffness, 1.2, 0.1);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
    let free = |scale, least, most| {
        Variables::new(&system, &inputs, vec![Free::design(stiffness).scaled(scale).within(least, most)])
    };
    assert_says(&free(1e-10, 1.0, 1e300).expect_err("no upper bound"), &["`k`", "upper", "scale"]);
    assert_says(&free(1e-10, -1e300, 1.0).expect_err("no lower bound"), &["`k`", "lower", "scale"]);
    assert!(free(1e-10, 1.0, f64::INFINITY).is_ok() && free(1e10, 1.0, 1e300).is_ok());
}
