//! Minima of the continuous motion: schemes of higher order, and warnings of what deviates.

use super::solve::{OPTIONS, upright};
use hamiltonian_adjoint::optimize::{Guess, MotionProblem, Outcome, Problem, Solved, silent, solve};
use hamiltonian_adjoint::{Error, Inputs, Scheme, Settings, Solver, Warning};

/// The same inputs with each step divided into so many parts.
pub fn divided(inputs: &Inputs, parts: usize) -> Inputs {
    let mut finer = inputs.clone();
    finer.grid.steps = inputs.grid.steps.iter().flat_map(|h| vec![h / parts as f64; parts]).collect();
    finer.controls = nalgebra::DMatrix::from_fn(inputs.controls.nrows(), finer.grid.nodes(), |i, k| {
        let (step, share) = (k / parts, (k % parts) as f64 / parts as f64);
        let u = |node: usize| inputs.controls[(i, node.min(inputs.grid.steps.len()))];
        (1.0 - share) * u(step) + share * u(step + 1)
    });
    finer
}

/// The largest deviation of the constrained outputs and of J if another scheme simulates the same inputs with steps halved.
pub fn deviation(problem: &MotionProblem, found: &Outcome) -> f64 {
    let finer = divided(&problem.inputs_at(&found.x), 2);
    let mut solver = Solver::new(problem.solver.system(), Settings { scheme: Scheme::ESDIRK5, ..Settings::default() });
    solver.simulate(&finer).expect("a motion");
    let outputs = solver.outputs().expect("outputs");
    let of = |k: &usize| problem.constraints()[*k] != hamiltonian_adjoint::optimize::Interval::FREE;
    let far = (0..outputs.len())
        .filter(of)
        .map(|k| (outputs[k] - found.constraints[k]).abs() / found.constraints[k].abs().max(1.0));
    far.fold((solver.cost().expect("a cost") / found.value - 1.0).abs(), f64::max)
}

fn inaccurate(found: &Outcome) -> Option<&Warning> {
    found.warnings.iter().find(|warning| matches!(warning, Warning::Inaccurate { .. }))
}

fn assert_accurate(problem: &mut MotionProblem, accuracy: f64) -> Solved {
    let found = solve(problem, Guess::Straight.accurate_to(accuracy), &OPTIONS, &mut silent).expect("fits");
    println!("{found}");
    let far = deviation(problem, &found.outcome);
    assert!(found.outcome.reason.is_converged() && found.outcome.violation < 1e-8, "{}", found.outcome);
    assert!(inaccurate(&found.outcome).is_none() && far < 2.0 * accuracy, "{far:.1e}");
    assert_eq!(problem.start(), found.outcome.x);
    found
}

#[test]
fn steps_that_are_too_long_are_warned_of() {
    let mut problem = upright(3, 0.0);
    let solved = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits");
    println!("{solved}");
    let (printed, found) = (solved.to_string(), solved.outcome);
    let far = deviation(&problem, &found);
    let warning = inaccurate(&found).expect("a warning");
    assert!(printed.contains(&format!("warning: {warning}")), "{printed}");
    assert!(far > 1.0 && warning.to_string().contains("require an accuracy"), "{far}");
    // With one link, the trapezoidal rule is good enough.
    let mut problem = upright(1, 0.0);
    let found = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits").outcome;
    assert!(inaccurate(&found).is_none() && deviation(&problem, &found) < 0.02);
}

#[test]
fn minima_become_accurate() {
    let rough = solve(&mut upright(1, 0.0), Guess::Straight, &OPTIONS, &mut silent).expect("fits").outcome;
    let fine = assert_accurate(&mut upright(1, 0.0), 1e-4);
    // From the states of the rough minimum, a few iterations lead to the accurate one.
    let [first, second] = &fine.attempts[..] else { panic!("{fine}") };
    assert!(second.what == "by ESDIRK4" && second.iterations < 10 && (first.value - rough.value).abs() < 1e-9, "{fine}");
    assert_eq!(fine.outcome.x.len(), rough.x.len());
    assert!(fine.outcome.iterations == first.iterations + second.iterations);
    let finest = assert_accurate(&mut upright(1, 0.0), 1e-5);
    // Some steps are halved.
    assert!(finest.attempts.last().expect("several").what.ends_with("steps"), "{finest}");
    assert!((102..=201).contains(&finest.outcome.x.len()), "{finest}");
    assert!((finest.outcome.value - fine.outcome.value).abs() < 1e-4 * fine.outcome.value);
    // Three links need shorter steps, too.
    let mut problem = upright(3, 0.0);
    let found = assert_accurate(&mut problem, 1e-2);
    let last = found.attempts.last().expect("several");
    assert!(last.what.ends_with("steps") && last.iterations < 10 && problem.start().len() > 201, "{found}");
}

#[test]
fn an_accuracy_is_positive() {
    for accuracy in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error =
            solve(&mut upright(1, 0.0), Guess::Straight.accurate_to(accuracy), &OPTIONS, &mut silent).expect_err("none");
        assert!(matches!(&error, Error::Parameter { what, .. } if what.contains("accuracy")), "{error}");
    }
}
