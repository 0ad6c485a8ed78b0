//! A body in space that four rotors carry, whose thrusts cannot be negative.

use hamiltonian_adjoint::optimize::{Free, Guess, Interval, MotionProblem, Options, Variables, silent, solve};
use hamiltonian_adjoint::spatial::{Body, Inertia, Quantity};
use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, Sum};

const STEPS: usize = 40;

/// A body of some mass (kg) from rest to rest, 0.8 m to the side and 1.1 m forward in 1.2 s, with the tip of one arm at some height at every fourth node.
fn flight(mass: f64, thrust: Interval, height: Interval) -> MotionProblem {
    let mut scene = Scene::new();
    let yaw = scene.control("yaw");
    let names = [0, 1, 2, 3].map(|i| format!("rotor {i}"));
    let rotors = names.each_ref().map(|name| scene.control(name));
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let body = space.body("body", Inertia::new(mass, [0.01 * mass, 0.01 * mass, 0.02 * mass, 0.0, 0.0, 0.0]));
    space.free("flight", Body::GROUND.origin(), body.origin());
    let arms = [[0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [-0.2, 0.0, 0.0], [0.0, -0.2, 0.0]];
    let place = space.outputs("place", Quantity::Position, body.origin(), Sum::Terminal);
    let mut zero = space.outputs("velocity", Quantity::Velocity, body.origin(), Sum::Terminal).to_vec();
    zero.extend(space.rotation_error("rotation", Body::GROUND.origin(), body.origin(), Sum::Terminal));
    zero.extend(space.outputs("spin", Quantity::AngularVelocity, body.origin(), Sum::Terminal));
    let heights: Vec<_> = (1..STEPS)
        .step_by(4)
        .map(|node| space.outputs(&format!("tip at {node}"), Quantity::Position, body.at(arms[0]), Sum::Node(node)))
        .collect();
    space.torque("yawing", Body::GROUND.origin(), body.origin(), yaw);
    for ((name, rotor), arm) in names.iter().zip(rotors).zip(arms) {
        space.thrust(name, body.at(arm), rotor);
    }
    names.iter().zip(rotors).for_each(|(name, rotor)| scene.effort(name, rotor, 1e-2 / mass.powi(2)));
    scene.effort("effort of yaw", yaw, mass.powi(-2));
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, 0.03));
    let of = |rotor| Free::control(rotor).within(thrust.least, thrust.most);
    let free = rotors.into_iter().map(of).chain([Free::control(yaw).within(-mass, mass)]).collect();
    let variables = Variables::new(&system, &inputs, free).expect("they fit");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("they fit");
    place.iter().zip([0.8, 1.1, 0.0]).for_each(|(output, to)| problem.constrain(*output, Interval::equal(to)));
    problem.constrain_all(&zero, Interval::ZERO);
    for [x, y, z] in heights {
        problem.constrain_all(&[x, y], Interval::FREE);
        problem.constrain(z, height);
    }
    problem
}

/// Thrusts of 0 N at the start lie at their bounds. They were moved inside by so little that steps in segments stayed short; none of them led to
/// feasible motions.
#[test]
fn controls_that_begin_at_their_bounds_do_not_block_segments() {
    for thrust in [Interval::new(0.0, 8.0), Interval::new(0.0, 100.0), Interval::at_least(0.0), Interval::new(1e-6, 8.0)] {
        for height in [Interval::FREE, Interval::new(-0.05, 0.15)] {
            let mut problem = flight(1.0, thrust, height);
            let solved = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
            println!("{thrust:?} {height:?}: {solved}");
            assert!(solved.outcome.reason.is_converged() && solved.attempts.len() == 1, "{thrust:?} {height:?}: {solved}");
            assert!(solved.outcome.iterations <= 60, "{thrust:?} {height:?}: {solved}");
        }
    }
}

/// Nothing but the scene tells how large thrusts without an upper bound have to be: 1,000 kg need 2.5 kN, 1 g needs 2.5 mN.
#[test]
fn controls_with_a_single_bound_begin_with_the_size_that_the_scene_needs() {
    for mass in [1e3, 1e-3] {
        let mut problem = flight(mass, Interval::at_least(0.0), Interval::FREE);
        let solved = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
        println!("{mass} kg: {solved}");
        assert!(solved.outcome.reason.is_converged() && solved.attempts.len() == 1, "{mass} kg: {solved}");
        assert!(solved.outcome.iterations <= 30, "{mass} kg: {solved}");
    }
}
