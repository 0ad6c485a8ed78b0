//! Why methods end: at a minimum to rounding, where nothing lower is found, stopped on the way; and what numbers they refuse.

use super::common::assert_says;
use super::{Function, Given, everything_free, problem, push};
use hamiltonian_adjoint::optimize::{
    Free, Interval, Iterate, MotionProblem, Options, Problem, Quantity, Reason, Variables, augmented_lagrangian, homotopy,
    interior_point, lbfgs, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, Sum, Warning};
use std::ops::ControlFlow;

/// (x − 1)² + 10 (y + 2)², and x + y.
fn bowl(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    g[..2].copy_from_slice(&[2.0 * (x[0] - 1.0), 20.0 * (x[1] + 2.0)]);
    if let [sum] = c {
        *sum = x[0] + x[1];
        g[2..].fill(1.0);
    }
    (x[0] - 1.0).powi(2) + 10.0 * (x[1] + 2.0).powi(2)
}

#[test]
fn where_nothing_lower_is_found_need_not_be_a_minimum() {
    let wall: Function = |x, _, g| {
        g[0] = 1.0;
        if x[0] < 0.5 { f64::NAN } else { x[0] }
    };
    let kink: Function = |x, _, g| {
        g[0] = (x[0] - 0.3).signum() + 0.1;
        (x[0] - 0.3).abs() + 0.1 * x[0]
    };
    for function in [wall, kink] {
        for method in [lbfgs, augmented_lagrangian] {
            let mut problem = Given::new(function, vec![Interval::FREE; 2], vec![]);
            let outcome = method(&mut problem, &[4.0, 0.0], &Options::default(), &mut silent).expect("fits");
            assert_eq!(outcome.reason, Reason::NoLowerValue, "{outcome:?}");
        }
    }
}

/// A force of 100 N on steps of 0.2 s, some of which have no solution.
#[test]
fn outcomes_tell_of_halved_steps() {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.cost("angle", AngleError, Sum::Terminal, [cart.links[0].coordinates[2]], [], [], [1.0.into()]);
    let system = cart.scene.compile().expect("scene");
    for (force, is_halved) in [(1.0, false), (100.0, true)] {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.2));
        inputs.controls.fill(force);
        let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force)]).expect("fits");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("fits");
        let (start, options) = (problem.start(), Options { iterations: 0, ..Options::default() });
        for method in [lbfgs, augmented_lagrangian, interior_point] {
            let outcome = method(&mut problem, &start, &options, &mut silent).expect("fits");
            assert_eq!(outcome.warnings, problem.solver.report().warnings);
            let named = outcome.warnings.iter().any(|warning| matches!(warning, Warning::HalvedSteps { .. }));
            assert_eq!((named, outcome.halved > 0), (is_halved, is_halved), "{force} N: {:?}", outcome.warnings);
        }
    }
}

#[test]
fn nothing_is_asked_of_points_that_are_not_finite() {
    // What falls for ever, without a tolerance that would end it, and steps whose squares are beyond the range of numbers.
    let slope: Function = |x, _, g| {
        (g[0], g[1]) = (-1e-200, -1.0);
        -1e-200 * x[0] - x[1]
    };
    let mut all = [1e10, 1e155, 1e300].map(|length| Options { first_step: Some(length), ..Options::default() }).to_vec();
    all.push(Options { stationarity: 0.0, ..Options::default() });
    for (function, options) in [slope, bowl].into_iter().flat_map(|of| all.iter().map(move |options| (of, options))) {
        for method in [lbfgs, augmented_lagrangian, interior_point] {
            // The problem itself refuses what is not finite.
            let mut problem = Given::new(function, vec![Interval::FREE; 2], vec![]);
            let outcome = method(&mut problem, &[4.0, 3.0], options, &mut silent).expect("fits");
            assert!(outcome.x.iter().all(|x| x.is_finite()) && outcome.value.is_finite(), "{outcome:?}");
        }
    }
}

#[test]
fn a_wall_beside_feasible_points_is_not_infeasible() {
    // x + y = 2, and no value beyond x = 0.9; (0.9, 1.1) is feasible.
    let wall: Function = |x, c, g| {
        g.copy_from_slice(&[x[0], x[1], 1.0, 1.0]);
        c[0] = x[0] + x[1] - 2.0;
        if x[0] > 0.9 { f64::NAN } else { 0.5 * (x[0] * x[0] + x[1] * x[1]) }
    };
    for method in [interior_point, augmented_lagrangian] {
        for start in [[0.0, 0.0], [-1.0, 0.5], [0.5, 0.0]] {
            let mut problem = Given::new(wall, vec![Interval::FREE; 2], vec![Interval::ZERO]);
            let outcome = method(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert!(outcome.violation < 1e-9 || outcome.reason == Reason::NoLowerValue, "{outcome:?}");
        }
    }
}

#[test]
fn constraints_beyond_bounds_are_infeasible_whatever_had_no_value_on_the_way() {
    // x ≤ 1 and x = 2; z + 1/z has no value for z ≤ 0, where the first steps lead.
    let beyond: Function = |x, c, g| {
        let z = x[1];
        g.copy_from_slice(&[0.0, 1.0 - 1.0 / (z * z), 1.0, 0.0]);
        c[0] = x[0] - 2.0;
        if z > 0.0 { z + 1.0 / z } else { f64::NAN }
    };
    for method in [interior_point, augmented_lagrangian] {
        let bounds = vec![Interval::new(0.0, 1.0), Interval::FREE];
        let mut problem = Given::new(beyond, bounds, vec![Interval::ZERO]);
        let outcome = method(&mut problem, &[0.5, 10.0], &Options::default(), &mut silent).expect("fits");
        assert!(outcome.failures > 0 && outcome.reason == Reason::Infeasible, "{outcome:?}");
    }
}

#[test]
fn what_falls_without_end_is_unbounded_by_every_method() {
    let slope: Function = |x, _, g| {
        (g[0], g[1]) = (0.0, -1.0);
        -x[1]
    };
    for method in [lbfgs, augmented_lagrangian, interior_point] {
        let mut problem = Given::new(slope, vec![Interval::FREE; 2], vec![]);
        let outcome = method(&mut problem, &[4.0, 3.0], &Options::default(), &mut silent).expect("fits");
        assert_eq!(outcome.reason, Reason::Unbounded, "{outcome:?}");
    }
}

#[test]
fn options_that_mean_nothing_are_refused_by_name() {
    let usual = Options::default;
    let refused = [
        ("stationarity", [-1.0, f64::NAN, f64::INFINITY].map(|stationarity| Options { stationarity, ..usual() }).to_vec()),
        ("violation", [-1e-9, f64::NAN].map(|violation| Options { violation, ..usual() }).to_vec()),
        ("target", vec![Options { target: Some(f64::NAN), ..usual() }]),
        (
            "first_step",
            [0.0, -1.0, f64::NAN, f64::INFINITY].map(|step| Options { first_step: Some(step), ..usual() }).to_vec(),
        ),
    ];
    for (name, options) in refused.iter().flat_map(|(name, of)| of.iter().map(move |options| (name, options))) {
        let (mut free, start) = (Given::new(bowl, vec![Interval::FREE; 2], vec![]), [4.0, 0.0]);
        let errors = [
            lbfgs(&mut free, &start, options, &mut silent).map(drop),
            augmented_lagrangian(&mut free, &start, options, &mut silent).map(drop),
            levenberg_marquardt(&mut free, &start, options, &mut silent).map(drop),
            interior_point(&mut free, &start, options, &mut silent).map(drop),
            homotopy(&mut free, &start, options, &mut |_, _| Ok(()), &mut silent).map(drop),
        ];
        for error in errors {
            assert_says(&error.expect_err(name), &[&format!("`Options::{name}`")]);
        }
    }
}

#[test]
fn bounds_that_rounding_keeps_apart_are_one() {
    let narrow = Interval::new(0.3, 0.1 + 0.2);
    assert!(narrow.least < narrow.most);
    let mut methods: [fn(&mut Given) -> _; 2] = [
        |problem| interior_point(problem, &[9.0; 2], &Options::default(), &mut silent),
        |problem| homotopy(problem, &[9.0; 2], &Options::default(), &mut |_, _| Ok(()), &mut silent),
    ];
    for method in &mut methods {
        let outcome = method(&mut Given::new(bowl, vec![narrow, Interval::FREE], vec![])).expect("fits");
        assert!(outcome.reason.is_converged() && narrow.violation(outcome.x[0]) == 0.0, "{outcome:?}");
        assert!((outcome.x[1] + 2.0).abs() < 1e-6, "{outcome:?}");
        let outcome = method(&mut Given::new(bowl, vec![Interval::FREE; 2], vec![narrow])).expect("fits");
        assert!(outcome.reason.is_converged() && outcome.violation < 1e-9, "{outcome:?}");
        // 2 (x − 1) = 20 (y + 2) with x + y = 0.3.
        assert!((outcome.x[0] - 24.0 / 11.0).abs() < 1e-6, "{outcome:?}");
    }
}

#[test]
fn what_rounding_leaves_of_a_gradient_is_small_enough() {
    let mut within = Given::new(bowl, vec![Interval::FREE, Interval::new(-10.0, 10.0)], vec![]);
    let mut start = vec![5.0; 2];
    for _ in 0..4 {
        let outcome = interior_point(&mut within, &start, &Options::default(), &mut silent).expect("fits");
        assert_eq!(outcome.reason, Reason::Stationary, "{:?}", outcome.history);
        start = outcome.x;
    }
    // A line search sees values alone: what is below rounding of 3 is nothing to it.
    let raised: Function = |x, c, g| 3.0 + bowl(x, c, g);
    for method in [lbfgs, augmented_lagrangian] {
        let exact = Options { stationarity: 1e-15, ..Options::default() };
        let mut problem = Given::new(raised, vec![Interval::FREE; 2], vec![]);
        let outcome = method(&mut problem, &[1.0 + 1e-9, -2.0 - 1e-9], &exact, &mut silent).expect("fits");
        assert_eq!(outcome.reason, Reason::Stationary, "{:?}", outcome.history);
        let last = outcome.history[outcome.history.len() - 1];
        assert!(last.stationarity > 0.0, "else it would be no matter of rounding");
    }
    // Problems that are one and the same, of which each begins where the one before ended.
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.effort("effort", cart.force, 1e-2);
    cart.scene.cost("angle", AngleError, Sum::Terminal, [cart.links[0].coordinates[2]], [], [], [(-1.0).into()]);
    let free = vec![Free::control(cart.force).within(-60.0, 60.0)];
    let system = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let outcome = homotopy(&mut problem, &[1.0; 41], &Options::default(), &mut |_, _| Ok(()), &mut silent).expect("fits");
    assert_eq!(outcome.reason, Reason::Stationary);
}

/// Beside a fold of the motion slopes are of any size, here 1e10: what constraints and gradients are short of there is no rounding of them.
#[test]
fn beside_a_fold_nothing_is_taken_for_rounding() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let trolley = scene.body("trolley", 5.0, 1.0, [0.0, 0.0, 0.0]);
    let load = scene.particle("load", 2.0, [0.0, -1.0]);
    let rail = Body::GROUND.at(0.0, 0.0);
    scene.prismatic("rail", rail, 0.0, trolley.at(0.0, 0.0), 0.0);
    scene.distance("rope", trolley.at(0.0, 0.0), load.point(), 1.0);
    scene.sliding_friction("drag", rail, 0.0, trolley.at(0.0, 0.0), 0.8);
    let force = scene.control("force");
    scene.actuator("drive", rail, 0.0, trolley.at(0.0, 0.0), force);
    scene.time("time", 1.0);
    let ends = [trolley.coordinates[0], load.coordinates[0]].map(|coordinate| scene.end_state(coordinate));
    let system = scene.compile().expect("a system");
    // Steps so long that they have several solutions.
    let steps = (1..=20).map(|node| Free::new(Quantity::StepLength(node)).within(0.03, 0.45));
    let free = Vec::from_iter([Free::control(force).within(-20.0, 20.0).scaled(10.0)].into_iter().chain(steps));
    for (step, push) in [(0.1, 10.0), (0.2, 1.0), (0.2, 5.0), (0.2, 10.0)] {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, step));
        inputs.controls.fill(push);
        let variables = Variables::new(&system, &inputs, free.clone()).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
        for end in &ends {
            problem.constrain(end.position, Interval::equal(2.0));
            problem.constrain(end.rate, Interval::equal(0.0));
        }
        let (start, options) = (problem.start(), Options { stationarity: 1e-5, ..Options::default() });
        let outcome = interior_point(&mut problem, &start, &options, &mut silent).expect("fits");
        let last = outcome.history[outcome.history.len() - 1];
        let is_end = outcome.violation < 1e-9 && last.stationarity < 1e-5;
        assert_eq!(outcome.reason.is_converged(), is_end, "{step} {push}: {:?} {last:?}", outcome.reason);
    }
}

/// Factors of AᵀA + μ I, of rank 1 and with a μ that good steps have made small, are none: more damping is wanted, not an end.
#[test]
fn residuals_that_say_the_same_are_fitted_to_the_end() {
    // s = x + y, and 1 − 0.4 s²: near s = 0 each step leaves 0.8 of it.
    let again: Function = |x, c, g| {
        let s = x[0] + x[1];
        (c[0], c[1]) = (s, 1.0 - 0.4 * s * s);
        g.copy_from_slice(&[0.0, 0.0, 1.0, 1.0, -0.8 * s, -0.8 * s]);
        0.0
    };
    let mut problem = Given::new(again, vec![Interval::FREE; 2], vec![Interval::ZERO; 2]);
    let fit = levenberg_marquardt(&mut problem, &[0.3, 0.2], &Options::default(), &mut silent).expect("fits");
    assert_eq!(fit.outcome.reason, Reason::Stationary, "{:?}", fit.outcome);
    assert!((fit.outcome.x[0] + fit.outcome.x[1]).abs() < 1e-6 && fit.standard_errors().is_none(), "{:?}", fit.outcome);
}

/// A variable in small units has small derivatives: beside those of another, at the start, these were nothing, and it was left where it was.
#[test]
fn a_fit_is_the_same_in_any_units_of_its_variables() {
    fn plane(x: &[f64], c: &mut [f64], g: &mut [f64], [a, b]: [f64; 2]) -> f64 {
        c.copy_from_slice(&[a * x[0] - 1.0, b * x[1] - 2.0, a * x[0] + b * x[1] - 3.1]);
        g.copy_from_slice(&[0.0, 0.0, a, 0.0, 0.0, b, a, b]);
        0.0
    }
    let functions: [(Function, [f64; 2]); 3] = [
        (|x, c, g| plane(x, c, g, [1.0, 1.0]), [1.0, 1.0]),
        (|x, c, g| plane(x, c, g, [1e4, 1e-4]), [1e4, 1e-4]),
        (|x, c, g| plane(x, c, g, [1e-3, 1e3]), [1e-3, 1e3]),
    ];
    for (function, units) in functions {
        let mut problem = Given::new(function, vec![Interval::FREE; 2], vec![Interval::ZERO; 3]);
        let fit = levenberg_marquardt(&mut problem, &[0.0, 0.0], &Options::default(), &mut silent).expect("fits");
        let found = [fit.outcome.x[0] * units[0], fit.outcome.x[1] * units[1]];
        assert_eq!(fit.outcome.reason, Reason::Stationary);
        assert!((found[0] - 31.0 / 30.0).abs() < 1e-6 && (found[1] - 61.0 / 30.0).abs() < 1e-6, "{units:?} {found:?}");
    }
}

#[test]
fn a_fit_from_its_own_end_is_at_its_end() {
    let curve: Function = |x, c, g| {
        let readings = [2.1, 1.1, 0.8, 0.35, 0.3];
        for (k, (c, reading)) in c.iter_mut().zip(readings).enumerate() {
            let e = (-x[1] * k as f64).exp();
            *c = x[0] * e - reading;
            g[2 + 2 * k..4 + 2 * k].copy_from_slice(&[e, -x[0] * k as f64 * e]);
        }
        0.0
    };
    let mut problem = Given::new(curve, vec![Interval::FREE; 2], vec![Interval::ZERO; 5]);
    let mut start = vec![1.0, 1.0];
    for _ in 0..4 {
        let fit = levenberg_marquardt(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        assert_eq!(fit.outcome.reason, Reason::Stationary, "{:?}", fit.outcome);
        start = fit.outcome.x;
    }
    // A wall is none.
    let wall: Function = |x, c, g| {
        c[0] = if x[0] < 0.5 { f64::NAN } else { x[0] };
        g[1] = 1.0;
        0.0
    };
    let mut problem = Given::new(wall, vec![Interval::FREE], vec![Interval::ZERO]);
    let fit = levenberg_marquardt(&mut problem, &[4.0], &Options::default(), &mut silent).expect("fits");
    assert_eq!(fit.outcome.reason, Reason::NoLowerValue, "{:?}", fit.outcome);
}

/// Less than rounding cannot be asked for, and is not to be told of as if there were no point where constraints hold.
#[test]
fn constraints_that_hold_to_rounding_are_not_infeasible() {
    // The least ‖x‖² with 1e8 (x + 3 y − 0.7 z) = 1e7 and x y ≤ −1e-3 in the same unit: sums of terms of 1e7.
    let large: Function = |x, c, g| {
        (c[0], c[1]) = (1e8 * (x[0] + 3.0 * x[1] - 0.7 * x[2]) - 1e7, 1e8 * x[0] * x[1]);
        g[..3].copy_from_slice(&[2.0 * x[0], 2.0 * x[1], 2.0 * x[2]]);
        g[3..].copy_from_slice(&[1e8, 3e8, -0.7e8, 1e8 * x[1], 1e8 * x[0], 0.0]);
        x.iter().map(|x| x * x).sum()
    };
    for violation in [1e-9, 0.0] {
        for start in [[1.0, 2.0, 3.0], [-0.3, 0.1, 0.7], [5.0, -4.0, 0.3]] {
            let options = Options { violation, ..Options::default() };
            let constraints = vec![Interval::ZERO, Interval::at_most(-1e5)];
            let mut problem = Given::new(large, vec![Interval::FREE; 3], constraints);
            let outcome = interior_point(&mut problem, &start, &options, &mut silent).expect("fits");
            assert!(outcome.reason.is_converged() && outcome.violation < 1e-7, "{violation:e} {start:?}: {outcome:?}");
        }
    }
    // And x + y = 0.3.
    for start in [[9.0, 9.0], [1.0, 0.1], [-0.7, 3.0]] {
        let mut problem = Given::new(bowl, vec![Interval::FREE; 2], vec![Interval::equal(0.3)]);
        let options = Options { violation: 0.0, ..Options::default() };
        for method in [interior_point, augmented_lagrangian] {
            let outcome = method(&mut problem, &start, &options, &mut silent).expect("fits");
            assert!(outcome.reason != Reason::Infeasible && outcome.violation < 1e-14, "{start:?}: {outcome:?}");
        }
    }
}

#[test]
fn a_homotopy_that_is_stopped_keeps_the_motion_of_its_answer() {
    let (system, force) = push(false);
    let mut problem = problem(&system, force, Inputs::at_rest(&system, Grid::uniform(20, 0.1)));
    let start = problem.start();
    let mut set = |problem: &mut MotionProblem, s: f64| problem.change(|inputs| inputs.grid.steps.fill((2.0 - s) / 20.0));
    let mut stopped = 0;
    loop {
        let mut left = stopped;
        let mut watch = |_: &Iterate, _: &[f64]| {
            left -= 1;
            if left < 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let outcome = homotopy(&mut problem, &start, &Options::default(), &mut set, &mut watch).expect("fits");
        assert_eq!(problem.solver.cost().expect("a motion"), outcome.value, "after {stopped} iterates");
        if outcome.reason != Reason::Interrupted {
            break;
        }
        stopped += 1;
    }
    assert!(stopped > 10, "{stopped}");
}

#[test]
fn what_is_not_finite_is_named() {
    let lost: Function = |_, c, g| {
        c[1] = f64::NAN;
        g.fill(0.0);
        3.0
    };
    let mut problem = Given::new(lost, vec![Interval::FREE], vec![Interval::ZERO; 2]);
    let outcome = augmented_lagrangian(&mut problem, &[0.0], &Options::default(), &mut silent).expect("an outcome");
    assert_says(&outcome.first_failure.expect("no number"), &["constraint 1 is NaN"]);
}

#[test]
fn without_variables_there_is_nothing_to_be_uncertain_of() {
    let given: Function = |_, c, _| {
        c.fill(1.0);
        0.0
    };
    let mut problem = Given::new(given, vec![], vec![Interval::ZERO; 2]);
    let fit = levenberg_marquardt(&mut problem, &[], &Options::default(), &mut silent).expect("fits");
    assert_eq!((fit.standard_errors(), fit.covariance().map(|c| c.shape())), (Some(vec![]), Some((0, 0))));
}

#[test]
fn inputs_that_no_variables_give_are_no_change() {
    let (system, inputs, free) = everything_free();
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let start = problem.start();
    let error = problem.change(|inputs| inputs.design[0] = -1.0).expect_err("no logarithm");
    assert_says(&error, &["stiffness", "NaN"]);
    let to_and_fro = [0.1, -0.1, 0.1, -0.1, 0.1, -0.2, 0.1];
    let error = problem.change(|inputs| inputs.grid.steps.copy_from_slice(&to_and_fro)).expect_err("no duration");
    assert_says(&error, &["duration", "not zero"]);
    assert_eq!(problem.start(), start);
    assert!(problem.inputs_at(&start).grid.steps.iter().all(|dt| *dt > 0.0), "nothing is changed");
    let mut c = vec![0.0; problem.constraints().len()];
    assert!(problem.evaluate(&start, &mut c).is_ok());
}

/// Homotopies change a problem at every start: what they find may not depend on how many starts there were before.
#[test]
fn changes_that_leave_the_steps_leave_their_shares() {
    let (system, mut inputs, _) = everything_free();
    inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= 1.0 + 0.1 * (i as f64).sin());
    let variables = Variables::new(&system, &inputs, vec![Free::duration()]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let steps = problem.inputs_at(&[0.5]).grid.steps;
    let mut c = vec![0.0; problem.constraints().len()];
    for k in 1..100 {
        problem.evaluate(&[0.01 * f64::from(k)], &mut c).expect("a motion");
        problem.change(|_| ()).expect("no change");
        assert_eq!(problem.inputs_at(&[0.5]).grid.steps, steps, "{k}");
    }
}

#[test]
fn variables_of_any_size_are_not_at_a_minimum_before_they_are() {
    // x − g is x itself long before g is nothing.
    let far: Function = |x, c, g| {
        c.fill(1e-8 * x[0] - 1.0);
        g.fill(0.0);
        g[0] = 2e-8 * (1e-8 * x[0] - 1.0);
        (1e-8 * x[0] - 1.0).powi(2)
    };
    let outcome = lbfgs(&mut Given::new(far, vec![Interval::FREE], vec![]), &[5e7], &Options::default(), &mut silent);
    let outcome = outcome.expect("fits");
    assert!(outcome.reason.is_converged() && (outcome.x[0] - 1e8).abs() < 1e2, "{outcome:?}");
    // And with what is known of them it is told how well: their units are no lack of it.
    let units: Function = |x, c, g| {
        let sums = [1e-8 * x[0] + 1e8 * x[1], 1e-8 * x[0] - 1e8 * x[1], 1e-8 * x[0]];
        c.iter_mut().zip(sums).zip([1.1, 1.0, 0.9]).for_each(|((c, sum), of)| *c = sum - of);
        g.copy_from_slice(&[0.0, 0.0, 1e-8, 1e8, 1e-8, -1e8, 1e-8, 0.0]);
        0.0
    };
    let mut problem = Given::new(units, vec![Interval::FREE; 2], vec![Interval::ZERO; 3]);
    let fit = levenberg_marquardt(&mut problem, &[1e8, 5e-10], &Options::default(), &mut silent).expect("fits");
    let [x, y] = fit.standard_errors().expect("three residuals determine two variables")[..] else { panic!("two") };
    let noise = (2.0 * fit.outcome.value).sqrt();
    assert!((1e-8 * x / noise - 3f64.sqrt().recip()).abs() < 1e-6 && (1e8 * y / noise - 2f64.sqrt().recip()).abs() < 1e-6);
}

#[test]
fn a_homotopy_tells_of_the_first_failure_on_its_way() {
    // √x has no value beyond 0, where the first steps lead; from where that ends there is no more failure.
    let edge: Function = |x, _, g| {
        g[0] = 1.0 - 0.5 / x[0].sqrt();
        x[0] - x[0].sqrt()
    };
    let options = Options { first_step: Some(100.0), ..Options::default() };
    let mut problem = Given::new(edge, vec![Interval::FREE], vec![]);
    let outcome = homotopy(&mut problem, &[4.0], &options, &mut |_, _| Ok(()), &mut silent).expect("fits");
    assert!(outcome.reason.is_converged() && outcome.failures > 0, "{outcome:?}");
    assert_says(&outcome.first_failure.expect("one of the failures"), &["cost", "NaN"]);
}

#[test]
fn knots_between_nodes_begin_like_the_knot_before() {
    let scene = CartPendulum::default().scene();
    let force = scene.control_named("force on the cart").expect("its control");
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, vec![0.01, 0.01, 0.01, 0.01, 0.2]));
    inputs.controls.fill(5.0);
    for quantity in
        [Quantity::PiecewiseControl(force, 5), Quantity::LinearControl(force, 5), Quantity::SplineControl(force, 5)]
    {
        for free in [Free::new(quantity.clone()), Free::new(quantity).logarithmic()] {
            let expected = if free.logarithm { 5f64.ln() } else { 5.0 };
            let variables = Variables::new(&system, &inputs, vec![free.within(1.0, 10.0)]).expect("variables");
            assert_eq!(variables.of(&inputs), [expected; 5]);
        }
    }
}

#[test]
fn residuals_are_asked_for_where_there_are_none() {
    let mut problem = Given::new(bowl, vec![Interval::FREE; 2], vec![]);
    let error =
        levenberg_marquardt(&mut problem, &[4.0, 0.0], &Options::default(), &mut silent).expect_err("nothing to fit");
    assert_says(&error, &["residuals", "0", "at least 1", "`lbfgs`"]);
}

#[test]
fn a_homotopy_begins_inside_bounds_where_the_cost_has_no_value() {
    // x − ln x, from 0.
    let barrier: Function = |x, _, g| {
        g[0] = 1.0 - 1.0 / x[0];
        x[0] - x[0].ln()
    };
    let mut problem = Given::new(barrier, vec![Interval::at_least(0.0)], vec![]);
    let outcome = homotopy(&mut problem, &[0.0], &Options::default(), &mut |_, _| Ok(()), &mut silent).expect("fits");
    assert!(outcome.reason.is_converged() && (outcome.x[0] - 1.0).abs() < 1e-5, "{outcome:?}");
}

#[test]
fn variables_belong_to_inputs_with_as_many_nodes() {
    let (system, force) = push(false);
    let [long, short] = [40, 20].map(|steps| Inputs::at_rest(&system, Grid::uniform(steps, 0.1)));
    let variables = Variables::new(&system, &long, vec![Free::control(force)]).expect("free");
    let error = MotionProblem::new(&system, Settings::default(), short, variables).expect_err("other nodes");
    assert_says(&error, &["nodes", "expected 41", "found 21"]);
    // The same nodes at other times are those times.
    let variables = Variables::new(&system, &long, vec![Free::duration()]).expect("free");
    let mut uneven = long.clone();
    uneven.grid.steps[0] = 0.3;
    let problem = MotionProblem::new(&system, Settings::default(), uneven.clone(), variables).expect("a problem");
    let kept = problem.inputs_at(&problem.start());
    assert!(kept.grid.steps.iter().zip(&uneven.grid.steps).all(|(dt, of)| (dt - of).abs() < 1e-14));
}

/// The first step was as long as the value told, and so none where that was rounding.
#[test]
fn a_value_that_is_rounding_tells_no_length() {
    let through_zero: Function = |x, c, g| {
        c.fill(0.0);
        g[0] = 1.0 + 100.0 * (x[0] - 1.0);
        5e-17 + (x[0] - 1.0) + 50.0 * (x[0] - 1.0).powi(2)
    };
    let mut problem = Given::new(through_zero, vec![Interval::FREE], vec![]);
    let outcome = lbfgs(&mut problem, &[1.0], &Options::default(), &mut silent).expect("fits");
    assert!(outcome.reason.is_converged() && (outcome.x[0] - 0.99).abs() < 1e-7, "{:?} {:?}", outcome.reason, outcome.x);
}

/// A first step that leads nowhere left the method where it was, and penalties grew until constraints were said to hold nowhere.
#[test]
fn first_steps_of_any_length_lead_to_where_constraints_hold() {
    let product: Function = |x, c, g| {
        c[0] = x[0] * x[1] - 1.0;
        g.copy_from_slice(&[2.0 * x[0], 2.0 * x[1], x[1], x[0]]);
        x[0] * x[0] + x[1] * x[1]
    };
    for length in [1e-300, 1e-20, 1e-12, 1e12, 1e100, 1e155, 1e300] {
        let options = Options { first_step: Some(length), ..Options::default() };
        for (method, tolerance) in
            [(augmented_lagrangian as fn(&mut dyn Problem, &[f64], &_, &mut _) -> _, 1e-6), (interior_point, 1e-6)]
        {
            for (function, expected) in [(product, [1.0, 1.0]), (bowl as Function, [1.0 + 10.0 / 11.0, -2.0 + 1.0 / 11.0])] {
                let mut problem = Given::new(function, vec![Interval::FREE; 2], vec![Interval::ZERO]);
                let outcome = method(&mut problem, &[4.0, 1.0], &options, &mut silent).expect("fits");
                let is_there = outcome.x.iter().zip(expected).all(|(x, of)| (x - of).abs() < tolerance);
                assert!(outcome.reason.is_converged() && is_there, "{length:e}: {outcome:?}");
            }
        }
        let mut problem = Given::new(bowl, vec![Interval::FREE; 2], vec![]);
        let outcome = lbfgs(&mut problem, &[4.0, 0.0], &options, &mut silent).expect("fits");
        assert!(outcome.reason.is_converged() && (outcome.x[0] - 1.0).abs() < 1e-5, "{length:e}: {outcome:?}");
    }
}
