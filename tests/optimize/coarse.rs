//! Controls on coarser knots in segments: the same minimum as one motion, exact derivatives, and what is refused.

use super::Effort;
use super::common::assert_says;
use super::shooting::{assert_changes, assert_rows, cart_and_bob};
use super::solve::OPTIONS;
use hamiltonian_adjoint::optimize::{
    Free, Guess, Interval, MotionProblem, MultipleShooting, Options, Parameter, Quantity, Trials, Variables, identify,
    interior_point, sensitivities, silent, solve, stages,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Control, EndState, Grid, Inputs, Scene, Settings, Start, Sum, System, simulate};
use std::f64::consts::FRAC_PI_2;

type Form = fn(Control, usize) -> Quantity;
const FORMS: [Form; 3] = [Quantity::LinearControl, Quantity::PiecewiseControl, Quantity::SplineControl];

const EXACT: Options = Options { stationarity: 1e-10, ..OPTIONS };

/// A body pushed by two forces, with the square of both as cost: a convex problem.
fn pushed() -> (System, [Control; 2], Vec<EndState>) {
    let mut scene = Scene::new();
    let body = scene.body("body", 2.0, 0.1, [0.0, 0.0, 0.0]);
    let forces = ["push", "lift"].map(|name| scene.control(name));
    for (name, force, angle) in [("along", forces[0], 0.0), ("across", forces[1], FRAC_PI_2)] {
        scene.actuator(name, Body::GROUND.at(0.0, 0.0), angle, body.at(0.0, 0.0), force);
        scene.cost(name, Effort, Sum::Integral, [], [], [force], [1.0.into()]);
    }
    let states = body.coordinates.map(|q| scene.end_state(q)).to_vec();
    (scene.compile().expect("a system"), forces, states)
}

#[test]
fn segments_find_the_minimum_of_one_motion() {
    let (system, forces, states) = pushed();
    let (mut seed, settings) = (1u64, Settings::default());
    let mut next = |below: usize| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as usize % below
    };
    for case in 0..40 {
        let steps = 4 + next(17);
        // Some steps are very short, so that some knots affect no node.
        let lengths = (0..steps).map(|_| [0.05, 0.05, 0.02, 0.2, 0.001][next(5)]).chain([0.1]).collect();
        let inputs = Inputs::at_rest(&system, Grid::new(0.0, lengths));
        let knots = 4 + next(steps - 2);
        let few = [FORMS[next(3)], FORMS[case % 3]];
        let free = vec![Free::new(few[0](forces[0], knots)).scaled(3.0), Free::new(few[1](forces[1], 4 + next(3)))];
        let segments = 1 + next(steps + 1);
        println!("{case}: {free:?}, {segments} segments, {:?}", inputs.grid.steps);
        let variables = Variables::new(&system, &inputs, free.clone()).expect("free");
        let mut one = MotionProblem::new(&system, settings, inputs.clone(), variables).expect("a problem");
        let mut whole = MultipleShooting::new(&system, settings, inputs, free, &states, segments).expect("a problem");
        for (state, to) in states.iter().zip([0.5, -0.2]) {
            one.constrain(state.position, Interval::equal(to));
            whole.constrain(state.position, Interval::equal(to));
        }
        let start = one.start();
        let alone = interior_point(&mut one, &start, &EXACT, &mut silent).expect("fits");
        let start: Vec<f64> = whole.start().iter().enumerate().map(|(i, x)| x + 0.1 * (1.3 * i as f64).sin()).collect();
        assert_rows(&mut whole, &start);
        let parts = stages(&mut whole, &start, &EXACT, &mut silent).expect("fits");
        println!("{alone}\n{parts}");
        assert!(alone.reason.is_converged() && parts.reason.is_converged());
        assert!((alone.value - parts.value).abs() < 1e-7 * alone.value, "{} {}", alone.value, parts.value);
        let controls = [one.inputs_at(&alone.x).controls, whole.inputs_at(&parts.x).controls];
        let far = (&controls[0] - &controls[1]).amax();
        assert!(far < 1e-4 * controls[0].amax(), "{far:.1e} {controls:?}");
    }
}

#[test]
fn derivatives_are_exact() {
    for (k, grid) in
        [Grid::new(0.0, vec![0.03, 0.05, 0.04, 0.02, 0.06, 0.03, 0.05]), Grid::uniform(9, 0.04)].iter().enumerate()
    {
        let mut scene = Scene::new();
        let ([cart, bob], force, length) = cart_and_bob(&mut scene);
        let torque = scene.control("torque");
        scene.torque_actuator("drive", cart, bob, torque);
        for (name, control) in [("push", force), ("turn", torque)] {
            scene.cost(name, Effort, Sum::Integral, [], [], [control], [0.2.into()]);
        }
        scene.time("time", 1.0);
        let states = [cart.coordinates[0], bob.coordinates[2]].map(|q| scene.end_state(q));
        let system = scene.compile().expect("a system");
        let mut inputs = Inputs::at_rest(&system, grid.clone());
        inputs.start = Start::assembled(&system);
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 3.0 * (0.9 * i as f64).sin());
        let free = vec![
            Free::new(FORMS[k](torque, 5)).scaled(0.5),
            Free::design(length).logarithmic(),
            Free::new(Quantity::SplineControl(force, 6)).scaled(2.0),
            Free::duration().scaled(0.5).within(0.1, 3.0),
        ];
        let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, free, &states, 3).expect("a problem");
        let x: Vec<f64> = problem.start().iter().enumerate().map(|(i, x)| x + 0.01 * (i as f64).cos()).collect();
        assert_rows(&mut problem, &x);
        assert_changes(&mut problem, &x);
    }
}

/// A cart with a link that comes to rest upright in 2 s, with its force on few knots.
fn upright(form: Form, knots: usize) -> (MotionProblem, EndState, Control) {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.effort("effort", cart.force, 1e-4);
    let place = cart.scene.end_state(cart.cart.coordinates[0]);
    let angle = cart.scene.end_state(cart.links[0].coordinates[2]);
    let system = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    let variables = Variables::new(&system, &inputs, vec![Free::new(form(cart.force, knots))]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(place.rate, Interval::ZERO);
    problem.constrain(angle.position, Interval::equal(FRAC_PI_2));
    problem.constrain(angle.rate, Interval::ZERO);
    (problem, angle, cart.force)
}

#[test]
fn few_knots_are_solved_in_segments_warm_and_accurately() {
    for form in FORMS {
        let (mut problem, angle, force) = upright(form, 12);
        let found = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits");
        println!("{found}");
        let first = &found.attempts[0];
        assert!(found.attempts.len() == 1 && first.what.ends_with("segments"), "{found}");
        assert!(found.outcome.reason.is_converged() && found.outcome.violation < 1e-8, "{found}");
        assert!(found.outcome.x.len() == 12 && problem.start() == found.outcome.x);
        // Warm, and as the derivatives say.
        let by =
            sensitivities(&mut problem, &found.outcome, &[Parameter::Target(angle.position)], &EXACT).expect("a minimum");
        let minimum_at = |problem: &mut MotionProblem, change: f64| {
            problem.constrain(angle.position, Interval::equal(FRAC_PI_2 + change));
            let near = solve(problem, Guess::from(&found.outcome), &EXACT, &mut silent).expect("fits");
            assert!(near.attempts.len() == 1 && near.outcome.iterations <= 5, "{near}");
            near.outcome.x
        };
        let [above, below] = [1e-4, -1e-4].map(|change| minimum_at(&mut problem, change));
        let error = problem.bound(&Quantity::Control(force), Interval::FREE).expect_err("it has few knots");
        assert_says(&error, &["in this form", "other knots"]);
        let kept = problem.start();
        let size = by[0].x.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (i, by) in by[0].x.iter().enumerate() {
            let expected = (above[i] - below[i]) / 2e-4;
            assert!((by - expected).abs() < 1e-3 * size, "{i}: {by} {expected}");
        }
        // Other changes than of controls keep the coefficients.
        problem.change(|inputs| inputs.grid.steps.fill(0.021)).expect("fits");
        assert_eq!(problem.start(), kept);
        // On finer grids with the same knots.
        let (mut problem, ..) = upright(form, 12);
        let fine = solve(&mut problem, Guess::Straight.accurate_to(1e-6), &OPTIONS, &mut silent).expect("fits");
        println!("{fine}");
        assert!(fine.outcome.reason.is_converged() && fine.attempts.len() > 1 && fine.outcome.x.len() == 12, "{fine}");
        let iterations: Vec<usize> = fine.attempts[1..].iter().map(|of| of.iterations).collect();
        assert!(iterations.iter().all(|count| *count <= 15), "{fine}");
        // Pieces on halved steps would be another control.
        let is_halved = fine.attempts.iter().any(|of| of.what.ends_with("steps"));
        assert_eq!(is_halved, form(force, 12) != Quantity::PiecewiseControl(force, 12), "{fine}");
        assert!((fine.outcome.value / found.outcome.value - 1.0).abs() < 0.05, "{fine}");
    }
}

#[test]
fn knots_that_are_not_in_the_order_of_nodes_are_refused() {
    let (system, [force, _], states) = pushed();
    let inputs = Inputs::at_rest(&system, Grid::new(0.0, vec![0.1, 0.1, -0.05, 0.1, 0.1]));
    let of = |quantity| {
        MultipleShooting::new(&system, Settings::default(), inputs.clone(), vec![Free::new(quantity)], &states, 2)
    };
    assert_says(
        &of(Quantity::LinearControl(force, 3)).expect_err("back in time"),
        &["knots of the control `push`", "back in time"],
    );
    of(Quantity::Control(force)).expect("at all nodes");
}

/// A mass of 1 kg on a spring, pushed by a force that is linear between six knots, read every 0.05 s for 5 s.
#[test]
fn a_force_on_few_knots_is_identified_in_segments() {
    let truth = [40.0, 3.0, -2.0, 0.5, 2.5, -1.0, 1.5];
    let pushed = |stiffness: f64, readings: &[f64]| {
        let mut scene = Scene::new();
        let stiffness = scene.design("stiffness", stiffness);
        let cart = scene.body("cart", 1.0, 0.1, [1.2, 0.0, 0.0]);
        scene.spring_damper("spring", Body::GROUND.at(-1.0, 0.0), cart.at(0.0, 0.0), stiffness, 2.0, 0.0);
        let force = scene.control("force");
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
        for (k, reading) in readings.iter().enumerate() {
            scene.reading(&format!("reading {k}"), cart.coordinates[0], 10 * (k + 1), *reading, 1e3);
        }
        let system = scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(500, 0.01));
        let free = vec![Free::design(stiffness), Free::new(Quantity::LinearControl(force, 6))];
        let variables = Variables::new(&system, &inputs, free).expect("free");
        (MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem"), cart.coordinates[0])
    };
    let (problem, place) = pushed(40.0, &[]);
    let motion = simulate(problem.solver.system(), &problem.inputs_at(&truth), Settings::default()).expect("a motion");
    let readings: Vec<f64> = (1..=50).map(|k| motion.q[(place.index(), 10 * k)]).collect();
    let (problem, _) = pushed(10.0, &readings);
    let mut record = Trials::sharing_designs(vec![problem]).expect("a record");
    let found = identify(&mut record, &OPTIONS, &mut silent).expect("fits");
    println!("{found}");
    assert!(found.attempts.len() > 1, "segments are needed from this guess");
    let far = found.fit.outcome.x.iter().zip(truth).fold(0.0f64, |most, (x, of)| most.max((x - of).abs()));
    assert!(far < 1e-5, "{far}: {:?}", found.fit.outcome.x);
    assert!(found.fit.standard_errors().is_some());
}
