//! Targets of a point at the end: how far the guess turns, targets out of reach, and violations that are stationary by symmetry.

use hamiltonian_adjoint::optimize::{
    Free, Guess, Interval, MotionProblem, Options, Parameter, Problem, Reason, Variables, interior_point, sensitivities,
    silent, solve,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::spatial::{self, Inertia, Quantity};
use hamiltonian_adjoint::{Cost, CostPoint, Error, Grid, Inputs, Output, Scalar, Scene, Settings, Sum, Warning};
use nalgebra::SVector;
use std::f64::consts::{FRAC_PI_2, PI};

/// Lengths in m and masses in kg of the links.
const LINKS: [(f64, f64); 2] = [(0.6, 1.5), (0.4, 1.0)];

/// The tip of the arm, to the right or up.
struct Tip {
    is_up: bool,
}

impl Cost<2> for Tip {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        let of = |angle: S| if self.is_up { angle.sin() } else { angle.cos() };
        of(at.q[0]) * LINKS[0].0 + of(at.q[1]) * LINKS[1].0
    }
}

/// The angle between the links.
struct Between;

impl Cost<2> for Between {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[1] - at.q[0]
    }
}

/// A hanging arm of two links with a motor in each joint, whose tip comes to rest at a point after 1 s; the angles at the end.
fn arm(tip: [f64; 2], most: f64) -> (MotionProblem, [Output; 2]) {
    let (mut problem, ends, path) = limited(tip, most);
    problem.constrain_all(&path, Interval::FREE);
    (problem, ends)
}

/// As [`arm`], with the angle between the links at all nodes.
fn limited(tip: [f64; 2], most: f64) -> (MotionProblem, [Output; 2], Vec<Output>) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (mut y, mut before, mut parent) = (0.0, Body::GROUND.at(0.0, 0.0), Body::GROUND);
    let (mut angles, mut free) = (Vec::new(), Vec::new());
    for (k, (length, mass)) in LINKS.into_iter().enumerate() {
        let place = [0.0, y - 0.5 * length, -FRAC_PI_2];
        let body = scene.body(&format!("link {k}"), mass, mass * length * length / 12.0, place);
        scene.revolute(&format!("joint {k}"), before, body.at(-0.5 * length, 0.0));
        let torque = scene.control(&format!("torque {k}"));
        scene.torque_actuator(&format!("motor {k}"), parent, body, torque);
        scene.effort(&format!("effort {k}"), torque, 1.0);
        free.push(Free::control(torque).within(-most, most));
        angles.push(body.coordinates[2]);
        (y, before, parent) = (y - length, body.at(0.5 * length, 0.0), body.into());
    }
    let ends = [0, 1].map(|k| scene.end_state(angles[k]));
    let tips = [("right", false), ("up", true)].map(|(name, is_up)| {
        let output = scene.output(&format!("tip, {name}"));
        scene.term(output, &format!("tip, {name}"), Tip { is_up }, Sum::Terminal, [angles[0], angles[1]], [], [], []);
        output
    });
    let along = scene.output("tip and path");
    scene.term(along, "tip", Tip { is_up: false }, Sum::Terminal, [angles[0], angles[1]], [], [], []);
    scene.term(along, "path", Between, Sum::Integral, [angles[0], angles[1]], [], [], []);
    let path = scene.outputs_at("elbow", Between, 0..=40, [angles[0], angles[1]], [], [], []);
    let middle = [("upper", 0), ("lower", 1)]
        .map(|(name, k)| scene.reading(&format!("{name} at the middle"), angles[k], 20, 0.0, 1.0));
    let system = scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.025));
    let variables = Variables::new(&system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(along, Interval::FREE);
    middle.iter().for_each(|reading| problem.constrain(*reading, Interval::FREE));
    ends.iter().for_each(|end| problem.constrain(end.position, Interval::FREE));
    ends.iter().for_each(|end| problem.constrain(end.rate, Interval::ZERO));
    tips.iter().zip(tip).for_each(|(output, to)| problem.constrain(*output, Interval::equal(to)));
    (problem, ends.map(|end| end.position), path)
}

fn named(problem: &MotionProblem, name: &str) -> Output {
    let system = problem.solver.system();
    let found = (0..system.outputs()).find(|k| system.output_name(*k) == name);
    system.output(found.expect("an output"))
}

#[test]
fn the_guess_turns_links_no_further_than_needed() {
    for tip in [[0.8, 0.45], [0.9, 0.4], [-0.3, 0.5], [0.0, -0.9], [0.2, 0.4]] {
        let (mut problem, ends) = arm(tip, 1e3);
        let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
        let angles = ends.map(|end| found.outcome.constraints[end.index()]);
        println!("{tip:?}: {angles:?}\n{found}");
        assert!(found.outcome.reason == Reason::Stationary && found.attempts.len() == 1, "{tip:?}: {found}");
        // Near the border of the reach, rows have small derivatives.
        assert!(found.outcome.iterations < 100, "{tip:?}: {found}");
        assert!(angles.iter().all(|angle| (angle + FRAC_PI_2).abs() < 1.1 * PI), "{tip:?}: {angles:?}");
    }
}

#[test]
fn a_target_above_a_hanging_arm_is_found() {
    // The violation of the start is stationary by symmetry.
    let (mut problem, _) = arm([0.0, 0.95], 1e3);
    let start = problem.start();
    let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
    println!("{found}");
    assert!(found.outcome.reason == Reason::Stationary && found.attempts.len() == 1, "{found}");
    let one = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
    println!("{one}");
    assert!(one.reason == Reason::Stationary && one.violation < 1e-8, "{one}");
}

#[test]
fn targets_out_of_reach_are_told_without_segments() {
    for (tip, told) in
        [([2.0, 0.0], "`tip, right` is 1 instead of 2, off by 1"), ([0.0, 2.0], "`tip, up` is 1 instead of 2, off by 1")]
    {
        let (mut problem, _) = arm(tip, 1e3);
        let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
        println!("{found}");
        assert!(found.outcome.reason == Reason::Infeasible && found.attempts.len() == 1, "{found}");
        assert!(found.to_string().contains(told), "{found}");
        // Constraints that hold within the tolerance are not listed as violated.
        assert!(found.outcome.violated.iter().all(|of| of.by() > 1e-8), "{:?}", found.outcome.violated);
    }
}

#[test]
fn targets_out_of_reach_in_any_direction_are_told_soon() {
    // The arm is 1 m long and points to the target.
    let cases = [
        ([2.0, 0.1], ["0.999", "0.0499"]),
        ([1.0, 1.0], ["0.707"; 2]),
        ([-1.5, 0.7], ["-0.906", "0.423"]),
        ([0.3, -1.2], ["0.243", "-0.97"]),
    ];
    for (tip, [right, up]) in cases {
        let (mut problem, _) = arm(tip, 40.0);
        let found = solve(&mut problem, Guess::Straight.starts(3), &Options::default(), &mut silent).expect("fits");
        println!("{tip:?} {found}");
        assert!(found.outcome.reason == Reason::Infeasible && found.attempts.len() == 1, "{found}");
        // As many of a feasibility phase are possible.
        assert!(found.attempts[0].iterations <= 200, "{found}");
        let texts =
            ["no state at node 40 (t = 1.0 s)", &format!("`tip, right` is {right} "), &format!("`tip, up` is {up} ")];
        assert!(texts.iter().all(|text| found.to_string().contains(text)), "{found}");
    }
}

#[test]
fn a_target_that_moves_out_of_reach_is_told_from_an_optimum() {
    let (mut problem, _) = arm([0.8, 0.45], 1e3);
    let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits").outcome;
    assert_eq!(found.reason, Reason::Stationary, "{found}");
    let right = named(&problem, "tip, right");
    problem.constrain(right, Interval::equal(1.2));
    let next = solve(&mut problem, Guess::from(&found), &Options::default(), &mut silent).expect("fits");
    println!("{next}");
    assert!(next.outcome.reason == Reason::Infeasible && next.attempts.len() == 2, "{next}");
    assert!(next.to_string().contains("no state at node 40"), "{next}");
}

#[test]
fn of_failed_attempts_the_best_one_is_returned() {
    // Motors too weak to lift the arm.
    let (mut problem, _) = arm([0.2, 0.9], 1.0);
    let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
    println!("{found}");
    assert!(!found.outcome.reason.is_converged() && found.attempts.len() > 1, "{found}");
    let is_told = found.outcome.reason == Reason::Infeasible;
    let least = found.attempts.iter().fold(f64::INFINITY, |least, of| least.min(of.violation));
    assert!(is_told || found.outcome.violation == least, "{found}");
    let mut constraints = vec![0.0; problem.constraints().len()];
    problem.evaluate(&problem.start(), &mut constraints).expect("a motion");
    assert_eq!(problem.start(), found.outcome.x);
}

#[test]
fn an_outcome_without_convergence_has_no_derivatives() {
    let (mut problem, _) = arm([0.8, 0.45], 1e3);
    let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits").outcome;
    let by = [Parameter::Bound(0)];
    sensitivities(&mut problem, &found, &by, &Options::default()).expect("a minimum");
    let stopped = hamiltonian_adjoint::optimize::Outcome { reason: Reason::Iterations, ..found };
    let error = sensitivities(&mut problem, &stopped, &by, &Options::default()).expect_err("no minimum");
    println!("{error}");
    assert!(matches!(error, Error::NoMinimum { .. }), "{error}");
}

#[test]
fn limits_at_nodes_that_contradict_the_ends_are_told_without_segments() {
    // With an elbow between 1 and 3 rad, the tip is at most 0.87 m from the shoulder; at the start, the elbow is straight.
    let cases = [
        ([0.9, 0.0], 1..41, Interval::new(1.0, 3.0), "tip, right"),
        ([0.6, 0.3], 0..41, Interval::at_least(0.1), "at node 0"),
    ];
    for (tip, nodes, to, told) in cases {
        let (mut problem, _, path) = limited(tip, 1e3);
        problem.constrain_all(&path, Interval::FREE);
        problem.constrain_all(&path[nodes], to);
        let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
        println!("{found}");
        assert!(found.outcome.reason == Reason::Infeasible && found.attempts.len() == 1, "{found}");
        assert!(found.to_string().contains(told), "{found}");
        let is_told = |of: &Warning| matches!(of, Warning::NoState { node, .. } if (*node == 0) == told.contains("node 0"));
        assert!(found.outcome.warnings.iter().any(is_told), "{found}");
    }
}

/// At one node between the ends, the elbow must be bent more than the angles of both links allow.
#[test]
fn limits_at_one_node_that_contradict_each_other_are_named() {
    for (bent, is_told) in [(1.4, true), (0.7, false)] {
        let (mut problem, _, path) = limited([0.6, 0.3], 1e3);
        let middle = ["upper at the middle", "lower at the middle"].map(|name| named(&problem, name));
        problem.constrain_all(&middle, Interval::new(-1.5, -0.5));
        problem.constrain_all(&path, Interval::FREE);
        problem.constrain(path[20], Interval::at_least(bent));
        let found = solve(&mut problem, Guess::Straight.starts(3), &Options::default(), &mut silent).expect("fits");
        println!("{found}");
        let Some(Warning::NoState { node, violations, .. }) = found.outcome.warnings.first() else {
            assert!(!is_told && found.outcome.reason == Reason::Stationary, "{found}");
            continue;
        };
        assert!(is_told && *node == 20 && violations.len() == 3, "{found}");
        assert!(found.outcome.reason == Reason::Infeasible && found.attempts.len() == 1, "{found}");
        assert!(found.to_string().contains("no state at node 20 (t = 0.5 s)"), "{found}");
    }
}

/// A crank of 0.2 m, a coupler of 0.6 m and a rocker of 0.5 m, whose pivots are 0.7 m apart, with a motor at the crank; the angle of the rocker after
/// 1 s, at rest, and at the node in the middle.
fn crank_and_rocker(angle: f64) -> (MotionProblem, Output) {
    // The crank points to the pivot of the rocker, which lies at distances of 0.5 m from there and of 0.6 m from the rocker's other end.
    let (crank, coupler, rocker, base) = (0.2f64, 0.6f64, 0.5f64, 0.7f64);
    let apart = base - crank;
    let along = (coupler * coupler + apart * apart - rocker * rocker) / (2.0 * apart);
    let height = (coupler * coupler - along * along).sqrt();
    let ends = [[0.0, 0.0], [crank, 0.0], [crank + along, height], [base, 0.0]];
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rods = [("crank", [0, 1]), ("coupler", [1, 2]), ("rocker", [3, 2])];
    let [a, b, c] = rods.map(|(name, [from, to])| {
        let ([x, y], [dx, dy]) = (ends[from], [0, 1].map(|i| ends[to][i] - ends[from][i]));
        let half = 0.5 * dx.hypot(dy);
        (scene.body(name, 1.0, 0.03, [x + 0.5 * dx, y + 0.5 * dy, dy.atan2(dx)]), half)
    });
    scene.revolute("A", Body::GROUND.at(0.0, 0.0), a.0.at(-a.1, 0.0));
    scene.revolute("B", a.0.at(a.1, 0.0), b.0.at(-b.1, 0.0));
    scene.revolute("C", b.0.at(b.1, 0.0), c.0.at(c.1, 0.0));
    scene.revolute("D", Body::GROUND.at(base, 0.0), c.0.at(-c.1, 0.0));
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, a.0, torque);
    scene.effort("effort", torque, 1.0);
    let end = scene.end_state(c.0.coordinates[2]);
    let middle = scene.reading("rocker at the middle", c.0.coordinates[2], 20, 0.0, 1.0);
    let system = scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.025));
    let variables = Variables::new(&system, &inputs, vec![Free::control(torque)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(end.position, Interval::equal(angle));
    problem.constrain(end.rate, Interval::ZERO);
    problem.constrain(middle, Interval::FREE);
    (problem, middle)
}

/// Where crank and coupler are in line, the rocker turns back: at 1.714 and at 2.547 rad.
#[test]
fn angles_that_a_closed_loop_does_not_reach_are_told() {
    let cases = [
        (0.5, None, Some((40, "is 1.71"))),
        (3.0, None, Some((40, "is 2.55"))),
        (2.1, Some(3.0), Some((20, "is 2.55"))),
        (2.1, Some(0.5), Some((20, "is 1.71"))),
        (2.1, Some(2.0), None),
    ];
    for (angle, at_middle, told) in cases {
        let (mut problem, middle) = crank_and_rocker(angle);
        if let Some(at) = at_middle {
            problem.constrain(middle, Interval::equal(at));
        }
        let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
        println!("{angle} {at_middle:?} {found}");
        let Some((at, told)) = told else {
            assert_eq!(found.outcome.reason, Reason::Stationary, "{found}");
            continue;
        };
        let Some(Warning::NoState { node, violations, .. }) = found.outcome.warnings.first() else { panic!("{found}") };
        assert!(*node == at && violations.len() == 1 && violations[0].contains(told), "{violations:?}");
        assert!(found.outcome.reason == Reason::Infeasible && found.attempts.len() == 1, "{found}");
    }
}

/// Near the vertical, the tip of a rod hardly rises at first.
#[test]
fn a_rod_in_space_turns_no_further_than_needed() {
    for place in [0.0, 0.003, 0.01, 0.1] {
        let mut scene = Scene::new();
        let torque = scene.control("torque");
        let mut space = scene.spatial();
        space.gravity([0.0, 0.0, -9.81]);
        let rod = space.body("rod", Inertia::principal(0.8, [0.02, 0.02, 0.001]).centred_at([0.0, 0.0, -0.25]));
        let y = [0.0, 1.0, 0.0];
        let hinge = space.revolute("hinge", spatial::Body::GROUND.at([0.0, 0.0, 1.0]).along(y), rod.origin().along(y));
        let [_, _, height] = space.outputs("tip", Quantity::Position, rod.at([0.0, 0.0, -0.5]), Sum::Terminal);
        scene.motor("motor", hinge.angle, torque);
        scene.effort("effort", torque, 1.0);
        scene.place(hinge.angle, place);
        let end = scene.end_state(hinge.angle);
        let system = scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(60, 0.02));
        let variables = Variables::new(&system, &inputs, vec![Free::control(torque)]).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
        (0..system.outputs()).for_each(|k| problem.constrain(system.output(k), Interval::FREE));
        problem.constrain(height, Interval::equal(1.2));
        let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits").outcome;
        let angle = found.constraints[end.position.index()];
        println!("{place}: {angle} {found}");
        assert!(found.reason.is_converged() && angle.abs() < PI && found.value < 1.0, "{place}: {angle} {found}");
    }
}

#[test]
fn the_guess_satisfies_limits_at_the_last_node() {
    for to in [Interval::new(-3.0, -0.2), Interval::new(0.2, 3.0)] {
        let (mut problem, ends, path) = limited([0.5, 0.3], 1e3);
        problem.constrain_all(&path, Interval::FREE);
        problem.constrain_all(&path[40..], to);
        let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
        println!("{found}");
        let angles = ends.map(|end| found.outcome.constraints[end.index()]);
        let elbow = angles[1] - angles[0];
        assert!(found.outcome.reason == Reason::Stationary && found.attempts.len() == 1, "{found}");
        assert!(elbow >= to.least - 1e-8 && elbow <= to.most + 1e-8, "{angles:?}");
    }
}

#[test]
fn limits_that_the_start_touches_do_no_harm() {
    // The elbow is straight at the start, at the limit, and must not bend backwards.
    let (mut problem, _, path) = limited([0.5, 0.3], 25.0);
    problem.constrain_all(&path, Interval::new(0.0, 2.5));
    let stated = problem.constraints();
    let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
    println!("{found}");
    assert!(found.outcome.reason == Reason::Stationary && found.attempts.len() == 1, "{found}");
    let next = solve(&mut problem, Guess::from(&found.outcome), &Options::default(), &mut silent).expect("fits");
    assert!(next.outcome.iterations < 4 && next.attempts.len() == 1, "{next}");
    let by = sensitivities(&mut problem, &found.outcome, &[Parameter::Bound(0)], &Options::default()).expect("a minimum");
    assert!(by[0].value.is_finite() && by[0].x.iter().all(|x| x.is_finite()), "{by:?}");
    assert_eq!(problem.constraints(), stated);
}

#[test]
fn given_states_are_tried_although_no_end_was_found() {
    let (mut problem, _) = arm([0.6, 0.3], 1e3);
    let system = problem.solver.system().clone();
    // No state at the end tells whether an output that depends on the path, too, can have a value.
    let along = named(&problem, "tip and path");
    problem.constrain(along, Interval::equal(2.0));
    let guess = Guess::States {
        q: nalgebra::DMatrix::from_fn(system.n(), 41, |i, _| system.initial_coordinates()[i]),
        v: nalgebra::DMatrix::zeros(system.n(), 41),
    };
    let few = Options { iterations: 5, ..Options::default() };
    let found = solve(&mut problem, guess, &few, &mut silent).expect("fits");
    println!("{found}");
    assert!(found.attempts[0].what.ends_with("segments"), "{found}");
}
