//! Loads on ropes: states at the end that the constraints do not determine, and coordinates that ropes limit.

use hamiltonian_adjoint::optimize::{Free, Guess, Interval, MotionProblem, Options, Solved, Variables, silent, solve};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::spatial::{self, Inertia};
use hamiltonian_adjoint::{Control, Coordinate, Grid, Inputs, Scene, Settings};

const STEPS: usize = 40;

/// A trolley moves by a distance (m) in 2 s; it and the loads that hang from it, which may be anywhere, are then at rest.
fn solved(
    mut scene: Scene,
    force: Control,
    trolley: (Coordinate, f64),
    loads: &[Coordinate],
    heights: &[(Coordinate, f64)],
) -> Solved {
    scene.effort("effort", force, 1e-2);
    let place = scene.end_state(trolley.0);
    let resting: Vec<_> = loads.iter().map(|load| scene.end_state(*load).rate).collect();
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, 2.0 / STEPS as f64));
    heights.iter().for_each(|(of, to)| inputs.start.q_mut()[of.index()] = *to);
    let variables = Variables::new(&system, &inputs, vec![Free::control(force)]).expect("it fits");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("they fit");
    problem.constrain(place.position, Interval::equal(trolley.1));
    problem.constrain(place.rate, Interval::ZERO);
    problem.constrain_all(&resting, Interval::ZERO);
    solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits")
}

fn assert_is_found_at_once(what: &str, solved: &Solved) {
    println!("{what}: {solved}");
    assert!(solved.outcome.reason.is_converged() && solved.attempts.len() == 1, "{what}: {solved}");
    assert!(solved.outcome.iterations <= 8, "{what}: {solved}");
}

/// The nearest state in which the trolley has arrived leaves the load behind. Segments from there were not solved, and states in which the trolley
/// had gone farther than the ropes reach were sought for seconds.
#[test]
fn particles_on_ropes_end_below_their_trolley() {
    for (count, distance) in [(1, 0.3), (1, 1.0), (1, 3.0), (3, 1.0), (5, 1.0)] {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let trolley = scene.body("trolley", 1.0, 0.1, [0.0; 3]);
        scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, trolley.at(0.0, 0.0), 0.0);
        let (mut above, mut loads) = (trolley.at(0.0, 0.0), Vec::new());
        for k in 0..count {
            let load = scene.particle(&format!("load {k}"), 0.3, [0.0, -0.5 * f64::from(k + 1)]);
            scene.distance(&format!("rope {k}"), above, load.point(), 0.5);
            loads.push(load.coordinates[0]);
            above = load.point();
        }
        let force = scene.control("force");
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, trolley.at(0.0, 0.0), force);
        let solved = solved(scene, force, (trolley.coordinates[0], distance), &loads, &[]);
        assert_is_found_at_once(&format!("{count} loads, {distance} m"), &solved);
    }
}

/// As in the plane, with bodies that may turn about their ropes.
#[test]
fn bodies_on_ropes_in_space_end_below_their_trolley() {
    for count in [1, 2] {
        let mut scene = Scene::new();
        let force = scene.control("force");
        let mut space = scene.spatial();
        space.gravity([0.0, 0.0, -9.81]);
        let along_x = |body: spatial::Body| body.origin().along([1.0, 0.0, 0.0]);
        let trolley = space.body("trolley", Inertia::new(2.0, [0.02, 0.02, 0.04, 0.0, 0.0, 0.0]));
        let rail = space.prismatic("rail", along_x(spatial::Body::GROUND), along_x(trolley));
        let (mut above, mut z) = (trolley.origin(), 0.0);
        let (mut loads, mut heights) = (Vec::new(), Vec::new());
        for k in 0..count {
            let body = space.body(&format!("load {k}"), Inertia::new(0.5, [0.005, 0.005, 0.005, 0.0, 0.0, 0.0]));
            let free = space.free(&format!("place {k}"), spatial::Body::GROUND.origin(), body.origin());
            space.distance(&format!("rope {k}"), above, body.at([0.0, 0.0, 0.1]), 0.6);
            loads.push(free.position[0]);
            heights.push((free.position[2], z - 0.7));
            (above, z) = (body.at([0.0, 0.0, -0.1]), z - 0.8);
        }
        scene.motor("motor", rail.offset, force);
        let solved = solved(scene, force, (rail.offset, 1.0), &loads, &heights);
        assert_is_found_at_once(&format!("{count} loads"), &solved);
    }
}
