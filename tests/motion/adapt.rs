//! Grids by tolerance: errors follow the tolerance, with fewer steps than the best uniform grid; the gradient on them is exact.

use crate::scenes::resolved;
use crate::scenes::resolved::Exact;

use crate::common::bench::{Bench, number};
use crate::common::{assert_gradient_is_exact_to, assert_says};
use hamiltonian_adjoint::element::ForcePoint;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Composition, Error, Force, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Scheme, Settings, Solver, Start,
    Sum, System, scenes::CartPendulum,
};
use nalgebra::{DVector, SVector};
use std::ops::ControlFlow;

/// ∫₀¹⁰ T dt, its derivatives by k and c, and q(10): DOP853 at 1e-13 and complex step.
const SLIDER_CRANK: [f64; 4] = [3.3366067994827757, 0.33344810612844017, -0.3637540339709487, 1.2756758486502386];

fn with(scheme: Scheme) -> Settings {
    Settings { scheme, ..Settings::default() }
}

/// A four-bar linkage whose rocker turns back sharply.
fn four_bar() -> (System, Inputs) {
    let mut bench = Bench::new();
    bench.four_bar();
    let system = bench.compile(Sum::Integral);
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 1.5));
    let p_star = DVector::from_fn(system.n(), |i, _| 1.5 * number(i + 3));
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star };
    (system, inputs)
}

#[test]
fn fewer_steps_than_the_best_uniform_grid_for_the_same_error() {
    for (name, (system, inputs)) in [
        ("slider-crank", resolved::slider_crank().expect("scene")),
        ("stick-slip", resolved::stick_slip().expect("scene")),
        ("four-bar", four_bar()),
    ] {
        let exact = Exact::new(&system, &inputs).expect("motion");
        for scheme in Scheme::ALL {
            let mut solver = Solver::new(&system, with(scheme));
            for tolerance in [1e-4, 1e-6] {
                let adapted = solver.adapt(&inputs, tolerance).expect("grid");
                let error = exact.error(solver.simulate(&adapted).expect("motion"));
                let steps = adapted.grid.steps.len();
                let of_uniform = exact.steps_of_uniform(&mut solver, &inputs, error);
                println!("{name}, {}, {tolerance:.0e}: error {error:.1e}, {steps} steps, uniform {of_uniform}", scheme.name);
                let [first, second, ..] = *adapted.grid.steps else { panic!("{name}, {}: {steps} steps", scheme.name) };
                assert!(second < 4.99 * first, "{name}, {}: a first step of {first} s before {second} s", scheme.name);
                // The errors of all steps add up.
                assert!(error <= 1000.0 * tolerance, "{name}, {}: {error:e}", scheme.name);
                if tolerance < 1e-5 {
                    assert!((steps as f64) <= 0.99 * of_uniform as f64, "{name}, {}: {steps}, {of_uniform}", scheme.name);
                }
            }
        }
    }
}

#[test]
fn the_slider_crank_s_integral_and_its_derivatives_are_those_of_another_program() {
    let (system, inputs) = resolved::slider_crank().expect("scene");
    let [value, by_k, by_c, q] = SLIDER_CRANK;
    let mut solver = Solver::new(&system, with(Scheme::ESDIRK5));
    let adapted = solver.adapt(&inputs, 1e-12).expect("grid");
    let motion = solver.simulate(&adapted).expect("motion");
    let at_end = motion.q[(0, motion.computed - 1)];
    let gradient = solver.gradient().expect("gradient");
    let errors = [at_end - q, gradient.value - value, gradient.design[0] - by_k, gradient.design[1] - by_c];
    println!("{} steps, errors {errors:?}", adapted.grid.steps.len());
    assert!(errors.iter().all(|error| error.abs() < 1e-9));
}

#[test]
fn the_gradient_on_the_grid_is_exact_and_given_bends_of_controls_are_nodes_of_it() {
    let system = CartPendulum::with_links(2).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
    inputs.controls.copy_from_slice(&[10.0, 20.0, 30.0, 5.0, 5.0]);
    for scheme in Scheme::ALL {
        for (rebase_every, drift_bound) in [(0, f64::INFINITY), (2, 0.0)] {
            let settings = Settings { rebase_every, drift_bound, ..with(scheme) };
            let adapted = Solver::new(&system, settings).adapt(&inputs, 1e-3).expect("grid");
            let times = adapted.grid.times();
            for (t, u) in [(0.2, 30.0), (0.3, 5.0), (0.4, 5.0)] {
                let node = times.iter().position(|found| (found - t).abs() < 1e-14);
                let node = node.unwrap_or_else(|| panic!("{}: no node at {t}: {times:?}", scheme.name));
                assert!((adapted.controls[(0, node)] - u).abs() < 1e-12, "{}", scheme.name);
            }
            assert_gradient_is_exact_to(1e-11, scheme.name, &system, &adapted, settings);
        }
    }
}

/// A jump is a short step, beside whose slope all others are small.
#[test]
fn bends_beside_a_jump_are_kept() {
    let mut scene = Scene::new();
    let cart = scene.body("cart", 1.0, 0.1, [0.0; 3]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    let system = scene.compile().expect("scene");
    for jump in [1e-3, 1e-6, 1e-9, 1e-12] {
        // 0, 1, 0 in two seconds, then 3: x(3) = 3.5, less what the jump takes.
        let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, vec![1.0, 1.0, jump, 1.0 - jump]));
        [0.0, 1.0, 0.0, 3.0, 3.0].into_iter().enumerate().for_each(|(i, u)| inputs.controls[(0, i)] = u);
        for scheme in Scheme::ALL {
            let mut solver = Solver::new(&system, with(scheme));
            let adapted = solver.adapt(&inputs, 1e-7).expect("grid");
            let motion = solver.simulate(&adapted).expect("motion");
            let error = motion.q[(0, motion.computed - 1)] - 3.5 + 1.5 * jump;
            println!("{jump:e}, {}: {} steps, error {error:.1e}", scheme.name, adapted.grid.steps.len());
            assert!(error.abs() < 1e-5 + jump * jump, "{jump:e}, {}: {error:e}", scheme.name);
        }
    }
    // What lies on a line is no bend.
    let steps: Vec<f64> = (0..30).map(|k| 0.01 + 1e-3 * f64::from(k)).collect();
    let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, steps));
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(&times).for_each(|(u, t)| *u = 1e3 + 0.1 * t);
    let adapted = Solver::new(&system, with(Scheme::ESDIRK4)).adapt(&inputs, 1e-3).expect("grid");
    assert!(adapted.grid.steps.len() < 15, "{}", adapted.grid.steps.len());
    // A pulse with slanted sides, and rounding where it should be zero.
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(3000, 2e-3));
    let pulse = |t: f64| 0.7 * (t.abs() + (t - 3.0).abs() - (t - 1.1).abs() - (t - 1.9).abs()) / 2.0;
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(&times).for_each(|(u, t)| *u = pulse(*t));
    assert!(inputs.controls.iter().any(|u| u.abs() > 0.0 && u.abs() < 1e-14));
    let adapted = Solver::new(&system, with(Scheme::ESDIRK4)).adapt(&inputs, 1e-3).expect("grid");
    assert!(adapted.grid.steps.len() < 30, "{}", adapted.grid.steps.len());
}

#[test]
fn a_motion_backwards_is_followed_too() {
    let (system, inputs) = resolved::stick_slip().expect("scene");
    let mut solver = Solver::new(&system, with(Scheme::ESDIRK4));
    let mut backward = inputs.clone();
    backward.grid.steps = vec![-0.1];
    let adapted = solver.adapt(&backward, 1e-6).expect("grid");
    assert!((adapted.grid.steps.iter().sum::<f64>() + 0.1).abs() < 1e-14);
}

#[test]
fn what_no_grid_can_be_made_of_is_refused() {
    let (system, inputs) = resolved::slider_crank().expect("scene");
    let mut solver = Solver::new(&system, Settings::default());
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(solver.adapt(&inputs, tolerance), Err(Error::Parameter { .. })), "{tolerance}");
    }
    let grids = [
        (Grid::composed(2, 0.1, Composition::Suzuki4), ["`Grid::stages`", "must be 1"]),
        (Grid::new(0.0, vec![0.1, -0.1]), ["step 2", "is -0.1; it must be of the same sign"]),
        (Grid::new(0.0, vec![]), ["number of steps", "1 or more"]),
    ];
    for (grid, parts) in grids {
        let controls = nalgebra::DMatrix::zeros(0, grid.nodes());
        assert_says(&solver.adapt(&Inputs { grid, controls, ..inputs.clone() }, 1e-6).expect_err("no grid"), &parts);
    }
    for node in [0, 1, 3] {
        let mut scene = Scene::new();
        let block = scene.body("block", 1.0, 0.1, [0.0; 3]);
        scene.reading("reading", block.coordinates[0], node, 0.5, 1.0);
        let system = scene.compile().expect("scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
        let adapted = Solver::new(&system, Settings::default()).adapt(&inputs, 1e-6);
        assert_eq!(adapted.is_ok(), node == 0, "{node}");
        if let Err(error) = adapted {
            assert_says(&error, &["`reading`", "adaptive grid"]);
        }
    }
    let error = solver.adapt(&inputs, 1e-40).expect_err("too small");
    assert_says(&error, &["tolerance cannot be met", "t = 0.0 s"]);
    // The solver goes on.
    assert!(solver.simulate(&inputs).is_ok() || solver.simulate(&resolved::uniform(&inputs, 100)).is_ok());
}

/// A rod on a hinge that begins to fall.
fn pendulum(duration: f64) -> (System, Inputs) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rod = scene.body("rod", 2.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(1, duration));
    (system, inputs)
}

/// Where no estimate would ever tell: with embedded weights it is rounding times the length of the step, however short that is.
#[test]
fn tolerances_below_the_rounding_of_coordinates_are_refused_soon() {
    let (system, inputs) = pendulum(1.0);
    for scheme in Scheme::ALL {
        let mut solver = Solver::new(&system, with(scheme));
        for tolerance in [1e-17, 1e-19, 1e-22, 1e-26, 1e-40] {
            let mut calls = 0;
            solver.watch(move |_| {
                calls += 1;
                if calls > 1000 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            let error = solver.adapt(&inputs, tolerance).map(drop).expect_err("too small");
            println!("{}, {tolerance:e}: {error}", scheme.name);
            assert_says(&error, &["the tolerance cannot be met at t = ", "larger tolerance"]);
        }
    }
    // What rounding leaves room for is met.
    let (system, inputs) = pendulum(0.05);
    for scheme in Scheme::ALL {
        let adapted = Solver::new(&system, with(scheme)).adapt(&inputs, 1e-13).expect("grid");
        assert!(adapted.grid.steps.len() < 10_000, "{}", scheme.name);
    }
    // So is it of small coordinates beside a large one that does not move.
    let mut scene = Scene::new();
    let block = scene.body("block", 1.0, 0.1, [1e-6, 3.0, 0.0]);
    scene.spring_damper("spring", Body::GROUND.at(-1.0, 3.0), block.at(0.0, 0.0), 4.0, 1.0, 0.0);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.1));
    let mut solver = Solver::new(&system, with(Scheme::ESDIRK5));
    assert!(solver.adapt(&inputs, 1e-19).expect("grid").grid.steps.len() < 1000);
}

#[test]
fn what_watches_a_grid_in_the_making_can_stop_it_soon() {
    // Steps of some 1e-4 s, as many as 1e7 in all.
    let (system, inputs) = pendulum(1000.0);
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK3] {
        let mut solver = Solver::new(&system, with(scheme));
        solver.watch(|progress| if progress.done > 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) });
        let error = solver.adapt(&inputs, 1e-11).map(drop).expect_err("stopped");
        assert!(matches!(error, Error::Interrupted { done: ..=200, of: 10_000.. }), "{}: {error}", scheme.name);
    }
}

/// Two masses on a stiff spring, or a stiff damper, of which the first hangs on a soft spring.
struct Masses;
impl KineticEnergy<2> for Masses {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 2>, v: &SVector<S, 2>, _: &SVector<S, 0>) -> S {
        (v[0] * v[0] + v[1] * v[1]) * 0.5
    }
}
impl PotentialEnergy<2, 1> for Masses {
    fn potential_energy<S: Scalar>(&self, x: &SVector<S, 2>, b: &SVector<S, 1>, _: S) -> S {
        let apart = x[1] - x[0];
        (x[0] * x[0] * 40.0 + b[0] * apart * apart) * 0.5
    }
}
impl Force<2, 0, 1> for Masses {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let pull = b[0] * (at.v[1] - at.v[0]);
        SVector::from([pull, -pull])
    }
}

#[test]
fn what_is_too_stiff_to_be_seen_does_not_shorten_steps_of_l_stable_schemes() {
    for (spring, damper) in [(1e8, 0.0), (0.0, 1e8)] {
        let mut scene = Scene::new();
        let x = scene.coordinates("masses", ["first", "second"]);
        scene.kinetic_energy("inertia", Masses, x, []);
        scene.potential_energy("springs", Masses, x, [spring.into()]);
        scene.force("damper", Masses, x, [], [damper.into()]);
        let system = scene.compile().expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 2.0));
        inputs.start.q_mut().fill(1.0);
        for scheme in Scheme::ALL {
            let mut solver = Solver::new(&system, with(scheme));
            let steps = solver.adapt(&inputs, 1e-4).expect("grid").grid.steps.len();
            println!("spring {spring:e} N/m, damper {damper:e} N s/m, {}: {steps} steps", scheme.name);
            // The soft motion alone takes as many.
            assert!(scheme == Scheme::TRAPEZOIDAL || steps < 120, "{}: {steps}", scheme.name);
        }
    }
}

#[test]
fn a_solver_that_made_a_grid_has_no_motion_until_it_simulates_one() {
    let (system, inputs) = resolved::slider_crank().expect("scene");
    let mut solver = Solver::new(&system, with(Scheme::ESDIRK4));
    let adapted = solver.adapt(&inputs, 1e-3).expect("grid");
    assert_eq!(solver.inputs(), &adapted);
    assert!(matches!(solver.gradient(), Err(Error::Incomplete { computed: 0, .. })));
    assert!(matches!(solver.cost(), Err(Error::Incomplete { computed: 0, .. })));
    let motion = solver.simulate(&adapted).expect("motion").clone();
    // The same numbers as by a solver that knows nothing of how the grid was found.
    assert_eq!(&motion, Solver::new(&system, with(Scheme::ESDIRK4)).simulate(&adapted).expect("motion"));
}

#[test]
fn a_motion_that_begins_late_has_the_same_steps() {
    let (system, mut inputs) = four_bar();
    let mut solver = Solver::new(&system, with(Scheme::ESDIRK5));
    let steps = solver.adapt(&inputs, 1e-9).expect("grid").grid.steps;
    for start in [1.7e9, 1e12, -1e20] {
        inputs.grid.start = start;
        assert_eq!(solver.adapt(&inputs, 1e-9).expect("grid").grid.steps, steps, "{start}");
    }
}

#[test]
fn a_grid_that_was_not_finished_is_no_motion() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
    inputs.controls.fill(10.0);
    for calls in [1, 5, 30] {
        let mut solver = Solver::new(&system, with(Scheme::TRAPEZOIDAL));
        let mut left = calls;
        solver.watch(move |_| {
            left -= 1;
            if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert!(matches!(solver.adapt(&inputs, 1e-3), Err(Error::Interrupted { .. })));
        assert!(matches!(solver.gradient(), Err(Error::Incomplete { .. })), "{calls}");
        assert!(matches!(solver.cost(), Err(Error::Incomplete { .. })), "{calls}");
        assert_eq!(solver.inputs().controls.ncols(), solver.inputs().grid.nodes());
    }
}

/// What was there before belongs to other inputs, whether there is a new grid or not.
#[test]
fn no_motion_is_left_behind_where_no_grid_is_made() {
    let (system, inputs) = four_bar();
    let mut solver = Solver::new(&system, with(Scheme::ESDIRK4));
    let motion = Inputs { grid: Grid::uniform(1, 0.05), ..inputs.clone() };
    for tolerance in [1e-3, -1.0] {
        solver.simulate(&motion).expect("motion");
        assert_eq!(solver.adapt(&motion, tolerance).is_ok(), tolerance > 0.0);
        assert_says(&solver.gradient().expect_err("no motion"), &["no motion"]);
    }
}
