//! Impacts, and constraints that open and close at located events: their gradients and products.

use hamiltonian_adjoint::check::Input;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Grid, Inputs, LongSolver, Real, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System,
};
use nalgebra::SVector;

use crate::common::assert_gradient_is_exact_with;
use crate::located::{along, assert_products_are_exact, direction, lifted_along, near};

/// t − b₀.
struct Past;

impl Cost<0, 0, 0, 1> for Past {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, b: &SVector<S, 1>) -> S {
        at.t - b[0]
    }
}

struct Turning;

impl Cost<1, 1, 1, 0> for Turning {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 1, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.v[0] * at.v[0] * 0.1 + at.u[0] * at.u[0] * 0.01 + at.q[0] * at.t + at.sigma[0] * 0.1
    }
}

/// λ + b₀.
struct Reaction;

impl Cost<0, 1, 0, 1> for Reaction {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, b: &SVector<S, 1>) -> S {
        at.lambda[0] + b[0]
    }
}

/// When the tip is lifted.
#[derive(Clone, Copy)]
pub enum Lift {
    Time,
    Reaction,
}

/// Two rods on one or two hinges at the ground, with a motor. The tip hits a floor, then lands on it, and is lifted.
pub fn rods(hinges: usize, without_programs: bool, lift: Lift) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [height, restitution] = [scene.design("height", -0.4), scene.design("restitution", 0.5)];
    let [mass, time] = [scene.design("mass", 0.7), scene.design("time", 0.62)];
    let inner = scene.body("inner", 1.3, 0.1, [0.5, 0.0, 0.0]);
    let outer = scene.body("outer", mass, 0.05, [1.5, 0.0, 0.0]);
    for name in ["hinge", "second hinge"].into_iter().take(hinges) {
        scene.revolute(name, Body::GROUND.at(0.0, 0.0), inner.at(-0.5, 0.0));
    }
    scene.revolute("elbow", inner.at(0.5, 0.0), outer.at(-0.5, 0.0));
    scene.torsional_spring_damper("spring", inner, outer, 20.0, 1.0, 0.0);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, inner, torque);
    let normal = std::f64::consts::FRAC_PI_2 + 0.1;
    let floor = scene.rigid_contact("floor", Body::GROUND.at(0.0, height), normal, outer.at(0.5, 0.0));
    scene.impact_at(floor.event, floor.equation, restitution * 1.1);
    let landing = scene.rigid_contact("landing", Body::GROUND.at(0.0, height), normal, outer.at(0.5, 0.0));
    scene.close_at(landing.event, &[landing.equation]);
    let lift = match lift {
        Lift::Time => scene.event("lift", Past, [], [], [], [time.into()]),
        Lift::Reaction => scene.event("lift", Reaction, [], [landing.equation], [], [time * 0.1]),
    };
    scene.open_at(lift, &[landing.equation]);
    let angle = [outer.coordinates[2]];
    scene.cost("end", Turning, Sum::Terminal, angle, [landing.equation], [torque], []);
    scene.cost("run", Turning, Sum::Integral, angle, [floor.equation], [torque], []);
    scene.event_impulse("impulse", floor.equation, 0);
    scene.event_impulse("landing", landing.equation, 1);
    let middle = scene.output("after");
    scene.term(middle, "after", Turning, Sum::AfterEvent(1), angle, [landing.equation], [torque], []);
    if without_programs { scene.compile_without_programs() } else { scene.compile() }.expect("a scene")
}

/// Phases of steps that differ, with the steps of length zero in which equations change.
fn grid(counts: [usize; 4]) -> Grid {
    let phase = |duration: f64, count: usize| -> Vec<f64> {
        (0..count).map(|i| duration / count as f64 * (1.0 + 0.2 * (0.7 * i as f64).sin())).collect()
    };
    let [fall, bounce, rest, lift] = counts;
    let steps = [phase(0.33, fall), vec![0.0; 2], phase(0.12, bounce), vec![0.0], phase(0.17, rest), vec![0.0]];
    Grid::new(0.0, [steps.concat(), phase(0.2, lift)].concat())
}

fn inputs(system: &System, grid: Grid, nodes: [usize; 3]) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    let times = inputs.grid.times();
    inputs.start = Start::assembled(system).hold(&[system.coordinate(2), system.coordinate(5)]);
    // Controls jump where equations change.
    inputs.controls.iter_mut().zip(times).enumerate().for_each(|(k, (u, t))| *u = 1.5 * (4.0 * t + 0.1 * k as f64).sin());
    inputs.events = nodes.iter().enumerate().map(|(event, node)| system.event(event).at(*node)).collect();
    inputs
}

pub fn usual(system: &System) -> Inputs {
    inputs(system, grid([16, 8, 10, 8]), [16, 26, 37])
}

/// The motor lifts the tip.
fn pulled(system: &System) -> Inputs {
    let mut inputs = usual(system);
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = 100.0 * (t - 0.42).max(0.0));
    inputs
}

/// A box that falls, sticks to a floor with a corner, wherever that is, and tips over, until it is released.
fn tipping_box() -> (System, Inputs) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [width, height] = [scene.design("width", 0.3), scene.design("height", 0.02)];
    let body = scene.body("box", 2.0, 0.05, [0.0, 0.6, 0.3]);
    let corner = body.at(width * -1.0, -0.2);
    let tilt = 0.1;
    let floor = scene.rigid_contact("floor", Body::GROUND.at(0.0, height), std::f64::consts::FRAC_PI_2 + tilt, corner);
    let along = scene.rigid_contact("along", Body::GROUND.at(0.0, height), tilt, corner);
    scene.close_at(floor.event, &[floor.equation]);
    scene.hold_at(floor.event, &[along.equation]);
    let lift = scene.event("lift", Past, [], [], [], [0.6.into()]);
    scene.open_at(lift, &[floor.equation, along.equation]);
    let force = scene.control("force");
    scene.actuator("push", Body::GROUND.at(0.0, 0.0), 0.2, body.at(0.1, 0.1), force);
    let angle = [body.coordinates[2]];
    scene.cost("run", Turning, Sum::Integral, angle, [along.equation], [force], []);
    scene.cost("end", Turning, Sum::Terminal, angle, [floor.equation], [force], []);
    let system = scene.compile().expect("a scene");
    let steps = [vec![0.02; 16], vec![0.0], vec![0.017; 16], vec![0.0], vec![0.02; 5]].concat();
    let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, steps));
    inputs.start.set_rate(body.coordinates[0], 0.7);
    inputs.start.set_rate(body.coordinates[2], -0.4);
    inputs.controls.iter_mut().enumerate().for_each(|(k, u)| *u = (0.3 * k as f64).sin());
    inputs.events = vec![floor.event.at(16), lift.at(33)];
    (system, inputs)
}

#[test]
fn a_motion_may_end_at_an_impact() -> Result<(), Error> {
    let system = rods(1, false, Lift::Time);
    let steps = [vec![0.33 / 16.0; 16], vec![0.0; 2], vec![0.022; 8], vec![0.0]].concat();
    let mut given = inputs(&system, Grid::new(0.0, steps), [16, 26, 26]);
    for (events, nodes) in [([0, 1], 27), ([0, 0], 28)] {
        given.grid.steps.resize(nodes, 0.0);
        given.controls = given.controls.clone().resize_horizontally(nodes + 1, 0.7);
        given.events = vec![system.event(events[0]).at(16), system.event(events[1]).at(26)];
        for settings in [Settings::default(), Settings { scheme: Scheme::ESDIRK3, ..Settings::default() }] {
            assert_gradient_is_exact_with("to an impact", &system, &given, settings);
        }
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&given)?;
        let own = solver.gradient()?.clone();
        let mut long =
            LongSolver::new(&system, Settings::default(), 30 * system.bytes_per_node(&Settings::default()) + 20_000);
        assert!(long.gradient(&given)? == &own, "checkpoints");
        let (a, b) = (direction(&given, 1), direction(&given, 1001));
        let product = solver.hessian_product(&a)?.clone();
        let lifted = lifted_along(&system, &given, Settings::default(), [&a, &b])?;
        near("Hessian", along(&product, &b), lifted.cost()?.part(3), 1e-9);
    }
    Ok(())
}

#[test]
fn what_sticks_where_it_is_has_exact_gradients() -> Result<(), Error> {
    let (system, inputs) = tipping_box();
    let plain = Settings::default();
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..plain };
    for settings in [plain, restarted, Settings { scheme: Scheme::ESDIRK4, ..restarted }] {
        assert_gradient_is_exact_with("sticking", &system, &inputs, settings);
        let mut solver = Solver::new(&system, settings);
        let motion = solver.simulate(&inputs)?.clone();
        let phi = motion.phi(&system, solver.inputs())?;
        let [begin, end] = [17, 33].map(|node| phi[(1, node)]);
        assert!(begin.abs() > 0.05 && (end - begin).abs() < 1e-3, "{begin} {end}");
    }
    Ok(())
}

#[test]
fn the_second_impact_on_a_constraint_begins_with_the_multiplier_after_the_first() -> Result<(), Error> {
    let system = rods(1, false, Lift::Time);
    let steps = [vec![0.33 / 16.0; 16], vec![0.0; 2], vec![0.022; 8], vec![0.0; 2], vec![0.02; 6]].concat();
    let mut given = inputs(&system, Grid::new(0.0, steps), [16, 26, 30]);
    given.events = [16, 26].map(|node| system.event(0).at(node)).to_vec();
    let restarted = Settings { rebase_every: 3, ..Settings::default() };
    for settings in [Settings::default(), restarted, Settings { scheme: Scheme::ESDIRK3, ..Settings::default() }] {
        assert_gradient_is_exact_with("two impacts", &system, &given, settings);
        let mut solver = Solver::new(&system, settings);
        let motion = solver.simulate(&given)?;
        // σ of the floor has changed at both impacts.
        let sigma = [16, 18, 26, 28].map(|node| motion.sigma[(4, node)]);
        assert!(sigma[0].abs() < 1e-20 && sigma[1] < -0.1 && sigma[3] < sigma[2] - 0.01, "{sigma:?}");
        let own = solver.gradient()?.clone();
        assert!(LongSolver::new(&system, settings, 1_000_000).gradient(&given)? == &own, "checkpoints");
    }
    Ok(())
}

#[test]
fn gradients_are_those_of_complex_step() {
    let plain = Settings::default();
    let system = rods(1, false, Lift::Time);
    for scheme in Scheme::ALL {
        let what = format!("impacts: {}", scheme.name);
        assert_gradient_is_exact_with(&what, &system, &usual(&system), Settings { scheme, ..plain });
    }
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..plain };
    assert_gradient_is_exact_with("impacts: restarts", &system, &usual(&system), restarted);
    let recorded = rods(1, true, Lift::Time);
    assert_gradient_is_exact_with("impacts: without programs", &recorded, &usual(&recorded), plain);
    let lifted = rods(1, false, Lift::Reaction);
    for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
        assert_gradient_is_exact_with("impacts: lifted", &lifted, &pulled(&lifted), Settings { scheme, ..plain });
    }
    let redundant = rods(2, false, Lift::Time);
    assert_gradient_is_exact_with("impacts: redundant", &redundant, &usual(&redundant), plain);
}

#[test]
fn products_and_jacobians_are_those_of_hyper_dual_numbers() -> Result<(), Error> {
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..Settings::default() };
    let fine = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    for (settings, hinges) in [(Settings::default(), 1), (restarted, 1), (fine, 1), (Settings::default(), 2)] {
        let system = rods(hinges, false, Lift::Time);
        let given = usual(&system);
        assert_products_are_exact(&system, &given, settings)?;
    }
    Ok(())
}

#[test]
fn products_with_an_event_of_a_reaction_are_differences_of_gradients() -> Result<(), Error> {
    let system = rods(1, false, Lift::Reaction);
    let given = pulled(&system);
    let mut solver = Solver::new(&system, Settings::default());
    let (a, b) = (direction(&given, 1), direction(&given, 1001));
    let mut slope = |size: f64| -> Result<f64, Error> {
        let (mut moved, mut own) = (given.clone(), a.clone());
        for input in Input::all(&given) {
            // Steps of length zero stay.
            if !matches!(input, Input::Step(k) if given.grid.steps[k - 1] == 0.0) {
                *input.of(&mut moved) += size * *input.of(&mut own);
            }
        }
        solver.simulate(&moved)?;
        Ok(along(solver.gradient()?, &b))
    };
    let reference = (8.0 * (slope(1e-4)? - slope(-1e-4)?) - slope(2e-4)? + slope(-2e-4)?) / 12e-4;
    let mut direction = a;
    given.grid.steps.iter().enumerate().filter(|(_, dt)| **dt == 0.0).for_each(|(k, _)| direction.grid.steps[k] = 0.0);
    solver.simulate(&given)?;
    near("product", along(solver.hessian_product(&direction)?, &b), reference, 1e-7);
    Ok(())
}
