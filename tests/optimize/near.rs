//! Minima of problems that differ a little from solved ones.

use hamiltonian_adjoint::optimize::{
    Attempt, Free, Guess, Interval, MotionProblem, Options, Outcome, Parameter, Problem, Quantity, Reason, Variables,
    sensitivities, silent, solve,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Control, Cost, CostPoint, Error, Grid, Inputs, Output, Scalar, Scene, Settings, Start};
use nalgebra::SVector;
use std::f64::consts::{FRAC_PI_2, PI};

const OPTIONS: Options =
    Options { iterations: 300, target: None, stationarity: 1e-7, violation: 1e-9, memory: 30, first_step: None };

/// A cart whose links turn up and come to rest in 2 s with the least effort of a bounded force; the end of the first link.
fn bounded(links: usize, most: f64) -> (MotionProblem, Output) {
    let mut cart = CartPendulum::with_links(links).mechanism();
    cart.scene.effort("effort", cart.force, 1e-4);
    let place = cart.scene.end_state(cart.cart.coordinates[0]);
    let angles: Vec<_> = cart.links.iter().map(|link| cart.scene.end_state(link.coordinates[2])).collect();
    let system = cart.scene.compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    inputs.set_control(cart.force, |t| 5.0 * (PI * t).sin());
    let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force).within(-most, most)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(place.rate, Interval::ZERO);
    for angle in &angles {
        problem.constrain(angle.position, Interval::equal(FRAC_PI_2));
        problem.constrain(angle.rate, Interval::ZERO);
    }
    (problem, angles[0].position)
}

fn solved(problem: &mut MotionProblem, guess: Guess) -> (Outcome, Vec<Attempt>) {
    let found = solve(problem, guess, &OPTIONS, &mut silent).expect("fits");
    println!("{found}");
    assert!(found.outcome.reason == Reason::Stationary && found.outcome.violation <= 1e-9, "{}", found.outcome);
    (found.outcome, found.attempts)
}

/// Asserts that the minimum of a changed problem is found from the one before in few iterations, and that further iterations do not change it.
fn assert_near(problem: &mut MotionProblem, before: &Outcome, most: usize) -> Outcome {
    let (found, attempts) = solved(problem, before.into());
    assert!(attempts.len() == 1 && found.iterations <= most, "{} iterations", found.iterations);
    let (again, _) = solved(problem, Guess::from(&found));
    let change = again.x.iter().zip(&found.x).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    let size = found.x.iter().fold(1.0f64, |most, x| most.max(x.abs()));
    assert!((again.value - found.value).abs() < 1e-9 * found.value.abs().max(1e-2), "{} {}", again.value, found.value);
    assert!(again.iterations <= 5 && change < 1e-3 * size, "{} iterations, {change:.1e}", again.iterations);
    assert_eq!(problem.start(), again.x);
    found
}

/// Number of variables at their bounds.
fn at_bounds(problem: &MotionProblem, x: &[f64]) -> usize {
    let bounds = problem.bounds();
    x.iter().zip(bounds).filter(|(x, of)| (*x - of.least).min(of.most - *x) < 1e-4 * (of.most - of.least)).count()
}

#[test]
fn a_moved_target_takes_a_few_iterations() {
    for (links, most, active) in [(1, 18.0, 18), (2, 38.0, 21)] {
        let (mut problem, angle) = bounded(links, most);
        let (mut before, _) = solved(&mut problem, Guess::Straight);
        let found = at_bounds(&problem, &before.x);
        assert!(found >= active, "{found} controls at bounds");
        for by in [0.0, 1e-4, 1e-3] {
            problem.constrain(angle, Interval::equal(FRAC_PI_2 + by));
            before = assert_near(&mut problem, &before, 5);
        }
        // A straight line of states leads to the same minimum.
        let (far, _) = solved(&mut problem, Guess::Straight);
        assert!((far.value - before.value).abs() < 1e-7 * far.value, "{} {}", far.value, before.value);
        problem.constrain(angle, Interval::equal(FRAC_PI_2 + 0.02));
        assert_near(&mut problem, &before, 12);
    }
}

#[test]
fn after_segments_that_do_not_get_on_one_motion_is_tried() {
    let tried = |most: f64| {
        let solved = solve(&mut bounded(2, most).0, Guess::Straight, &OPTIONS, &mut silent).expect("fits");
        println!("{solved}");
        let ways: Vec<bool> = solved.attempts.iter().map(|of| of.what == "one motion").collect();
        (ways, solved.outcome.reason)
    };
    assert_eq!(tried(38.0), (vec![false, true], Reason::Stationary));
    // The force cannot turn the links up; three ways say so.
    assert_eq!(tried(5.0), (vec![false, true, false], Reason::Infeasible));
}

/// h = x.
pub struct Place;

impl Cost<1> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

#[test]
fn limits_at_all_nodes_remain_active() {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.effort("effort", cart.force, 1e-4);
    let rail = cart.scene.outputs_at("rail", Place, 0..=100, [cart.cart.coordinates[0]], [], [], []);
    let place = cart.scene.end_state(cart.cart.coordinates[0]);
    let angle = cart.scene.end_state(cart.links[0].coordinates[2]);
    let system = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain_all(&rail, Interval::new(-0.4, 0.4));
    problem.constrain(place.rate, Interval::ZERO);
    problem.constrain(angle.position, Interval::equal(FRAC_PI_2));
    problem.constrain(angle.rate, Interval::ZERO);
    let (mut before, _) = solved(&mut problem, Guess::Straight);
    let active = rail.iter().filter(|of| before.constraints[of.index()].abs() > 0.4 - 1e-4).count();
    assert!(active >= 2, "{active} nodes at the ends of the rail");
    for by in [0.0, 1e-4, 1e-3] {
        problem.constrain(angle.position, Interval::equal(FRAC_PI_2 + by));
        before = assert_near(&mut problem, &before, 5);
    }
    for (most, iterations) in [(0.4001, 5), (0.4, 5), (0.401, 9), (0.4, 12)] {
        problem.constrain_all(&rail, Interval::new(-most, most));
        before = assert_near(&mut problem, &before, iterations);
    }
}

#[test]
fn bounds_and_starts_may_change() {
    let (mut problem, _) = bounded(2, 40.0);
    let (before, _) = solved(&mut problem, Guess::Straight);
    problem
        .change(|inputs| {
            let Start::Velocity { v, .. } = &mut inputs.start else { panic!("velocities") };
            // All bodies move with the cart.
            (0..3).for_each(|body| v[3 * body] = 0.005);
            inputs.grid.steps.fill(0.02002);
        })
        .expect("fits");
    assert_near(&mut problem, &before, 12);
    // With a smaller bound, the controls before are outside.
    let (mut other, _) = bounded(2, 39.5);
    assert_near(&mut other, &before, 15);
}

/// A cart whose link turns up in the shortest time.
fn shortest(most: f64) -> (MotionProblem, Control) {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.time("time", 1.0);
    let angle = cart.scene.end_state(cart.links[0].coordinates[2]);
    let place = cart.scene.end_state(cart.cart.coordinates[0]);
    let system = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(60, 0.03));
    let free = vec![Free::control(cart.force).within(-most, most).scaled(10.0), Free::duration().within(0.5, 5.0)];
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(angle.position, Interval::equal(FRAC_PI_2));
    problem.constrain(angle.rate, Interval::ZERO);
    problem.constrain(place.rate, Interval::ZERO);
    (problem, cart.force)
}

#[test]
fn a_shortest_time_changes_with_the_bound_of_its_control() {
    let (mut problem, force) = shortest(30.0);
    let (before, _) = solved(&mut problem, Guess::Straight);
    let found = at_bounds(&problem, &before.x);
    assert!(found > 40, "{found} controls at bounds");
    let bounded =
        |problem: &mut MotionProblem, most: f64| problem.bound(&Quantity::Control(force), Interval::new(-most, most));
    bounded(&mut problem, 29.9).expect("fits");
    assert_eq!(problem.bounds(), shortest(29.9).0.bounds());
    let after = assert_near(&mut problem, &before, 15);
    assert!(after.value > before.value && after.value < 1.01 * before.value, "{} {}", before.value, after.value);
    bounded(&mut problem, 30.0).expect("fits");
    let back = assert_near(&mut problem, &after, 15);
    assert!((back.value - before.value).abs() < 1e-6 * before.value, "{} {}", before.value, back.value);
    // Nothing changes if bounds do not fit.
    assert!(matches!(bounded(&mut problem, -1.0), Err(Error::Parameter { .. })));
    let error = problem.bound(&Quantity::StepLength(3), Interval::FREE).expect_err("not free");
    assert!(error.to_string().contains("`length of step 3` is not among the"), "{error}");
    assert_eq!(problem.bounds(), shortest(30.0).0.bounds());
}

/// A slider-crank whose crank turns from 1 rad to an angle with a bounded torque.
fn slider_crank(end: f64) -> MotionProblem {
    let (mut scene, [r, l]) = (Scene::new(), [0.5, 1.2]);
    scene.gravity(0.0, -9.81);
    let (sin, cos) = 1f64.sin_cos();
    let tilt = -(r * sin / l).asin();
    let place = r * cos + l * tilt.cos();
    let crank = scene.body("crank", 1.0, 0.02, [0.5 * r * cos, 0.5 * r * sin, 1.0]);
    let rod = scene.body("rod", 1.5, 0.15, [0.5 * (r * cos + place), 0.5 * r * sin, tilt]);
    let slider = scene.body("slider", 1.0, 0.01, [place, 0.0, 0.0]);
    scene.revolute("bearing", Body::GROUND.at(0.0, 0.0), crank.at(-0.5 * r, 0.0));
    scene.revolute("pin", crank.at(0.5 * r, 0.0), rod.at(-0.5 * l, 0.0));
    scene.revolute("slider pin", rod.at(0.5 * l, 0.0), slider.at(0.0, 0.0));
    scene.prismatic("guide", Body::GROUND.at(0.0, 0.0), 0.0, slider.at(0.0, 0.0), 0.0);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, crank, torque);
    scene.effort("effort", torque, 1e-2);
    let angle = scene.end_state(crank.coordinates[2]);
    let system = scene.compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.01));
    inputs.set_control(torque, |_| 8.0);
    let free = vec![Free::control(torque).within(-20.0, 14.0)];
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(angle.position, Interval::equal(end));
    problem.constrain(angle.rate, Interval::ZERO);
    problem
}

#[test]
fn loops_are_joined() {
    let mut problem = slider_crank(2.0);
    let (before, _) = solved(&mut problem, Guess::Straight);
    assert_near(&mut slider_crank(2.001), &before, 6);
}

#[test]
fn an_infeasible_change_is_not_called_a_minimum() {
    let (mut problem, angle) = bounded(1, 18.0);
    let (before, _) = solved(&mut problem, Guess::Straight);
    problem.constrain(angle, Interval::equal(4.0));
    let few = Options { iterations: 50, ..OPTIONS };
    let found = solve(&mut problem, Guess::from(&before), &few, &mut silent).expect("fits");
    println!("{found}");
    assert!(!found.outcome.reason.is_converged() && found.attempts[0].what == "near the optimum", "{}", found.outcome);
}

#[test]
fn wrong_optima_are_refused() {
    let (mut problem, _) = bounded(1, 18.0);
    let outputs = problem.constraints().len();
    let mut refused = |x: Vec<f64>, multipliers: Vec<f64>| {
        solve(&mut problem, Guess::Optimum { x, multipliers }, &OPTIONS, &mut silent).expect_err("wrong")
    };
    let error = refused(vec![0.0; 7], vec![0.0; outputs]);
    assert!(matches!(&error, Error::Size { what: "the variables of a guess", expected: 101, found: 7 }), "{error}");
    let error = refused(vec![0.0; 101], vec![0.0; outputs + 1]);
    assert!(matches!(&error, Error::Size { what: "the multipliers of a guess", .. }), "{error}");
    let error = refused(vec![f64::NAN; 101], vec![0.0; outputs]);
    assert!(error.to_string().contains("variables of a guess"), "{error}");
}

/// Asserts that derivatives of a minimum agree with differences of minima for a parameter that is changed by ±h.
fn assert_derivative(what: &str, build: impl Fn(f64) -> MotionProblem, by: impl Fn(&MotionProblem) -> Parameter, h: f64) {
    let mut problem = build(0.0);
    let (best, _) = solved(&mut problem, Guess::Straight);
    let of = by(&problem);
    let exact = Options { stationarity: 1e-9, violation: 1e-11, ..OPTIONS };
    let found = sensitivities(&mut problem, &best, &[of], &exact).expect("a minimum").remove(0);
    let [more, less] = [h, -h].map(|h| {
        let found = solve(&mut build(h), Guess::from(&best), &exact, &mut silent).expect("fits").outcome;
        assert!(found.reason.is_converged(), "{what}: {found}");
        found
    });
    let differences: Vec<f64> = more.x.iter().zip(&less.x).map(|(more, less)| (more - less) / (2.0 * h)).collect();
    let size = differences.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let far = differences.iter().zip(&found.x).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    let value = (more.value - less.value) / (2.0 * h);
    println!("{what}: dx {far:.1e} of {size:.1e}, dJ {} {value}", found.value);
    assert!(size > 1e-3 && far < 1e-3 * size, "{what}: {far:.1e} of {size:.1e}");
    assert!((found.value - value).abs() < 1e-4 * value.abs(), "{what}: {} {value}", found.value);
}

/// The output of a problem with a name that begins so.
fn output(problem: &MotionProblem, name: &str) -> Parameter {
    let system = problem.solver.system();
    let found = (0..system.outputs()).find(|&k| system.output_name(k).starts_with(name));
    Parameter::Target(system.output(found.expect("an output")))
}

/// A bob pulled by a bounded force along a line, held by a spring whose stiffness is a variable with equal bounds, as is the initial velocity; its
/// place has limits at all nodes, that at node 20 is given. It comes to rest; if the time is free, it is a part of J.
fn pulled([stiffness, velocity, limit, longest]: [f64; 4], is_timed: bool) -> MotionProblem {
    let mut scene = Scene::new();
    let bob = scene.body("bob", 1.0, 0.1, [0.0, 0.0, 0.0]);
    scene.prismatic("line", Body::GROUND.at(0.0, 0.0), 0.0, bob.at(0.0, 0.0), 0.0);
    let (force, k) = (scene.control("force"), scene.design("stiffness", stiffness));
    scene.actuator("drive", Body::GROUND.at(0.0, 0.0), 0.0, bob.at(0.0, 0.0), force);
    scene.spring_damper("spring", Body::GROUND.at(-1.0, 0.0), bob.at(0.0, 0.0), k, 0.5, 0.0);
    scene.effort("effort", force, 1.0);
    scene.time("time", if longest > 2.0 { 3.0 } else { 0.1 });
    let end = scene.end_state(bob.coordinates[0]);
    let places = scene.outputs_at("place", Place, 1..=40, [bob.coordinates[0]], [], [], []);
    let system = scene.compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.04));
    let Start::Velocity { v, .. } = &mut inputs.start else { panic!("velocities") };
    v[0] = velocity;
    let rate = Free::new(Quantity::Rate(bob.coordinates[0])).within(velocity, velocity);
    let held = Free::design(k).within(stiffness, stiffness);
    let mut free = vec![Free::control(force).within(-9.0, 9.0), rate, held];
    free.extend(is_timed.then(|| Free::duration().within(0.5, longest)));
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(end.position, Interval::equal(1.0));
    problem.constrain(end.rate, Interval::ZERO);
    problem.constrain_all(&places, Interval::at_most(1.02));
    problem.constrain(places[19], Interval::at_most(limit));
    problem
}

#[test]
fn derivatives_of_a_minimum_agree_with_differences() {
    let moved = |by: f64| {
        let (mut problem, angle) = bounded(1, 18.0);
        problem.constrain(angle, Interval::equal(FRAC_PI_2 + by));
        problem
    };
    assert_derivative("a target", moved, |of| output(of, "value of link"), 1e-5);
    assert_derivative("a target of a loop", |by| slider_crank(2.0 + by), |of| output(of, "value of crank"), 1e-5);
    for is_timed in [false, true] {
        let given = [2.0, 1.5, 0.4, 5.0];
        let build =
            |i: usize| move |by: f64| pulled(std::array::from_fn(|j| given[j] + if i == j { by } else { 0.0 }), is_timed);
        assert_derivative("a velocity", build(1), |_| Parameter::Bound(41), 1e-5);
        assert_derivative("a design variable", build(0), |_| Parameter::Bound(42), 1e-5);
        assert_derivative("a limit", build(2), |of| Parameter::Target(place(of, 20)), 1e-5);
    }
    let longest = |by: f64| pulled([2.0, 1.5, 0.4, 1.5 + by], true);
    assert_derivative("a bound", longest, |_| Parameter::Bound(43), 1e-5);
}

/// The place at a node.
fn place(problem: &MotionProblem, node: usize) -> Output {
    let Parameter::Target(first) = output(problem, "place") else { panic!("an output") };
    problem.solver.system().output(first.index() + node - 1)
}

#[test]
fn what_is_no_minimum_has_no_derivatives() {
    let (mut problem, angle) = bounded(1, 18.0);
    let (best, _) = solved(&mut problem, Guess::Straight);
    let few = Options { iterations: 1, ..OPTIONS };
    problem.constrain(angle, Interval::equal(3.0));
    let error = sensitivities(&mut problem, &best, &[Parameter::Target(angle)], &few).expect_err("another target");
    assert!(matches!(&error, Error::NoMinimum { why } if why.contains("violation")), "{error}");
    let error = sensitivities(&mut problem, &best, &[Parameter::Bound(101)], &OPTIONS).expect_err("101 variables");
    assert!(matches!(&error, Error::NotAVariable { variables: 101, .. }), "{error}");
}

#[test]
fn a_held_coordinate_that_constraints_determine_has_no_derivatives() {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.effort("effort", cart.force, 1e-4);
    let angle = cart.links[0].coordinates[2];
    let end = cart.scene.end_state(angle);
    let system = cart.scene.compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
    let held = || Free::new(Quantity::Coordinate(angle)).within(-FRAC_PI_2, -FRAC_PI_2);
    let mut solved = |start: Start| {
        inputs.start = start;
        let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force), held()]).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs.clone(), variables).expect("a problem");
        problem.constrain(end.position, Interval::equal(0.0));
        let minimum = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits").outcome;
        sensitivities(&mut problem, &minimum, &[Parameter::Bound(51)], &OPTIONS).map(|found| found[0].value)
    };
    let by = solved(Start::assembled(&system).hold(&[angle])).expect("an assembled start follows the angle");
    assert!(by != 0.0, "{by}");
    // A given start would violate the hinge.
    let given = Inputs::at_rest(&system, Grid::uniform(1, 0.02)).start;
    let error = solved(given).expect_err("determined");
    assert!(matches!(&error, Error::NotFree { .. }) && error.to_string().contains("hinge"), "{error}");
}
