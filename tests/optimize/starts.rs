//! Starts that cannot be simulated, what outcomes and fits print, and extremes of scales and options.

use super::{Function, Given, Method, problem, shooting};
use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, MultipleShooting, Options, Outcome, Quantity, Reason, Trials, Variables,
    augmented_lagrangian, homotopy, interior_point, lbfgs, levenberg_marquardt, lowest, multi_start, silent,
};
use hamiltonian_adjoint::{Control, Error, Grid, Inputs, Output, Scene, Settings, System, planar::Body};

/// A cart on a spring that a force pushes by the least effort, and its place at the end less 1.2 m.
fn cart() -> (System, Control, Output) {
    let mut scene = Scene::new();
    let cart = scene.body("cart", 1.0, 0.1, [1.0, 0.0, 0.0]);
    scene.spring_damper("spring", Body::GROUND.at(-5.0, 0.0), cart.at(0.0, 0.0), 20.0, 6.0, 0.1);
    let push = scene.control("push");
    scene.actuator("motor", Body::GROUND.at(-5.0, 0.0), 0.0, cart.at(0.0, 0.0), push);
    scene.effort("effort", push, 1e-3);
    let place = scene.reading("place", cart.coordinates[0], 20, 1.2, 1.0);
    (scene.compile().expect("a scene"), push, place)
}

fn grid() -> Grid {
    Grid::uniform(20, 0.05)
}

fn assert_contains(text: &str, words: &[&str]) {
    println!("{text}");
    words.iter().for_each(|word| assert!(text.contains(word), "`{word}` is not in: {text}"));
}

/// Every method of this module, with what it asks of its constraints.
fn methods() -> [(&'static str, Method, Interval); 5] {
    [
        ("L-BFGS", |problem, start, options, watch| lbfgs(problem, start, options, watch), Interval::FREE),
        ("augmented Lagrangian", augmented_lagrangian, Interval::ZERO),
        ("interior point", interior_point, Interval::ZERO),
        ("interior point, inequalities", interior_point, Interval::at_most(0.0)),
        (
            "Levenberg-Marquardt",
            |problem, start, options, watch| levenberg_marquardt(problem, start, options, watch).map(|fit| fit.outcome),
            Interval::ZERO,
        ),
    ]
}

fn assert_is_no_start(name: &str, outcome: &Outcome, start: &[f64]) {
    assert_eq!((outcome.reason, outcome.iterations, outcome.history.len()), (Reason::NoStart, 0, 1), "{name}: {outcome:?}");
    assert_eq!(outcome.x, start, "{name}");
    assert!(!outcome.reason.is_converged() && outcome.value == f64::INFINITY && outcome.failures > 0, "{name}: {outcome:?}");
    let error = outcome.first_failure.as_ref().expect("why");
    assert_contains(
        &outcome.to_string(),
        &["the value or a derivative at the start could not be computed", &error.to_string()],
    );
}

/// A start that could not be simulated was an error of Levenberg–Marquardt and the others; trials were not.
#[test]
fn a_start_that_cannot_be_simulated_is_an_outcome_of_every_method() {
    let (system, force, place) = cart();
    let inputs = Inputs::at_rest(&system, grid());
    let start = vec![1e308; 21];
    for (name, method, to) in methods() {
        let mut motion = problem(&system, force, inputs.clone());
        motion.constrain(place, to);
        let outcome = method(&mut motion, &start, &Options::default(), &mut silent).expect("an outcome");
        assert_is_no_start(name, &outcome, &start);
    }
    let mut motion = problem(&system, force, inputs.clone());
    let found = homotopy(&mut motion, &start, &Options::default(), &mut |_, _| Ok(()), &mut silent);
    assert_is_no_start("homotopy", &found.expect("an outcome"), &start);
    let mut trials = Trials::new(vec![motion]).expect("trials");
    let fit = levenberg_marquardt(&mut trials, &start, &Options::default(), &mut silent).expect("a fit");
    assert_is_no_start("trials", &fit.outcome, &start);
    assert_eq!((fit.covariance(), fit.undetermined().len()), (None, 21));
    // Of many starts the others count.
    let method =
        |problem: &mut MotionProblem, start: &[f64]| interior_point(problem, start, &Options::default(), &mut silent);
    let make = || Ok(problem(&system, force, inputs.clone()));
    let outcomes = multi_start(&[start.clone(), vec![1.0; 21]], make, method);
    assert_is_no_start("the first of two", outcomes[0].as_ref().expect("an outcome"), &start);
    assert!(lowest(&outcomes, f64::INFINITY).expect("the other").reason.is_converged());
    assert!(lowest(&outcomes[..1], f64::INFINITY).is_none());
    let (system, force, _, states) = shooting::push();
    let inputs = Inputs::at_rest(&system, Grid::uniform(6, 0.1));
    let mut segments =
        MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 2).expect("fits");
    let mut start = segments.start();
    start[0] = 1e308;
    let outcome = interior_point(&mut segments, &start, &Options::default(), &mut silent).expect("an outcome");
    assert_is_no_start("segments", &outcome, &start);
}

#[test]
fn iterations_are_counted_by_every_method() {
    let (system, force, place) = cart();
    for (name, method, to) in methods() {
        let mut motion = problem(&system, force, Inputs::at_rest(&system, grid()));
        motion.constrain(place, to);
        let outcome = method(&mut motion, &[1.0; 21], &Options::default(), &mut silent).expect("fits");
        assert!(outcome.reason.is_converged() && outcome.iterations > 0, "{name}: {outcome:?}");
        assert_eq!(outcome.iterations, outcome.history.len() - 1, "{name}");
        assert_contains(&outcome.to_string(), &[&format!("after {} iterations", outcome.iterations), "largest violation"]);
    }
    let mut motion = problem(&system, force, Inputs::at_rest(&system, grid()));
    let mut set = |_: &mut MotionProblem, _: f64| Ok(());
    let whole = homotopy(&mut motion, &[1.0; 21], &Options::default(), &mut set, &mut silent).expect("fits");
    // Each problem has its start in the history.
    assert!(whole.iterations > 0 && whole.iterations < whole.history.len() - 1, "{whole:?}");
    // Iterations towards constraints alone count, too: x = 1 and x = 2.
    let contradiction: Function = |x, c, g| {
        (c[0], c[1]) = (x[0] - 1.0, x[0] - 2.0);
        g.copy_from_slice(&[2.0 * x[0], 1.0, 1.0]);
        x[0] * x[0]
    };
    for method in [augmented_lagrangian as Method, interior_point] {
        let mut problem = Given::new(contradiction, vec![Interval::FREE], vec![Interval::ZERO; 2]);
        let outcome = method(&mut problem, &[0.0], &Options::default(), &mut silent).expect("fits");
        assert!(outcome.iterations >= outcome.history.len() - 1, "{outcome:?}");
        let limited = Options { iterations: outcome.iterations / 2, ..Options::default() };
        let less = method(&mut problem, &[0.0], &limited, &mut silent).expect("fits");
        assert!(less.iterations <= limited.iterations, "{} of {}", less.iterations, limited.iterations);
    }
}

/// It ended stationary and looked like success: ½‖r‖² = 1e3 says nothing without the number of readings.
#[test]
fn a_fit_tells_how_well_it_fits() {
    // A line through three points of a parabola, in units of 0.01, and one reading of nothing.
    let line: Function = |x, c, g| {
        g.fill(0.0);
        for k in 0..3 {
            let t = k as f64;
            c[k] = (x[0] + x[1] * t - t * t) / 0.01;
            (g[2 * (k + 1)], g[2 * (k + 1) + 1]) = (100.0, 100.0 * t);
        }
        c[3] = x[0];
        g[8] = 1.0;
        0.0
    };
    let constraints = vec![Interval::ZERO, Interval::ZERO, Interval::ZERO, Interval::FREE];
    let mut problem = Given::new(line, vec![Interval::FREE; 2], constraints);
    let exact = Options { stationarity: 1e-12, ..Options::default() };
    let fit = levenberg_marquardt(&mut problem, &[0.0; 2], &exact, &mut silent).expect("fits");
    // −1/3 + 2 t: off by −1/3, 2/3, −1/3.
    assert_eq!((fit.outcome.reason, fit.degrees_of_freedom()), (Reason::Stationary, 1));
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-7, "{found} is not {expected}");
    near(fit.chi_squared(), 1e4 * 6.0 / 9.0);
    near(fit.chi_squared(), 2.0 * fit.outcome.value);
    near(fit.root_mean_square(), 100.0 * (2.0f64 / 9.0).sqrt());
    near(fit.root_mean_square_of(&[1]), 200.0 / 3.0);
    near(fit.root_mean_square_of(&[0, 2]), 100.0 / 3.0);
    let text = fit.to_string();
    assert_contains(&text, &["χ²", "with 1 degree of freedom", "root mean square", "after"]);
}

/// What is beyond the range of numbers is refused, or told of, or done right; never called a minimum.
#[test]
fn scales_of_any_size_are_refused_or_right() {
    let usual = [1.0, 1.0, 1e100, 1e-100, 1e150, 1e-150, 1e200, 1e-200, 1e300, 1e-300, 1e-308];
    let beyond = [1e-312, 5e-324, f64::MIN_POSITIVE, f64::MAX, 0.0, -0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let (system, push, place) = cart();
    let mut inputs = Inputs::at_rest(&system, grid());
    inputs.controls.fill(1.0);
    let mut of_scale_1 = std::collections::HashMap::new();
    let all = [Interval::FREE, Interval::new(-50.0, 50.0), Interval::new(-1e-320, 1e-300), Interval::at_least(0.0)];
    for (scale, bounds) in [&usual[..], &beyond].concat().into_iter().flat_map(|scale| all.map(|bounds| (scale, bounds))) {
        let free = Free { bounds, ..Free::new(Quantity::LinearControl(push, 3)).scaled(scale) };
        let variables = match Variables::new(&system, &inputs, vec![free]) {
            Ok(variables) => variables,
            Err(error) => {
                assert!(matches!(error, Error::Parameter { .. } | Error::NotFinite { .. }), "{error:?}");
                assert!(usual[..10].iter().all(|usual| *usual != scale), "{scale:e}: {error}");
                continue;
            }
        };
        for (name, method, to) in methods() {
            let mut problem =
                MotionProblem::new(&system, Settings::default(), inputs.clone(), variables.clone()).expect("a problem");
            problem.constrain(place, to);
            let start = problem.start();
            let outcome = method(&mut problem, &start, &Options::default(), &mut silent).expect("an outcome");
            println!("{scale:e} {bounds:?} {name}: {outcome}");
            let is_fit = name.starts_with("Leven");
            let expected = of_scale_1.get(&format!("{bounds:?} {to:?}")).filter(|_| !is_fit).copied();
            let is_right = expected.is_none_or(|of: f64| (outcome.value - of).abs() < 1e-7);
            assert!(!outcome.reason.is_converged() || is_right, "{scale:e} {bounds:?} {name}: {outcome}, not {expected:?}");
            if scale == 1.0 && name.starts_with("interior") && outcome.reason.is_converged() {
                of_scale_1.insert(format!("{bounds:?} {to:?}"), outcome.value);
            }
            if outcome.reason == Reason::NoStart {
                assert!(
                    bounds.most == 1e-300 || !(1e-150..=1e150).contains(&scale),
                    "{scale:e} {bounds:?} {name}: {outcome}"
                );
            }
        }
    }
}

#[test]
fn options_of_any_size_do_no_harm() {
    let bowl: Function = |x, c, g| {
        c[0] = x[0] + x[1] - 1.0;
        g.copy_from_slice(&[x[0], 4.0 * x[1], 1.0, 1.0]);
        0.5 * (x[0] * x[0] + 4.0 * x[1] * x[1])
    };
    let usual = Options::default();
    let sizes = [0.0, 5e-324, 1e-320, 1e-300, 1e-12, 1.0, 1e300, f64::MAX];
    let all = sizes.iter().flat_map(|&size| {
        [
            Options { stationarity: size, ..usual },
            Options { violation: size, ..usual },
            Options { target: Some(size), ..usual },
            Options { first_step: Some(size.max(5e-324)), ..usual },
        ]
    });
    let counts = [0, 1, usize::MAX].into_iter().flat_map(|count| {
        [
            Options { iterations: count, ..usual },
            Options { memory: count, ..usual },
            Options { violation: f64::INFINITY, ..usual },
        ]
    });
    for options in all.chain(counts) {
        for (name, method, to) in methods() {
            let mut problem = Given::new(bowl, vec![Interval::FREE, Interval::new(-1e300, 1e-3)], vec![to]);
            let outcome = method(&mut problem, &[3.0, -2.0], &options, &mut silent).expect("an outcome");
            assert!(outcome.x.iter().all(|x| x.is_finite()), "{name} {options:?}: {outcome:?}");
            assert!(outcome.iterations <= options.iterations, "{name} {options:?}: {outcome:?}");
            let holds = outcome.violation <= options.violation.max(1e-9);
            assert!(!outcome.reason.is_converged() || holds || name.starts_with("Leven"), "{name} {options:?}: {outcome:?}");
            assert!(outcome.reason != Reason::Infeasible, "{name} {options:?}: {outcome:?}");
        }
    }
}
