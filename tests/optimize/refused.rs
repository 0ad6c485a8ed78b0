//! What is refused, and by which name.

use super::common::assert_says;
use super::{everything_free, problem, push, shooting};
use hamiltonian_adjoint::optimize::{Free, MultipleShooting, Problem, Trials, Variables};
use hamiltonian_adjoint::{Grid, Inputs, Settings};
use nalgebra::DMatrix;

/// Every method of a problem, with one entry too few or too many of each argument.
fn assert_refuses_lengths(problem: &mut dyn Problem, x: &[f64]) {
    let (n, m) = (x.len(), problem.constraints().len());
    let (mut all, mut c) = (vec![0.0; n], vec![0.0; m]);
    problem.evaluate(x, &mut c).expect("a value");
    let wrong =
        |length: usize| [length - 1, length + 1].map(|wrong| (vec![0.1; wrong], format!("expected {length}"), wrong));
    for (mut other, expected, found) in wrong(n) {
        let (expected, found) = (&*expected, &*format!("found {found}"));
        assert_says(&problem.evaluate(&other, &mut c).expect_err("x"), &[expected, found]);
        assert_says(&problem.gradient(1.0, &c, &mut other).expect_err("gradient"), &["gradient", expected, found]);
        assert_says(&problem.push_forward(&other, &mut c).expect_err("direction"), &["direction", expected, found]);
        assert_says(&problem.product(&other, &mut all).expect_err("direction"), &["direction", expected, found]);
        assert_says(&problem.product(x, &mut other).expect_err("product"), &["product", expected, found]);
        let mut jacobian = DMatrix::zeros(1, other.len());
        assert_says(&problem.jacobian(&[0], &mut jacobian).expect_err("columns"), &["columns", expected, found]);
    }
    for (mut other, expected, found) in wrong(m) {
        let (expected, found) = (&*expected, &*format!("found {found}"));
        // A motion's cost alone may be asked for, with no room for values of constraints.
        if !other.is_empty() {
            assert_says(&problem.evaluate(x, &mut other).expect_err("c"), &["constraints", expected, found]);
        }
        assert_says(&problem.gradient(1.0, &other, &mut all).expect_err("weights"), &["weights", expected, found]);
        assert_says(&problem.push_forward(x, &mut other).expect_err("changes"), &["changes", expected, found]);
    }
    let mut jacobian = DMatrix::zeros(2, n);
    assert_says(&problem.jacobian(&[0], &mut jacobian).expect_err("rows"), &["rows", "expected 1", "found 2"]);
    assert_says(&problem.jacobian(&[0, m], &mut jacobian).expect_err("row"), &["row", &format!("is {m}"), "less than"]);
    assert!(problem.evaluate(x, &mut c).is_ok());
}

#[test]
fn what_has_another_length_is_refused() {
    let (system, force) = push(false);
    let motion = || problem(&system, force, Inputs::at_rest(&system, Grid::uniform(6, 0.1)));
    let start = motion().start();
    assert_refuses_lengths(&mut motion(), &start);
    assert_refuses_lengths(&mut Trials::new(vec![motion(), motion()]).expect("trials"), &start);
    let (system, force, _, states) = shooting::push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.1));
    let mut segments =
        MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 2).expect("fits");
    let start = segments.start();
    assert_refuses_lengths(&mut segments, &start);
}

#[test]
fn variables_are_applied_to_inputs_that_they_fit() {
    let (system, inputs, free) = everything_free();
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let (x, n) = (variables.of(&inputs), variables.len());
    for length in [0, n - 1, n + 1] {
        let mut to = inputs.clone();
        let error = variables.apply(&vec![0.1; length], &mut to).expect_err("another length");
        assert_says(&error, &["variables", &format!("expected {n}"), &format!("found {length}")]);
        assert_eq!(to, inputs, "nothing is set");
    }
    let mut short = inputs.clone();
    short.controls = short.controls.columns(0, 2).into_owned();
    assert_says(&variables.apply(&x, &mut short).expect_err("few controls"), &["controls", "found 2"]);
    let mut short = Inputs::at_rest(&system, Grid::uniform(2, 0.1));
    assert_says(&variables.apply(&x, &mut short).expect_err("few nodes"), &["nodes", "found 3"]);
}
