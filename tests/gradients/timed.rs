//! Controls that are functions of time although located events move the nodes.

use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, lbfgs, silent};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Error, Grid, Inputs, Scalar, Scene, Scheme, Settings, Solver, Sum, System, Warning, check,
    estimate, gradient,
};
use nalgebra::SVector;

use crate::common::{assert_gradient_is_exact_with, assert_says};
use crate::impacts::{Lift, rods, usual};
use crate::located::{ALL, assert_products_are_exact, grid, inputs, rod, touching};

fn in_time(system: &System, inputs: Inputs) -> Inputs {
    Inputs { controls_in_time: (0..system.k()).map(|k| system.control(k)).collect(), ..inputs }
}

/// With phases that are given too short, and too long.
fn poor(mut inputs: Inputs) -> Inputs {
    let count = inputs.grid.steps.len();
    inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= if 2 * i < count { 0.8 } else { 1.2 });
    inputs
}

#[test]
fn gradients_are_those_of_complex_step() -> Result<(), Error> {
    let (plain, system) = (Settings::default(), rod(1, false));
    let given = in_time(&system, inputs(&system, grid(50), &ALL));
    for scheme in Scheme::ALL {
        let settings = Settings { scheme, ..plain };
        assert_gradient_is_exact_with(&format!("timed: {}", scheme.name), &system, &poor(given.clone()), settings);
        // Nodes at their knots.
        let mut solver = Solver::new(&system, settings);
        solver.simulate(&given)?;
        let found = solver.inputs().clone();
        let own = solver.trajectory().q.clone();
        assert!((&solver.simulate(&found)?.q - own).amax() < 1e-13);
        assert_gradient_is_exact_with(&format!("timed: {}, found", scheme.name), &system, &found, settings);
    }
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..plain };
    assert_gradient_is_exact_with("timed: restarts", &system, &poor(given.clone()), restarted);
    let composed = Grid::composed(16, 0.56 / 16.0, Composition::Suzuki4);
    let composed = in_time(&system, inputs(&system, composed, &[(0, 30), (1, 45), (0, 60)]));
    assert_gradient_is_exact_with("timed: composed", &system, &composed, plain);
    let ends = in_time(&system, inputs(&system, grid(28), &[(0, 20), (1, 28)]));
    assert_gradient_is_exact_with("timed: to the end", &system, &ends, plain);
    let halving = Settings { max_iterations: 3, ..plain };
    let halved = in_time(&system, inputs(&system, grid(20), &[(0, 12), (1, 16)]));
    assert_gradient_is_exact_with("timed: halved", &system, &halved, halving);
    let hit = rods(1, false, Lift::Time);
    // Knots at both ends of steps of length zero have different values.
    assert_gradient_is_exact_with("timed: impacts", &hit, &in_time(&hit, usual(&hit)), plain);
    assert_products_are_exact(&hit, &in_time(&hit, usual(&hit)), plain)
}

#[test]
fn products_and_jacobians_are_those_of_hyper_dual_numbers() -> Result<(), Error> {
    let fine = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    let system = touching(0.02, 1, false);
    let given = in_time(&system, inputs(&system, grid(50), &ALL));
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&given)?;
    let found = solver.inputs().clone();
    for settings in [Settings::default(), fine] {
        assert_products_are_exact(&system, &poor(given.clone()), settings)?;
    }
    assert_products_are_exact(&system, &found, Settings::default())
}

/// x − 1 m.
struct Far;

impl Cost<1, 0, 0, 0> for Far {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0] - 1.0
    }
}

struct Speed;

impl Cost<1, 0, 0, 0> for Speed {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v[0]
    }
}

/// A block of 2 kg, pushed by a control to 1 m. An output is the time at which it gets there.
fn pushed() -> Result<System, Error> {
    let mut scene = Scene::new();
    let block = scene.particle("block", 2.0, [0.0, 0.0]);
    let push = scene.control("push");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, block.point(), push);
    scene.event("far", Far, [block.coordinates[0]], [], [], []);
    scene.event_time("time", 0);
    scene.cost("speed", Speed, Sum::Terminal, [block.coordinates[0]], [], [], []);
    scene.compile()
}

fn speed(t: f64) -> f64 {
    (2.0 * t + 1.0 / 3.0 - (3.0 * t).cos() / 3.0) / 2.0
}

/// 2 x = t² + t/3 − sin(3 t)/9 is 2 at the event.
fn time_of_the_event() -> f64 {
    let x = |t: f64| (t * t + t / 3.0 - (3.0 * t).sin() / 9.0) / 2.0;
    (0..20).fold(1.3, |t, _| t - (x(t) - 1.0) / speed(t))
}

#[test]
fn the_derivatives_of_an_event_are_those_of_the_continuous_motion() -> Result<(), Error> {
    let system = pushed()?;
    let moved = |shift: f64, steps: usize| -> Result<[f64; 2], Error> {
        let mut given = Inputs::at_rest(&system, Grid::uniform(steps, 2.0 / steps as f64));
        given.set_control(system.control(0), |t| 2.0 + (3.0 * t).sin());
        given.events = vec![system.event(0).at((steps as f64 * shift) as usize)];
        let given = in_time(&system, given);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&given)?;
        let gradient = solver.jacobian()?.remove(0);
        let times = given.grid.times();
        // δu = t².
        let along = times.iter().zip(gradient.controls.iter()).map(|(t, of)| t * t * of).sum();
        Ok([solver.outputs()?[0], along])
    };
    let time = time_of_the_event();
    let by_push = -time.powi(4) / 24.0 / speed(time);
    // By the place of the knots in the steps, the errors are between bounds of second order.
    for share in [0.4, 0.6, 0.8] {
        for steps in [20, 40, 80, 160, 320] {
            let h2 = (2.0 / steps as f64).powi(2);
            let [of_time, of_slope] = moved(share, steps)?;
            let errors = [of_time - time, of_slope - by_push].map(|error| error.abs() / h2);
            println!("{share} {steps}: {errors:?}");
            assert!(errors[0] < 0.5 && errors[1] < 0.5, "{share}, {steps} steps: {errors:?}");
        }
    }
    Ok(())
}

#[test]
fn adaptive_grids_phases_files_and_checks() -> Result<(), Error> {
    let (system, settings) = (pushed()?, Settings::default());
    let push = system.control(0);
    let mut given = Inputs::at_rest(&system, Grid::uniform(80, 0.025));
    given.set_control(push, |t| 2.0 + (3.0 * t).sin());
    let given = in_time(&system, given);
    let mut solver = Solver::new(&system, settings);
    let phases = solver.find_phases(&Inputs { controls_in_time: Vec::new(), ..given.clone() }, 20)?;
    assert_eq!(phases.controls_in_time, given.controls_in_time);
    let mut jumping = given.clone();
    (jumping.grid.steps[7], jumping.controls[(0, 8)]) = (0.0, 0.0);
    assert_eq!(solver.find_phases(&jumping, 20)?.controls_in_time, []);
    let adapted = solver.adapt(&phases, 1e-6)?;
    let mut poor = phases.clone();
    poor.grid = Grid::uniform(phases.grid.steps.len(), 2.0 / phases.grid.steps.len() as f64);
    poor.set_control(push, |t| 2.0 + (3.0 * t).sin());
    for (what, inputs) in [("phases", &phases), ("adapted", &adapted), ("poor", &poor)] {
        solver.simulate(inputs)?;
        let time = solver.outputs()?[0];
        println!("{what}: {time}");
        assert!((time - time_of_the_event()).abs() < 1e-3, "{what}: {time}");
        check::gradient(&system, inputs, settings).run()?.assert_passed();
        check::hessian(&system, inputs, settings).run()?.assert_passed();
        #[cfg(feature = "files")]
        assert_eq!(&Inputs::from_json(&system, &inputs.to_json(&system)?)?, inputs);
    }
    assert!(estimate(&system, &poor, settings)?.corrected.is_none(), "knots between nodes");
    Ok(())
}

#[test]
fn a_control_is_constant_behind_its_last_knot() -> Result<(), Error> {
    let system = pushed()?;
    let mut given = Inputs::at_rest(&system, Grid::uniform(20, 0.05));
    given.controls.fill(2.0);
    given.controls[(0, 20)] = 4.0;
    given.events = vec![system.event(0).at(20)];
    let given = in_time(&system, given);
    let mut solver = Solver::new(&system, Settings::default());
    let end = solver.simulate(&given)?.times[20];
    let u = solver.inputs().controls.row(0).clone_owned();
    let is_right = |(node, t): (usize, f64)| (u[node] - (2.0 + 40.0 * (t - 0.95).clamp(0.0, 0.05))).abs() < 1e-12;
    assert!(end > 1.2 && solver.trajectory().times.iter().copied().enumerate().all(is_right), "{u}");
    assert_gradient_is_exact_with("timed: behind the last knot", &system, &given, Settings::default());
    Ok(())
}

#[test]
fn what_is_refused_is_said() -> Result<(), Error> {
    let (system, other) = (rods(1, false, Lift::Time), pushed()?);
    let mut solver = Solver::new(&system, Settings::default());
    let foreign = Inputs { controls_in_time: vec![other.control(0)], ..usual(&system) };
    assert_says(
        &solver.simulate(&foreign).map(|_| ()).expect_err("a control of another scene"),
        &["controls_in_time", "control"],
    );
    let jumping = in_time(&system, usual(&system));
    solver.simulate(&jumping)?;
    let said: Vec<String> = solver.report().warnings.iter().map(Warning::to_string).collect();
    println!("{said:?}");
    assert!(said.iter().any(|said| said.contains("`torque` jumps by -1.484e-1 in step 17")), "{said:?}");
    let (u, times) = (&solver.inputs().controls, &solver.trajectory().times);
    let is_continuous = |node: usize| times[node] != times[node + 1] || (u[(0, node)] - u[(0, node + 1)]).abs() < 1e-14;
    assert!((0..times.len() - 1).all(is_continuous));
    Ok(())
}

#[test]
fn without_events_there_is_no_difference() -> Result<(), Error> {
    let system = CartPendulum::default().scene().compile()?;
    let mut given = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    given.set_control(system.control(0), |t| (5.0 * t).sin());
    // A jump.
    given.grid.steps[7] = 0.0;
    let own = gradient(&system, &given, Settings::default())?;
    assert_eq!(own, gradient(&system, &in_time(&system, given), Settings::default())?);
    Ok(())
}

/// t.
struct Late;

impl Cost<0, 0, 0, 0> for Late {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.t
    }
}

#[test]
fn optimisers_change_both_knots_at_a_step_of_length_zero() -> Result<(), Error> {
    let mut scene = Scene::new();
    let block = scene.particle("block", 2.0, [0.0, 0.0]);
    let push = scene.control("push");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, block.point(), push);
    scene.event("far", Far, [block.coordinates[0]], [], [], []);
    scene.cost("late", Late, Sum::Event(0), [], [], [], []);
    scene.effort("effort", push, 0.1);
    let system = scene.compile()?;
    let grid = Grid::uniform(20, 0.05).then(&Grid::new(0.0, vec![0.0])).then(&Grid::uniform(20, 0.05));
    let mut given = Inputs::at_rest(&system, grid);
    given.set_control(push, |t| 3.0 - t);
    given.events = vec![system.event(0).at(20)];
    for is_in_time in [true, false] {
        let given = if is_in_time { in_time(&system, given.clone()) } else { given.clone() };
        let variables = Variables::new(&system, &given, vec![Free::control(push).within(-5.0, 5.0)])?;
        let mut problem = MotionProblem::new(&system, Settings::default(), given, variables)?;
        let start = problem.start();
        let outcome = lbfgs(&mut problem, &start, &Options::default(), &mut silent)?;
        println!("{} after {} iterations ({:?})", outcome.value, outcome.iterations, outcome.reason);
        assert!(outcome.reason.is_converged(), "{:?}", outcome.reason);
        assert!(!is_in_time || outcome.x[20] == outcome.x[21]);
    }
    Ok(())
}
