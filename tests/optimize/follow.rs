//! Inverse dynamics of whole motions: controls with which outputs follow given values at nodes.

use super::near::Place;
use super::solve::OPTIONS;
use hamiltonian_adjoint::optimize::{Free, Guess, Interval, MotionProblem, Problem, Quantity, Variables, silent, solve};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Control, Grid, Inputs, Output, Scene, Settings, System};
use std::f64::consts::FRAC_PI_2;

/// A motion of the second of two masses with a spring between them, and the force on the first one that it needs.
struct Behind {
    system: System,
    force: Control,
    places: Vec<Output>,
    /// Of both masses at the end.
    rates: [Output; 2],
}

const DURATION: f64 = 2.0;
/// N/m, kg.
const STIFFNESS: f64 = 60.0;
const MASSES: [f64; 2] = [1.0, 0.5];

/// sin⁶ and its derivatives of orders 0, 2 and 4 by time, at t.
fn rise(t: f64) -> [f64; 3] {
    let w = FRAC_PI_2 / DURATION;
    // sin⁶ x = (10 − 15 cos 2x + 6 cos 4x − cos 6x)/32
    let of = |order: i32| {
        let sum: f64 = [(-15.0, 2.0), (6.0, 4.0), (-1.0, 6.0)]
            .iter()
            .map(|(c, k)| c * (k * w).powi(order) * if order == 2 { -1.0 } else { 1.0 } * (k * w * t).cos())
            .sum();
        (sum + if order == 0 { 10.0 } else { 0.0 }) / 32.0
    };
    [of(0), of(2), of(4)]
}

fn behind(every: usize, steps: usize) -> Behind {
    let mut scene = Scene::new();
    let masses = [0, 1].map(|k| scene.particle(&format!("mass {k}"), MASSES[k], [k as f64, 0.0]));
    let force = scene.control("force");
    scene.spring_damper("spring", masses[0].point(), masses[1].point(), STIFFNESS, 1.0, 0.0);
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, masses[0].point(), force);
    scene.effort("effort", force, 1e-4);
    let nodes = (every..=steps).step_by(every);
    let places = scene.outputs_at("place", Place, nodes, [masses[1].coordinates[0]], [], [], []);
    let rates = masses.map(|mass| scene.end_state(mass.coordinates[0]).rate);
    Behind { system: scene.compile().expect("a scene"), force, places, rates }
}

impl Behind {
    /// The problem with the force on so many knots.
    fn problem(&self, inputs: &Inputs, knots: usize) -> MotionProblem {
        let free = vec![Free::new(Quantity::SplineControl(self.force, knots))];
        let variables = Variables::new(&self.system, inputs, free).expect("free");
        MotionProblem::new(&self.system, Settings::default(), inputs.clone(), variables).expect("a problem")
    }
}

#[test]
fn a_mass_behind_a_spring_follows() {
    let most = |steps: usize, every: usize| {
        let of = behind(every, steps);
        let dt = DURATION / steps as f64;
        let mut problem = of.problem(&Inputs::at_rest(&of.system, Grid::uniform(steps, dt)), steps / every + 2);
        for (k, place) in of.places.iter().enumerate() {
            problem.constrain(*place, Interval::equal(1.0 + 0.5 * rise(dt * ((k + 1) * every) as f64)[0]));
        }
        problem.constrain_all(&of.rates, Interval::ZERO);
        let solved = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits");
        println!("{solved}");
        let found = &solved.outcome;
        // The multipliers are above 1e5: the force hardly moves the next places.
        assert!(found.reason.is_converged() && found.iterations <= 3 && found.violation < 1e-8, "{solved}");
        let controls = problem.inputs_at(&found.x).controls;
        let exact = |t: f64| {
            let [_, r2, r4] = rise(t).map(|x| 0.5 * x);
            MASSES[0] * (r2 + MASSES[1] * r4 / STIFFNESS) + MASSES[1] * r2
        };
        (0..=steps).map(|k| (controls[(0, k)] - exact(k as f64 * dt)).abs()).fold(0.0, f64::max)
    };
    let [coarse, fine, fewer] = [(80, 2), (160, 2), (160, 4)].map(|(steps, every)| most(steps, every));
    println!("{coarse:.2e} {fine:.2e} {fewer:.2e} of 2.6 N");
    assert!(fine < 1e-3 && fewer < 1e-3, "{fine:.1e} {fewer:.1e}");
    assert!((3.5..4.5).contains(&(coarse / fine)), "{coarse:.1e} {fine:.1e}");
}

#[test]
fn a_motion_returns_its_controls() {
    let (steps, every) = (60, 2);
    let of = behind(every, steps);
    let knots = steps / every + 2;
    let mut problem = of.problem(&Inputs::at_rest(&of.system, Grid::uniform(steps, 0.02)), knots);
    let given: Vec<f64> = (0..knots).map(|k| 5.0 * (0.7 * k as f64).sin()).collect();
    let mut outputs = vec![0.0; problem.constraints().len()];
    let start = problem.start();
    problem.evaluate(&given, &mut outputs).expect("a motion");
    let controls = problem.inputs_at(&given).controls;
    problem.evaluate(&start, &mut vec![0.0; outputs.len()]).expect("a motion");
    let asked = of.places.iter().chain(&of.rates);
    asked.for_each(|output| problem.constrain(*output, Interval::equal(outputs[output.index()])));
    let solved = solve(&mut problem, Guess::Straight, &OPTIONS, &mut silent).expect("fits");
    println!("{solved}");
    let far = (problem.inputs_at(&solved.outcome.x).controls - &controls).amax();
    assert!(solved.outcome.reason.is_converged() && far < 1e-5, "{far:.1e} {solved}");
}
