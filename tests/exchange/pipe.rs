//! Derivatives from programs in other languages.
use crate::common::assert_says;
use hamiltonian_adjoint::Scalar;
use hamiltonian_adjoint::check::{self, Pipe};
use hamiltonian_adjoint::planar::Distance;
use std::process::Command;

pub const B: [f64; 5] = [0.1, 0.2, 0.3, -0.4, 0.7];

pub struct Polar;

impl check::Function for Polar {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![x[0] * x[1].cos(), x[0] * x[1].sin()]
    }
}

/// Whether a program is there; without it there is nothing to test.
pub fn is_there(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    if !found {
        println!("there is no `{program}` here");
    }
    found
}

/// A program of one line of a shell.
fn shell(script: &str) -> Pipe {
    Pipe::new(Command::new("sh").args(["-c", script])).expect("a shell")
}

#[test]
fn derivatives_from_python_are_right_or_found_wrong() {
    if !is_there("python3") {
        return;
    }
    let pipe = Pipe::new(Command::new("python3").arg("tests/languages/distance.py")).expect("Python");
    check::constraint(&Distance, B).phi_q(|at| pipe.ask("phi_q", at)).run().assert_passed();
    // One sign is wrong.
    let wrong = |at: &check::Point<6, 1, 0, 5>| {
        let mut phi_q = pipe.ask("phi_q", at);
        phi_q[(0, 2)] *= -1.0;
        phi_q
    };
    let report = check::constraint(&Distance, B).phi_q(wrong).run();
    assert!(!report.passed());
    assert!(report.to_string().contains("sign"), "{report}");
    pipe.finish().expect("answers to all");
    let pipe = Pipe::new(Command::new("python3").arg("tests/languages/distance.py")).expect("Python");
    assert!(!check::constraint(&Distance, B).phi_dot_q(|at| pipe.ask("phi_dot_q", at)).run().passed());
    assert_says(&pipe.finish().expect_err("unknown"), &["question 1", "phi_dot_q", "there is no phi_dot_q"]);
}

#[test]
fn derivatives_from_c_are_right() {
    if !is_there("cc") {
        return;
    }
    let program = std::env::temp_dir().join(format!("polar-{}", std::process::id()));
    let built =
        Command::new("cc").args(["tests/languages/polar.c", "-lm", "-o"]).arg(&program).status().expect("a compiler");
    assert!(built.success());
    let pipe = Pipe::new(&mut Command::new(&program)).expect("the program");
    check::function(&Polar, ["r", "φ"], ["x", "y"]).jacobian(|x| pipe.ask("jacobian", x)).run().assert_passed();
    pipe.finish().expect("answers to all");
    std::fs::remove_file(program).ok();
}

#[test]
fn programs_that_fail_are_told_of() {
    let problem = |pipe: Pipe| {
        let report = check::function(&Polar, ["r", "φ"], ["x", "y"]).jacobian(|x| pipe.ask("jacobian", x)).run();
        assert!(!report.passed());
        pipe.finish().expect_err("no answers")
    };
    assert_says(&problem(shell("read line; exit 3")), &["question 1", "ended with", "3"]);
    assert_says(&problem(shell("while read line; do echo '[[1,2],[3]]'; done")), &["different lengths"]);
    assert_says(&problem(shell("while read line; do echo 'one'; done")), &["`one` is not JSON"]);
    assert_says(&problem(shell("while read line; do echo '[[1,null],[0,1]]'; done")), &["not a matrix of numbers"]);
    assert_says(
        &problem(shell("while read line; do echo '[[1,2],[3,4]]'; echo '[[1,2],[3,4]]'; done")),
        &["one line too many"],
    );
    // Right answers, but one more at the end.
    let pipe = shell("read line; echo '[[1,2],[3,4]]'; sleep 0.2; echo '[[1,2],[3,4]]'; while read line; do echo; done");
    pipe.ask("jacobian", &[1.0, 2.0][..]);
    assert_says(&pipe.finish().expect_err("one more"), &["after 1 questions", "one line too many"]);
    let endless = shell("read line; yes | tr -d '\\n'");
    assert_says(&problem(endless), &["question 1", "more than 10000000 bytes"]);
    assert_says(&Pipe::new(&mut Command::new("no such program")).expect_err("none"), &["does not start"]);
}
