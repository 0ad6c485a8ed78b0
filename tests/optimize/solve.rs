//! One statement, solved from a guess of the states: the minimum of the problem as a single motion.

use hamiltonian_adjoint::optimize::{
    Free, Guess, Interval, Iterate, MotionProblem, Options, Problem, Reason, Variables, interior_point, silent, solve,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Control, EndState, Grid, Inputs, Scene, Settings, Sum};
use nalgebra::DMatrix;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

pub const OPTIONS: Options =
    Options { iterations: 200, target: None, stationarity: 1e-6, violation: 1e-8, memory: 30, first_step: None };

/// A cart whose links turn up and come to rest in 2 s with the least effort.
pub fn upright(links: usize, force: f64) -> MotionProblem {
    let mut cart = CartPendulum::with_links(links).mechanism();
    cart.scene.effort("effort", cart.force, 1e-4);
    let place = cart.scene.end_state(cart.cart.coordinates[0]);
    let angles: Vec<_> = cart.links.iter().map(|link| cart.scene.end_state(link.coordinates[2])).collect();
    let mut problem = started(&cart.scene, Free::control(cart.force), (cart.force, force), 0.02);
    problem.constrain(place.rate, Interval::ZERO);
    come_upright(&mut problem, &angles);
    problem
}

/// A problem in 100 steps, begun at rest with a control a sin πt.
fn started(scene: &Scene, free: Free, (control, a): (Control, f64), dt: f64) -> MotionProblem {
    let system = scene.clone().compile().expect("a system");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, dt));
    inputs.set_control(control, |t| a * (PI * t).sin());
    let variables = Variables::new(&system, &inputs, vec![free]).expect("free");
    MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem")
}

/// Requires that links are upright and at rest at the end.
fn come_upright(problem: &mut MotionProblem, angles: &[EndState]) {
    for angle in angles {
        problem.constrain(angle.position, Interval::equal(FRAC_PI_2));
        problem.constrain(angle.rate, Interval::ZERO);
    }
}

#[test]
fn three_links_come_to_rest_as_a_single_motion() {
    for force in [0.0, 10.0, -5.0] {
        let mut problem = upright(3, force);
        let solved = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits");
        println!("{solved}");
        let found = &solved.outcome;
        // The value was found by IPOPT for the same discretisation, with all states as variables.
        assert!(found.reason == Reason::Stationary && found.violation < 1e-8, "{found}");
        assert!((found.value - 0.446_288_166).abs() < 1e-7, "{found}");
        assert_eq!(solved.attempts.len(), 1);
        // The problem has the motion of the solution, and the multipliers are those of one motion.
        assert_eq!(problem.start(), found.x);
        let mut gradient = vec![0.0; found.x.len()];
        problem.gradient(1.0, &found.multipliers, &mut gradient).expect("a gradient");
        let largest = gradient.iter().fold(0.0f64, |most, g| most.max(g.abs()));
        assert!(largest < 1e-4, "{largest:.1e}");
    }
}

/// A trolley of 5 kg with a load of 10 kg on a rod of 2 m, moved by 3 m, in the shortest time if the duration is free.
fn crane(steps: usize, is_timed: bool) -> MotionProblem {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let trolley = scene.body("trolley", 5.0, 0.1, [0.0; 3]);
    let load = scene.body("load", 10.0, 0.01, [0.0, -2.0, 0.0]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, trolley.at(0.0, 0.0), 0.0);
    scene.revolute("hinge", trolley.at(0.0, 0.0), load.at(0.0, 2.0));
    let force = scene.control("force");
    scene.actuator("drive", Body::GROUND.at(0.0, 0.0), 0.0, trolley.at(0.0, 0.0), force);
    scene.time("time", 1.0);
    let ends = [trolley.coordinates[0], load.coordinates[2]].map(|of| scene.end_state(of));
    let system = scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.03));
    let mut free = vec![Free::control(force).within(-20.0, 20.0)];
    free.extend(is_timed.then(|| Free::duration().within(0.5, 10.0)));
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    for (end, position) in ends.iter().zip([3.0, 0.0]) {
        problem.constrain(end.position, Interval::equal(position));
        problem.constrain(end.rate, Interval::ZERO);
    }
    problem
}

/// The rounding error of momenta of 60 kg m/s exceeds 1e-12, to which segments would otherwise be joined.
#[test]
fn segments_are_joined_to_rounding_error() {
    let solved = solve(&mut crane(100, true), Guess::Straight, &Options::default(), &mut silent).expect("fits");
    println!("{solved}");
    assert_eq!(solved.attempts.len(), 1);
    // IPOPT, in minimal coordinates: 3.0186.
    assert!(solved.outcome.reason == Reason::Stationary && solved.outcome.value < 3.019, "{solved}");
    assert!(solved.outcome.iterations < 60, "{solved}");
}

#[test]
fn a_motion_without_steps_does_not_get_anywhere() {
    let solved = solve(&mut crane(0, false), Guess::Straight, &Options::default(), &mut silent).expect("fits");
    assert_eq!(solved.outcome.reason, Reason::Infeasible, "{solved}");
}

/// Two links of 1 m and 1 kg with a motor of at most 20 N m between them, which swings them up to rest in 3 s.
pub fn acrobot(torque: f64) -> MotionProblem {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [upper, lower] =
        [("upper", -0.5), ("lower", -1.5)].map(|(name, y)| scene.body(name, 1.0, 1.0 / 12.0, [0.0, y, -FRAC_PI_2]));
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-0.5, 0.0));
    scene.revolute("elbow", upper.at(0.5, 0.0), lower.at(-0.5, 0.0));
    let motor = scene.control("torque");
    scene.torque_actuator("motor", upper, lower, motor);
    scene.effort("effort", motor, 1.0);
    let ends = [upper, lower].map(|link| scene.end_state(link.coordinates[2]));
    let mut problem = started(&scene, Free::control(motor).within(-20.0, 20.0), (motor, torque), 0.03);
    come_upright(&mut problem, &ends);
    problem
}

#[test]
fn an_acrobot_swings_up() {
    // Steps along lines jam at the bounds of the torque here. Those within a trust region do not, but they are slow from where lines lead on.
    for torque in [0.0, 1.0, -3.0] {
        let solved = solve(&mut acrobot(torque), Guess::Straight, &OPTIONS, &mut silent).expect("fits");
        println!("{solved}");
        assert!(solved.outcome.reason == Reason::Stationary && solved.outcome.violation < 1e-8, "{solved}");
        assert!(solved.attempts.len() <= 2 && solved.outcome.value < 80.0, "{solved}");
        assert!(torque != 0.0 || solved.attempts[0].iterations < 190, "{solved}");
    }
}

/// A cart whose three links turn up in the shortest time with a bounded force.
fn shortest() -> MotionProblem {
    let mut cart = CartPendulum::with_links(3).mechanism();
    cart.scene.time("time", 1.0);
    let angles: Vec<_> = cart.links.iter().map(|link| cart.scene.end_state(link.coordinates[2])).collect();
    let system = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    let free = vec![Free::control(cart.force).within(-50.0, 50.0).scaled(10.0), Free::duration().within(0.5, 5.0)];
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    angles.into_iter().for_each(|angle| problem.constrain(angle.position, Interval::equal(FRAC_PI_2)));
    problem
}

#[test]
fn the_shortest_time_is_found_by_way_of_a_feasible_motion() {
    let mut problem = shortest();
    let mut first = f64::NAN;
    let mut watch = |at: &Iterate, x: &[f64]| {
        if at.violation <= 1e-4 && first.is_nan() {
            first = x[x.len() - 1];
        }
        ControlFlow::Continue(())
    };
    let solved = solve(&mut problem, Guess::Straight, &OPTIONS, &mut watch).expect("fits");
    println!("{solved}");
    let found = &solved.outcome;
    assert!(solved.attempts.len() == 1 && found.reason.is_converged() && found.violation < 1e-8, "{solved}");
    assert!(found.value < 1.62, "{found}");
    // The first feasible motion has about the duration of the start.
    assert!((first - 2.0).abs() < 0.3, "{first}");
}

#[test]
fn states_may_be_given_and_starts_may_be_many() {
    let mut problem = upright(1, 0.0);
    let n = problem.solver.system().n();
    let straight = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits").outcome;
    // Angles alone: x and y of the link follow.
    let q = DMatrix::from_fn(n, 101, |i, node| if i == n - 1 { PI * node as f64 / 100.0 - FRAC_PI_2 } else { 0.0 });
    let v = DMatrix::from_fn(n, 101, |i, _| if i == n - 1 { FRAC_PI_2 } else { 0.0 });
    let mut problem = upright(1, 0.0);
    let given = solve(&mut problem, Guess::States { q: q.clone(), v }, &OPTIONS, &mut silent).expect("fits").outcome;
    assert!(given.reason.is_converged() && (given.value - straight.value).abs() < 1e-6 * straight.value, "{given}");
    let wrong = Guess::States { q: q.clone(), v: DMatrix::zeros(n, 3) };
    let error = solve(&mut problem, wrong, &OPTIONS, &mut silent).expect_err("three velocities");
    assert!(error.to_string().contains("velocities of a guess"), "{error}");
    let mut problem = upright(1, 0.0);
    let many = solve(&mut problem, Guess::Straight.starts(6), &OPTIONS, &mut silent).expect("fits");
    println!("{many}");
    assert!(many.outcome.reason.is_converged() && many.outcome.value <= straight.value * (1.0 + 1e-6));
    assert!(many.attempts.len() > 1);
}

#[test]
fn no_start_follows_an_interrupted_one() {
    let mut problem = upright(1, 0.0);
    let mut stop = |_: &Iterate, _: &[f64]| ControlFlow::Break(());
    let solved = solve(&mut problem, Guess::Straight.starts(6), &OPTIONS, &mut stop).expect("fits");
    assert_eq!((solved.outcome.reason, solved.attempts.len()), (Reason::Interrupted, 1));
}

/// A problem whose solver stops from a number of progress reports on, and the number of reports.
fn stopping(after: usize) -> (MotionProblem, Arc<AtomicUsize>) {
    let (mut problem, reports) = (upright(1, 0.0), Arc::new(AtomicUsize::new(0)));
    let count = reports.clone();
    let stop = move |_| if count.fetch_add(1, Relaxed) < after { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
    problem.solver.watch(stop);
    (problem, reports)
}

#[test]
fn the_solver_of_the_problem_stops_segments_and_starts() {
    let (mut problem, reports) = stopping(usize::MAX);
    let best = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits");
    let all = reports.load(Relaxed);
    for after in (0..all).step_by(all / 7).chain([all - 1]) {
        let (mut problem, _) = stopping(after);
        let solved = solve(&mut problem, Guess::Straight.starts(6), &OPTIONS, &mut silent).expect("fits");
        assert_eq!((solved.outcome.reason, solved.attempts.len()), (Reason::Interrupted, 1), "{after} of {all}: {solved}");
    }
    let (mut problem, _) = stopping(all + 100);
    let solved = solve(&mut problem, Guess::Straight.starts(100), &OPTIONS, &mut silent).expect("fits");
    assert_eq!((solved.outcome.value, solved.outcome.reason), (best.outcome.value, Reason::Stationary));
    let others = &solved.attempts[1..];
    assert!((1..10).contains(&others.len()) && others.iter().all(|of| of.reason == Reason::Interrupted), "{solved}");
}

/// A cost at the end, and no constraint.
#[test]
fn a_terminal_cost_is_that_of_the_end_alone() {
    let build = || {
        let mut cart = CartPendulum::with_links(1).mechanism();
        cart.scene.effort("effort", cart.force, 1e-3);
        let angle = cart.links[0].coordinates[2];
        cart.scene.cost("angle", AngleError, Sum::Terminal, [angle], [], [], [FRAC_PI_2.into()]);
        let system = cart.scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
        let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force)]).expect("free");
        MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem")
    };
    let (mut one, mut other) = (build(), build());
    let start = one.start();
    let direct = interior_point(&mut one, &start, &OPTIONS, &mut silent).expect("fits");
    let solved = solve(&mut other, Guess::Straight, &OPTIONS, &mut silent).expect("fits").outcome;
    println!("{direct}\n{solved}");
    assert!(direct.reason.is_converged() && solved.reason.is_converged());
    assert!((direct.value - solved.value).abs() < 1e-6 * direct.value, "{} {}", direct.value, solved.value);
}
