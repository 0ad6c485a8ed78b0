//! Reasons to stop that are true: minima from steep starts, and constraints without multipliers.

use super::{Function, Given};
use hamiltonian_adjoint::optimize::{
    Free, Guess, Interval, MotionProblem, Options, Problem, Reason, Variables, augmented_lagrangian, interior_point, silent,
    solve,
};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Grid, Inputs, Settings, Sum};
use std::f64::consts::FRAC_PI_2;

/// cosh(x − 1) + (y + 2)², least at (1, −2).
fn steep(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
    g.copy_from_slice(&[(x[0] - 1.0).sinh(), 2.0 * (x[1] + 2.0)]);
    (x[0] - 1.0).cosh() + (x[1] + 2.0).powi(2)
}

/// 100 (y − x²)² + (1 − x)², least at (1, 1).
fn valley(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
    let (a, b) = (x[1] - x[0] * x[0], 1.0 - x[0]);
    g.copy_from_slice(&[-400.0 * a * x[0] - 2.0 * b, 200.0 * a]);
    100.0 * a * a + b * b
}

/// A gradient of 1e9 at the start, or of 1e35, does not make another one of 1e2, or of 1e28, small.
#[test]
fn a_minimum_does_not_depend_on_the_slope_at_the_start() {
    for (function, least) in [(steep as Function, [1.0, -2.0]), (valley, [1.0, 1.0])] {
        for bound in [Interval::FREE, Interval::at_least(-5.0)] {
            for from in [1.5, 10.0, 30.0, 100.0] {
                let mut problem = Given::new(function, vec![bound; 2], vec![]);
                let outcome = interior_point(&mut problem, &[from; 2], &Options::default(), &mut silent).expect("fits");
                assert_eq!(outcome.reason, Reason::Stationary, "{from}: {outcome}");
                let far = outcome.x.iter().zip(least).any(|(x, of)| (x - of).abs() > 1e-5);
                assert!(!far, "{from}: {:?} is not {least:?}", outcome.x);
            }
        }
    }
}

/// x² + 4 y² with x + y = 2, least at (1.6, 0.4), or with its square.
fn line(x: &[f64], c: &mut [f64], g: &mut [f64], is_square: bool) -> f64 {
    let h = x[0] + x[1] - 2.0;
    let slope = if is_square { 2.0 * h } else { 1.0 };
    c[0] = if is_square { h * h } else { h };
    g.copy_from_slice(&[2.0 * x[0], 8.0 * x[1], slope, slope]);
    x[0] * x[0] + 4.0 * x[1] * x[1]
}

/// y beside circles about (±1, 0) that touch at the origin, the only feasible point.
fn circles(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    for (j, centre) in [1.0, -1.0].into_iter().enumerate() {
        let d = [x[0] - centre, x[1]];
        c[j] = 0.5 * (d[0] * d[0] + d[1] * d[1] - 1.0);
        g[2 + 2 * j..][..2].copy_from_slice(&d);
    }
    g[..2].copy_from_slice(&[0.0, 1.0]);
    x[1]
}

#[test]
fn constraints_without_multipliers_are_named() {
    let once: Function = |x, c, g| line(x, c, g, false);
    let twice: Function = |x, c, g| line(x, c, g, true);
    let cases = [
        (once, 1, Reason::Stationary, [1.6, 0.4]),
        (twice, 1, Reason::Degenerate, [1.6, 0.4]),
        (circles, 2, Reason::Degenerate, [0.0, 0.0]),
    ];
    for (function, constraints, reason, least) in cases {
        for start in [[3.0, -1.0], [0.1, 0.2], [-4.0, 7.0]] {
            let mut problem = Given::new(function, vec![Interval::FREE; 2], vec![Interval::ZERO; constraints]);
            let outcome = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert_eq!(outcome.reason, reason, "{outcome}");
            // A violation of 1e-9 is a distance of 3e-5.
            assert!(outcome.x.iter().zip(least).all(|(x, of)| (x - of).abs() < 1e-4), "{:?}", outcome.x);
            let says = outcome.to_string().contains("no multiplier") && outcome.to_string().contains("constraint 0");
            assert_eq!(says, reason == Reason::Degenerate, "{outcome}");
            let by_gradients = augmented_lagrangian(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert_eq!(by_gradients.reason == Reason::Stationary, reason == Reason::Stationary, "{by_gradients}");
        }
    }
}

/// A cart that swings a link up in 2 s with the least effort, with φ = π/2 or ½ (φ − π/2)² = 0 at the end.
fn swing(is_square: bool) -> MotionProblem {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.effort("effort", cart.force, 0.01);
    let angle = cart.links[0].coordinates[2];
    let square = cart.scene.output("square");
    cart.scene.term(square, "square", AngleError, Sum::Terminal, [angle], [], [], [FRAC_PI_2.into()]);
    let end = cart.scene.end_state(angle);
    let system = cart.scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.04));
    let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force).scaled(10.0)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let (output, value) = if is_square { (square, 0.0) } else { (end.position, FRAC_PI_2) };
    problem.constrain(output, Interval::equal(value));
    problem
}

#[test]
fn an_angle_whose_square_must_vanish_has_no_multiplier() {
    let least = solve(&mut swing(false), Guess::Inputs, &Options::default(), &mut silent).expect("fits").outcome;
    assert_eq!(least.reason, Reason::Stationary, "{least}");
    for (stationarity, start) in [(1e-3, 0.0), (1e-5, 1.0), (1e-5, 5.0)] {
        let mut problem = swing(true);
        let (x, options) = (vec![start; problem.variables()], Options { stationarity, ..Options::default() });
        let found = interior_point(&mut problem, &x, &options, &mut silent).expect("fits");
        assert_eq!(found.reason, Reason::Degenerate, "{found}");
        assert!((found.value / least.value - 1.0).abs() < 1e-4 && found.to_string().contains("`square`"), "{found}");
    }
}
