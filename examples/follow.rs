//! Inverse dynamics of an arm with elastic joints: torques of the motors for which the tip of the arm follows a given path in given time.
//!
//! Springs are between the motors and the links, so that no torques determine the accelerations of the links. The torques are splines, which are found for
//! the whole motion: the tip is on its path at every fourth node, and motors and links come to rest.
//!
//! `cargo run --release --example follow`

use std::error::Error;

use hamiltonian_adjoint::optimize::{Free, Guess, Interval, MotionProblem, Options, Quantity, Variables, silent, solve};
use hamiltonian_adjoint::planar::{Body, Point};
use hamiltonian_adjoint::{Control, Coordinate, Grid, Inputs, Mechanics, Scene, Settings};

/// Lengths, m, masses, kg, and stiffnesses of the joints, N m/rad, of the links; moments of inertia of the rotors, kg m².
const LINKS: [(f64, f64, f64); 2] = [(0.4, 2.0, 200.0), (0.3, 1.0, 100.0)];
const ROTORS: [f64; 2] = [0.05, 0.02];
/// Angles of the links at the start, and the displacement of the tip, m, in 1 s.
const ANGLES: [f64; 2] = [0.3, 1.5];
const ALONG: [f64; 2] = [-0.25, 0.1];
const STEPS: usize = 200;
const DT: f64 = 1.0 / STEPS as f64;
/// The tip is prescribed at every so many nodes.
const EVERY: usize = 4;

/// The part of the path at a time from 0 to 1 s. Six derivatives vanish at both ends: the torque at the elbow turns the link before, too, and appears in the
/// sixth derivative of the tip's position through the spring at the shoulder.
fn part(t: f64) -> f64 {
    let binomials = [1.0, 7.0, 28.0, 84.0, 210.0, 462.0, 924.0];
    t.powi(7) * binomials.iter().rev().fold(0.0, |sum, c| sum * (1.0 - t) + c)
}

/// The arm, with its links and rotors, motors and springs.
struct Arm {
    scene: Scene,
    torques: Vec<Control>,
    /// The angles of the links, and of the rotors.
    links: Vec<Coordinate>,
    rotors: Vec<Coordinate>,
    tip: Point,
    /// The position of the tip at the start, m.
    start: [f64; 2],
}

fn arm() -> Arm {
    let mut scene = Scene::new();
    let (mut start, mut tip, mut parent) = ([0.0, 0.0], Body::GROUND.at(0.0, 0.0), Body::GROUND);
    let (mut torques, mut links, mut rotors) = (Vec::new(), Vec::new(), Vec::new());
    for (name, ((length, mass, stiffness), (inertia, angle))) in
        ["shoulder", "elbow"].into_iter().zip(LINKS.into_iter().zip(ROTORS.into_iter().zip(ANGLES)))
    {
        let ([x, y], along) = (start, [angle.cos(), angle.sin()].map(|e| length * e));
        let middle = [x + 0.5 * along[0], y + 0.5 * along[1], angle];
        let link = scene.body(&format!("link after the {name}"), mass, mass * length * length / 12.0, middle);
        let rotor = scene.body(&format!("rotor at the {name}"), 0.3, inertia, [x, y, angle]);
        scene.revolute(name, tip, link.at(-0.5 * length, 0.0));
        scene.revolute(&format!("bearing at the {name}"), tip, rotor.at(0.0, 0.0));
        scene.torsional_spring_damper(&format!("gear at the {name}"), rotor, link, stiffness, 0.0, 0.0);
        let torque = scene.control(&format!("torque at the {name}"));
        scene.torque_actuator(&format!("motor at the {name}"), parent, rotor, torque);
        scene.effort(&format!("effort at the {name}"), torque, 1e-3);
        torques.push(torque);
        links.push(link.coordinates[2]);
        rotors.push(rotor.coordinates[2]);
        (start, tip, parent) = ([x + along[0], y + along[1]], link.at(0.5 * length, 0.0), link.into());
    }
    Arm { scene, torques, links, rotors, tip, start }
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arm { mut scene, torques, links, rotors, tip, start } = arm();
    let rates: Vec<_> = links.iter().chain(&rotors).map(|angle| scene.end_state(*angle).rate).collect();
    for (i, (name, direction)) in [("tip x", [1.0, 0.0]), ("tip y", [0.0, 1.0])].into_iter().enumerate() {
        let nodes = (EVERY..=STEPS).step_by(EVERY);
        let path: Vec<_> = nodes.map(|node| (node, start[i] + ALONG[i] * part(DT * node as f64))).collect();
        // The outputs are the deviations from the path, m; they have to vanish.
        scene.point_readings(name, tip, direction, &path, 1.0);
    }
    let system = scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, DT));
    let accelerations = links.iter().map(|angle| (*angle, 0.0)).collect::<Vec<_>>();
    if let Err(error) = Mechanics::at_start(&system, &inputs)?.inverse_dynamics(&accelerations, &torques) {
        println!("Inverse dynamics at the start: {error}\n");
    }

    // As many knots as there are positions on the path, and two for the rates at the end.
    let free = torques.iter().map(|torque| Free::new(Quantity::SplineControl(*torque, STEPS / EVERY + 2)));
    let variables = Variables::new(&system, &inputs, free.collect())?;
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
    problem.constrain_all(&rates, Interval::ZERO);
    let found = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent)?;
    println!("{found}");

    let (controls, motion) = (&problem.inputs_at(&found.outcome.x).controls, problem.solver.trajectory());
    println!("   t, s    torques, N m     twists of the springs, mrad");
    for node in (0..=STEPS).step_by(STEPS / 10) {
        let twist = |j: usize| 1e3 * (motion.q[(rotors[j].index(), node)] - motion.q[(links[j].index(), node)]);
        let [u, v] = [0, 1].map(|j| controls[(j, node)]);
        println!("{:7.2} {u:8.3} {v:8.3} {:12.2} {:8.2}", DT * node as f64, twist(0), twist(1));
    }
    Ok(())
}
