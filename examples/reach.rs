//! An arm with two motors reaches for a point with the least effort, while its elbow stays between two angles; then for a point nearby, and for one
//! out of reach.
//!
//! `cargo run --release --example reach`

use std::error::Error;
use std::f64::consts::FRAC_PI_2;

use hamiltonian_adjoint::optimize::{
    Free, Guess, Interval, MotionProblem, Options, Parameter, Variables, sensitivities, silent, solve,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Output, Scalar, Scene, Settings, Sum};
use nalgebra::SVector;

/// Lengths, m, and masses, kg, of the links.
const LINKS: [(f64, f64); 2] = [(0.6, 1.5), (0.4, 1.0)];
const STEPS: usize = 100;
/// s.
const DURATION: f64 = 1.0;
/// The largest torque, N m, and the limits of the elbow, rad.
const MOST: f64 = 25.0;
const ELBOW: Interval = Interval { least: 0.0, most: 2.5 };

/// The tip in the direction of an angle: its abscissa for 0, its ordinate for π/2.
struct Tip(f64);

impl Cost<2> for Tip {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        (at.q[0] - self.0).cos() * LINKS[0].0 + (at.q[1] - self.0).cos() * LINKS[1].0
    }
}

/// The angle between the links.
struct Elbow;

impl Cost<2> for Elbow {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[1] - at.q[0]
    }
}

/// The problem without a target, and the outputs for the tip.
fn arm() -> Result<(MotionProblem, [Output; 2]), Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (mut y, mut before, mut parent) = (0.0, Body::GROUND.at(0.0, 0.0), Body::GROUND);
    let (mut angles, mut free) = (Vec::new(), Vec::new());
    for (name, (length, mass)) in ["upper", "lower"].into_iter().zip(LINKS) {
        // Both links hang at the start; places are those of their centres.
        let body = scene.body(name, mass, mass * length * length / 12.0, [0.0, y - 0.5 * length, -FRAC_PI_2]);
        scene.revolute(&format!("joint of {name}"), before, body.at(-0.5 * length, 0.0));
        let torque = scene.control(&format!("torque on {name}"));
        scene.torque_actuator(&format!("motor of {name}"), parent, body, torque);
        scene.effort(&format!("effort of {name}"), torque, 1.0);
        free.push(Free::control(torque).within(-MOST, MOST));
        angles.push(body.coordinates[2]);
        (y, before, parent) = (y - length, body.at(0.5 * length, 0.0), body.into());
    }
    let rates = [0, 1].map(|k| scene.end_state(angles[k]).rate);
    let tip = [("tip x", 0.0), ("tip y", FRAC_PI_2)].map(|(name, direction)| {
        let output = scene.output(name);
        scene.term(output, name, Tip(direction), Sum::Terminal, [angles[0], angles[1]], [], [], []);
        output
    });
    let elbow = scene.outputs_at("elbow", Elbow, 0..=STEPS, [angles[0], angles[1]], [], [], []);
    let system = scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, DURATION / STEPS as f64));
    let variables = Variables::new(&system, &inputs, free)?;
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
    problem.constrain_all(&rates, Interval::ZERO);
    problem.constrain_all(&elbow, ELBOW);
    Ok((problem, tip))
}

fn aim(problem: &mut MotionProblem, tip: [Output; 2], at: [f64; 2]) {
    println!("The tip comes to rest at {at:?} m:");
    tip.iter().zip(at).for_each(|(output, to)| problem.constrain(*output, Interval::equal(to)));
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut problem, tip) = arm()?;
    let options = Options::default();

    aim(&mut problem, tip, [0.5, 0.3]);
    let found = solve(&mut problem, Guess::Straight, &options, &mut silent)?;
    println!("{found}");
    let by = tip.map(Parameter::Target);
    let slopes = sensitivities(&mut problem, &found.outcome, &by, &options)?;
    let by_place = [slopes[0].value, slopes[1].value];
    println!("dJ = {:.1} dx + {:.1} dy (N² m² s for m)\n", by_place[0], by_place[1]);

    // From the minimum that is known, a few iterations suffice.
    aim(&mut problem, tip, [0.501, 0.3]);
    let next = solve(&mut problem, Guess::from(&found.outcome), &options, &mut silent)?;
    println!("{next}J changes by {:.4}, foretold {:.4}\n", next.outcome.value - found.outcome.value, 1e-3 * by_place[0]);

    aim(&mut problem, tip, [1.2, 0.0]);
    println!("{}", solve(&mut problem, Guess::Straight, &options, &mut silent)?);
    Ok(())
}
