//! Problems of closed mechanisms: a periodic motion of a four-bar linkage, and a slider-crank whose parameters are identified.

use std::f64::consts::TAU;

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::optimize::{
    Fit, Free, Interval, MotionProblem, Options as MethodOptions, Quantity, Trials, Variables, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Cost, CostPoint, Design, Error as MotionError, Grid, Inputs, Scalar, Scene, Settings as SolverSettings, Solver, Start,
    Sum, System,
};
use nalgebra::{DVector, SVector};

use super::problems::Posed;

/// b dq/dt.
struct Rate;

impl Cost<1, 0, 0, 1> for Rate {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        b[0] * at.v[0]
    }
}

/// A body between two points of the plane, with a mass of 1 kg per metre of its length.
fn rod(scene: &mut Scene, name: &str, from: [f64; 2], to: [f64; 2]) -> (Body, f64) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    let place = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), dy.atan2(dx)];
    (scene.body(name, length, length.powi(3) / 12.0, place), 0.5 * length)
}

/// A crank and rocker under gravity with friction: the torque on the crank and the initial momenta of a periodic motion with one turn in 1 s and
/// the least effort.
pub fn periodic() -> Result<Posed, MotionError> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [a, b, c, d] = [[0.0, 0.0], [0.2, 0.0], [0.55, 0.5], [0.8, 0.0]];
    let (crank, half_crank) = rod(&mut scene, "crank", a, b);
    let (coupler, half_coupler) = rod(&mut scene, "coupler", b, c);
    let (rocker, half_rocker) = rod(&mut scene, "rocker", d, c);
    scene.revolute("A", Body::GROUND.at(a[0], a[1]), crank.at(-half_crank, 0.0));
    scene.revolute("B", crank.at(half_crank, 0.0), coupler.at(-half_coupler, 0.0));
    scene.revolute("C", coupler.at(half_coupler, 0.0), rocker.at(half_rocker, 0.0));
    scene.revolute("D", Body::GROUND.at(d[0], d[1]), rocker.at(-half_rocker, 0.0));
    scene.joint_friction("friction", Body::GROUND, rocker, 0.02);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, crank, torque);
    let angle = crank.coordinates[2];
    let (end, again) = (scene.end_state(angle), scene.output("as fast as at the start"));
    scene.term(again, "speed at the end", Rate, Sum::Terminal, [angle], [], [], [1.0.into()]);
    scene.term(again, "speed at the start", Rate, Sum::Node(0), [angle], [], [], [(-1.0).into()]);
    scene.effort("effort", torque, 1.0);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    let mut p_star = DVector::zeros(system.n());
    // About the value for a crank that turns once per second.
    p_star[crank.coordinates[2].index()] = 0.1;
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star };
    let constraints = vec![(end.position, Interval::equal(TAU)), (again, Interval::ZERO)];
    let rate = Free::new(Quantity::Rate(crank.coordinates[2])).scaled(0.02);
    let free = vec![Free::control(torque), rate];
    Ok(Posed { system, settings: SolverSettings::default(), inputs, control: torque, free, constraints, lines: &[] })
}

/// The records: their number, the readings per record, the nodes between readings, and the noise in rad.
const RECORDS: usize = 5;
const READINGS: usize = 40;
const EVERY: usize = 5;
const NOISE: f64 = 2e-3;
/// The readings come from a grid with so many times as many steps.
const FINER: usize = 10;
/// s.
const STEP: f64 = 0.01;
/// Mass of the slider in kg, its friction in N s/m, its spring in N/m.
const TRUTH: [f64; 3] = [0.6, 1.5, 40.0];

/// A slider-crank; the mass, friction and spring of its slider are to be identified from the crank's angle.
fn slider_crank(readings: &[f64]) -> Result<(System, [Design; 3], usize), MotionError> {
    let mut scene = Scene::new();
    let parameters = [("mass", 1.0), ("friction", 1.0), ("stiffness", 25.0)].map(|(name, guess)| scene.design(name, guess));
    let [mass, friction, stiffness] = parameters;
    let [a, b, c] = [[0.0, 0.0], [0.09, 0.12], [0.49, -0.18]];
    let (crank, half_crank) = rod(&mut scene, "crank", a, b);
    let (coupler, half_coupler) = rod(&mut scene, "rod", b, c);
    let slider = scene.body("slider", mass, 0.01, [c[0], c[1], 0.0]);
    scene.revolute("A", Body::GROUND.at(0.0, 0.0), crank.at(-half_crank, 0.0));
    scene.revolute("B", crank.at(half_crank, 0.0), coupler.at(-half_coupler, 0.0));
    scene.revolute("C", coupler.at(half_coupler, 0.0), slider.at(0.0, 0.0));
    scene.prismatic("guide", Body::GROUND.at(c[0], c[1]), 0.0, slider.at(0.0, 0.0), 0.0);
    scene.sliding_friction("slider friction", Body::GROUND.at(c[0], c[1]), 0.0, slider.at(0.0, 0.0), friction);
    scene.spring_damper("spring", Body::GROUND.at(1.0, c[1]), slider.at(0.0, 0.0), stiffness, 0.5, 0.0);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, crank, torque);
    let angle = crank.coordinates[2];
    for (k, reading) in readings.iter().enumerate() {
        scene.reading(&format!("reading {k}"), angle, EVERY * (k + 1), *reading, 1.0 / NOISE);
    }
    Ok((scene.compile()?, parameters, angle.index()))
}

/// Times of the readings of each record, s.
pub fn times_of_readings() -> Vec<f64> {
    (1..=READINGS).map(|k| STEP * (EVERY * k) as f64).collect()
}

/// The torque, different in each record, on a grid with so many times as many steps.
fn driven(system: &System, record: usize, finer: usize) -> Inputs {
    let step = STEP / finer as f64;
    let mut inputs = Inputs::at_rest(system, Grid::uniform(finer * EVERY * READINGS, step));
    let (strength, pace) = (0.25 + 0.1 * record as f64, 3.0 + 1.7 * record as f64);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = strength * (step * pace * i as f64 + record as f64).sin());
    inputs
}

/// Number of parameters within two standard errors of their true values, total number of parameters, and the last fit.
pub struct Identified {
    pub within: usize,
    pub of: usize,
    pub fit: Fit,
}

/// Repeats the identification with different noise.
pub fn identify(repeats: usize) -> Result<Identified, MotionError> {
    let (exact, _, angle) = slider_crank(&[])?;
    let mut solver = Solver::new(&exact, SolverSettings::default());
    let mut truth = Vec::new();
    for record in 0..RECORDS {
        let mut inputs = driven(&exact, record, FINER);
        inputs.design.copy_from_slice(&TRUTH);
        let motion = solver.simulate(&inputs)?;
        truth.push((1..=READINGS).map(|k| motion.q[(angle, FINER * EVERY * k)]).collect::<Vec<f64>>());
    }
    let mut random = Random::new(1);
    // Nearly normal distribution: the sum of 12 numbers between −½ and ½.
    let mut normal = || (0..12).map(|_| random.uniform(-0.5, 0.5)).sum::<f64>();
    let (mut within, mut last) = (0, None);
    // Residuals in standard deviations are not small, so the value is exact to some 1e-14 only.
    let options = MethodOptions { stationarity: 1e-6, ..MethodOptions::default() };
    for _ in 0..repeats {
        let noisy = truth.iter().map(|record| record.iter().map(|x| x + NOISE * normal()).collect::<Vec<f64>>());
        let systems = noisy.map(|record| slider_crank(&record)).collect::<Result<Vec<_>, MotionError>>()?;
        let motions = systems.iter().enumerate().map(|(record, (system, parameters, _))| {
            let inputs = driven(system, record, 1);
            let free = parameters.iter().map(|design| Free::design(*design).logarithmic().within(1e-3, 1e3)).collect();
            let variables = Variables::new(system, &inputs, free)?;
            MotionProblem::new(system, SolverSettings::default(), inputs, variables)
        });
        let mut trials = Trials::new(motions.collect::<Result<Vec<_>, MotionError>>()?)?;
        let start = trials.motions()[0].start();
        let fit = levenberg_marquardt(&mut trials, &start, &options, &mut silent)?;
        let errors = fit.standard_errors().unwrap_or_else(|| vec![0.0; TRUTH.len()]);
        let found = fit.outcome.x.iter().zip(TRUTH).zip(errors);
        // Differences of logarithms are relative errors.
        within += found.filter(|((x, truth), error)| (*x - truth.ln()).abs() <= 2.0 * error).count();
        last = Some(fit);
    }
    let fit =
        last.ok_or(MotionError::Parameter { what: "the number of repetitions".into(), value: 0.0, must_be: "1 or more" })?;
    Ok(Identified { within, of: repeats * TRUTH.len(), fit })
}
