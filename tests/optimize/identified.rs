//! Parameters of random machines, found from readings of motions on a much finer grid: their standard errors include the grid's share.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::optimize::{
    Fit, Free, Interval, MotionProblem, Options, Problem, Trials, Variables, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Coordinate, Design, Error, Grid, Inputs, Scene, Settings, System, Warning, simulate};
use nalgebra::DVector;
use std::f64::consts::FRAC_PI_2;

use super::common::assert_says;

const STEPS: usize = 60;
const DURATION: f64 = 3.0;
/// Every third node has a reading.
const EVERY: usize = 3;
/// The readings come from a grid with so many times as many steps.
const FINER: usize = 20;
/// The standard deviation of a reading, rad or m.
const NOISE: f64 = 1e-3;

/// A scene, its parameters with their guesses, and the coordinate that is read; it has one control.
type Machine = fn(&mut Scene) -> ([Design; 3], Coordinate);

fn pendulum(scene: &mut Scene) -> ([Design; 3], Coordinate) {
    hanging_rod(scene, [0.2, 2.0])
}

/// A rod that hangs on a spring, with friction, and with these friction and stiffness.
pub fn hanging_rod(scene: &mut Scene, [friction, stiffness]: [f64; 2]) -> ([Design; 3], Coordinate) {
    scene.gravity(0.0, -9.81);
    let (mass, friction) = (scene.design("mass", 1.0), scene.design("friction", friction));
    let stiffness = scene.design("stiffness", stiffness);
    let rod = scene.body("rod", mass, mass * (1.0 / 12.0), [0.0, -0.5, -FRAC_PI_2]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    scene.joint_friction("pivot friction", Body::GROUND, rod, friction);
    scene.torsional_spring_damper("coil", Body::GROUND, rod, stiffness, -FRAC_PI_2, 0.0);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    ([mass, friction, stiffness], rod.coordinates[2])
}

/// A cart on a spring, driven by a force, that carries a pendulum.
fn cart(scene: &mut Scene) -> ([Design; 3], Coordinate) {
    let mut parts = CartPendulum::with_links(1).mechanism();
    let (stiffness, damping) = (parts.scene.design("stiffness", 10.0), parts.scene.design("damping", 1.0));
    let mass = parts.scene.design("mass", 0.3);
    let centre = parts.cart.at(0.0, 0.0);
    parts.scene.spring_damper("spring", Body::GROUND.at(-1.0, 0.0), centre, stiffness, 1.0, damping);
    let bob = parts.scene.body("bob", mass, mass * 0.01, [0.0, -1.0, -FRAC_PI_2]);
    parts.scene.weld("weld", parts.links[0].at(0.5, 0.0), bob.at(0.0, 0.0), 0.0);
    *scene = parts.scene;
    ([stiffness, damping, mass], parts.cart.coordinates[0])
}

/// Two carts on springs.
fn carts(scene: &mut Scene) -> ([Design; 3], Coordinate) {
    let (near, far) = (scene.design("near spring", 30.0), scene.design("far spring", 20.0));
    let mass = scene.design("mass", 1.0);
    let first = scene.body("first", 1.0, 0.1, [1.0, 0.0, 0.0]);
    let second = scene.body("second", mass, 0.1, [2.0, 0.0, 0.0]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, first.at(0.0, 0.0), 0.0);
    scene.prismatic("second rail", Body::GROUND.at(0.0, 0.0), 0.0, second.at(0.0, 0.0), 0.0);
    scene.spring_damper("near", Body::GROUND.at(0.0, 0.0), first.at(0.0, 0.0), near, 1.0, 0.1);
    scene.spring_damper("far", first.at(0.0, 0.0), second.at(0.0, 0.0), far, 1.0, 0.1);
    let force = scene.control("force");
    scene.actuator("drive", Body::GROUND.at(0.0, 0.0), 0.0, first.at(0.0, 0.0), force);
    ([near, far, mass], second.coordinates[0])
}

/// The inputs with this force on a grid with so many times as many steps.
fn inputs(system: &System, finer: usize, force: &dyn Fn(f64) -> f64) -> Inputs {
    let steps = finer * STEPS;
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, DURATION / steps as f64));
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = force(t));
    inputs
}

/// The coordinate at the nodes of the readings.
fn read(system: &System, of: Coordinate, inputs: &Inputs) -> Vec<f64> {
    let motion = simulate(system, inputs, Settings::default()).expect("a motion");
    let every = EVERY * inputs.grid.steps.len() / STEPS;
    (1..=STEPS / EVERY).map(|k| motion.q[(of.index(), k * every)]).collect()
}

/// A machine without readings, and its parameters before they are known.
fn bare(machine: Machine) -> (System, [Design; 3], Coordinate) {
    let mut scene = Scene::new();
    let (designs, of) = machine(&mut scene);
    (scene.compile().expect("a scene"), designs, of)
}

/// The system with these readings, and its parameters as variables.
fn with_readings(machine: Machine, readings: &[f64]) -> (System, Vec<Free>) {
    let mut scene = Scene::new();
    let (designs, of) = machine(&mut scene);
    for (k, reading) in readings.iter().enumerate() {
        scene.reading(&format!("reading {k}"), of, EVERY * (k + 1), *reading, 1.0 / NOISE);
    }
    (scene.compile().expect("a scene"), designs.map(|design| Free::design(design).logarithmic()).to_vec())
}

fn problem(system: &System, inputs: Inputs, free: &[Free]) -> MotionProblem {
    let variables = Variables::new(system, &inputs, free.to_vec()).expect("free");
    MotionProblem::new(system, Settings::default(), inputs, variables).expect("a problem")
}

fn fit(problem: &mut dyn Problem, start: &[f64]) -> Fit {
    let options = Options { stationarity: 1e-6, ..Options::default() };
    let fit = levenberg_marquardt(problem, start, &options, &mut silent).expect("fits");
    assert!(fit.outcome.reason.is_converged(), "{fit}");
    fit
}

/// Standard errors by noise alone, and shifts, both from the normal equations.
fn by_normal_equations(fit: &Fit, errors: &DVector<f64>) -> (Vec<f64>, Vec<f64>) {
    let inverse = fit.jacobian.tr_mul(&fit.jacobian).try_inverse().expect("regular");
    let variance = fit.chi_squared() / fit.degrees_of_freedom() as f64;
    let shifts = -(&inverse * fit.jacobian.tr_mul(errors));
    ((0..inverse.nrows()).map(|i| (variance * inverse[(i, i)]).sqrt()).collect(), shifts.as_slice().to_vec())
}

/// The variable of a warning that the grid shifts it.
fn shifted(fit: &Fit) -> Option<&str> {
    fit.outcome.warnings.iter().find_map(|warning| match warning {
        Warning::GridShift { variable, .. } => Some(variable.as_str()),
        _ => None,
    })
}

#[test]
fn standard_errors_include_what_the_grid_shifts() {
    let mut random = Random::new(1);
    let (mut all, mut by_noise, mut within, mut corrected, mut warned) = (0, 0, 0, 0, 0);
    for k in 0..120 {
        let machine: Machine = [pendulum, cart, carts][k % 3];
        let (strength, pace, phase) = (random.uniform(2.0, 4.0), random.uniform(2.0, 5.0), random.uniform(0.0, 3.0));
        let force = move |t: f64| strength * (pace * t + phase).sin();
        let (system, designs, of) = bare(machine);
        let mut exact = inputs(&system, FINER, &force);
        designs.iter().for_each(|design| exact.design[design.index()] *= random.uniform(0.8, 1.25));
        let truth = designs.map(|design| exact.design[design.index()].ln());
        // Nearly normal: sums of 12 uniform numbers.
        let mut normal = || (0..12).map(|_| random.uniform(-0.5, 0.5)).sum::<f64>();
        let readings: Vec<f64> = read(&system, of, &exact).iter().map(|x| x + NOISE * normal()).collect();

        let (system, free) = with_readings(machine, &readings);
        let mut problem = problem(&system, inputs(&system, 1, &force), &free);
        let start = problem.start();
        let fit = fit(&mut problem, &start);
        let (errors, shifts) = (fit.standard_errors().expect("determined"), fit.grid_shifts().expect("halved steps"));
        let (of_noise, own_shifts) = by_normal_equations(&fit, fit.grid_errors.as_ref().expect("halved steps"));
        let is_shifted = (0..3).any(|i| shifts[i].abs() > Warning::GRID_SHIFT * of_noise[i]);
        assert_eq!(shifted(&fit).is_some(), is_shifted);
        warned += usize::from(is_shifted);
        for i in 0..3 {
            assert!((shifts[i] - own_shifts[i]).abs() < 1e-8 * own_shifts[i].abs().max(of_noise[i]));
            assert!((errors[i] - of_noise[i].hypot(own_shifts[i])).abs() < 1e-8 * errors[i]);
            let off = fit.outcome.x[i] - truth[i];
            all += 1;
            by_noise += usize::from(off.abs() <= 2.0 * of_noise[i]);
            within += usize::from(off.abs() <= 2.0 * errors[i]);
            corrected += usize::from((off + shifts[i]).abs() <= 2.0 * of_noise[i]);
        }
    }
    println!("of {all} parameters, {by_noise} lie within two standard errors by noise, {within} with the grid's share;");
    println!("shifted, {corrected} lie within two standard errors by noise; {warned} of 120 fits warn");
    assert!((all / 3..=2 * all / 3).contains(&by_noise) && 100 * within >= 95 * all && 10 * corrected >= 8 * all);
    assert!(warned > 100);
}

#[test]
fn the_errors_of_readings_are_those_of_half_the_steps() {
    let force = |t: f64| 3.0 - 2.0 * t;
    let (system, _, of) = bare(pendulum);
    let exact = read(&system, of, &inputs(&system, 1, &force));
    let readings: Vec<f64> = (0..).zip(exact).map(|(k, x)| x + NOISE * f64::from(k % 3 - 1)).collect();
    let (system, free) = with_readings(pendulum, &readings);
    let given = inputs(&system, 1, &force);
    let mut single = problem(&system, given.clone(), &free);
    let start = single.start();
    let found = fit(&mut single, &start);
    let at_end = single.inputs_at(&found.outcome.x);
    let finer = Inputs { design: at_end.design.clone(), ..inputs(&system, 2, &force) };
    let errors = found.grid_errors.as_ref().expect("halved steps");
    for ((error, finer), own) in errors.iter().zip(read(&system, of, &finer)).zip(read(&system, of, &at_end)) {
        assert!((error - 4.0 / 3.0 * (finer - own) / NOISE).abs() < 1e-8 * errors.amax());
    }
    assert!(errors.amax() > 0.1, "{errors}");

    // Trials have the errors of all motions.
    let both = || vec![problem(&system, given.clone(), &free), problem(&system, given.clone(), &free)];
    let of_both = fit(&mut Trials::new(both()).expect("two trials"), &start).grid_errors.expect("halved steps");
    assert!((of_both.rows(errors.len(), errors.len()) - errors).amax() < 1e-6 * errors.amax());

    // The steps of a composed grid cannot be halved one by one.
    let composed = Inputs { grid: Grid { stages: 3, ..given.grid.clone() }, ..given.clone() };
    let mixed = vec![problem(&system, given.clone(), &free), problem(&system, composed, &free)];
    let unknown = fit(&mut Trials::new(mixed).expect("two trials"), &start);
    assert_eq!((unknown.grid_errors.is_none(), unknown.grid_shifts(), shifted(&unknown)), (true, None, None));
    let (of_noise, _) = by_normal_equations(&unknown, &DVector::zeros(2 * errors.len()));
    let known = unknown.standard_errors().expect("determined");
    assert!(known.iter().zip(&of_noise).all(|(x, y)| (x - y).abs() < 1e-8 * y));
}

/// x − 1, x − 3 and x − 2, with the errors of a discretisation.
struct Line(Result<Option<Vec<f64>>, Error>);

impl Problem for Line {
    fn variables(&self) -> usize {
        1
    }
    fn constraints(&self) -> Vec<Interval> {
        vec![Interval::ZERO, Interval::FREE, Interval::ZERO, Interval::ZERO]
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        c.copy_from_slice(&[x[0] - 1.0, 7.0, x[0] - 3.0, x[0] - 2.0]);
        Ok(0.0)
    }
    fn gradient(&mut self, _: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient[0] = c[0] + c[2] + c[3];
        Ok(())
    }
    fn grid_errors(&self) -> Result<Option<Vec<f64>>, Error> {
        self.0.clone()
    }
}

#[test]
fn errors_of_a_discretisation_belong_to_the_residuals_that_are_not_free() {
    let found = fit(&mut Line(Ok(Some(vec![0.1, 100.0, 0.4, 0.1]))), &[0.0]);
    let near = |x: f64, y: f64| (x - y).abs() < 1e-12;
    assert!(found.grid_shifts().is_some_and(|shifts| near(shifts[0], -0.2)) && shifted(&found).is_none());
    // The noise has the variance 2/2, the mean of three readings a third of it.
    assert!(found.covariance().is_some_and(|covariance| near(covariance[(0, 0)], 1.0 / 3.0 + 0.04)));
    let found = fit(&mut Line(Ok(Some(vec![0.3; 4]))), &[0.0]);
    assert_eq!(shifted(&found), Some("x0"));

    let overflow = Error::Overflow { what: "a finer motion".into(), value: f64::INFINITY };
    for (errors, says) in [(Err(overflow), "a finer motion"), (Ok(Some(vec![0.1])), "grid errors")] {
        let found = fit(&mut Line(errors), &[0.0]);
        assert!(found.grid_errors.is_none() && found.outcome.failures == 1);
        assert_says(found.outcome.first_failure.as_ref().expect("an error"), &[says]);
        assert!(found.covariance().is_some_and(|covariance| near(covariance[(0, 0)], 1.0 / 3.0)));
    }
}
