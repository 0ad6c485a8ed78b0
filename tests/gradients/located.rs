//! Motions with located events: their gradients, products and limits.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Error, Grid, Inputs, LongSolver, Param, Scalar, Scene, Scheme, Settings, Solver, Start,
    Sum, System,
};
use nalgebra::SVector;

use crate::common::assert_gradient_is_exact_with;
pub use crate::common::products::{along, assert_products_are_exact, direction, lifted_along, near};
use crate::grid_phase::{Depth, Floor, depth};

/// The rate of the angle, less a control and a reaction.
struct Turns;

impl Cost<1, 1, 1, 1> for Turns {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 1, 1>, b: &SVector<S, 1>) -> S {
        at.v[0] - at.u[0] * 0.02 + at.sigma[0] * b[0] - at.t * 0.01
    }
}

struct Angle;

impl Cost<1, 0, 1, 0> for Angle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.v[0] * at.v[0] * 0.1 + at.u[0] * at.u[0] * 0.01 + at.q[0] * at.t
    }
}

/// A rod on hinges, with a motor, that falls on a floor. Its events: the tip touches the floor, and the rod reverses.
pub fn rod(hinges: usize, without_programs: bool) -> System {
    touching(0.0, hinges, without_programs)
}

/// The same, with the touch at this height over the floor.
pub fn touching(gap: f64, hinges: usize, without_programs: bool) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [height, stiffness] = [scene.design("height", -0.3), scene.design("stiffness", 4000.0)];
    let rod = scene.body("rod", 1.2, 0.1, [0.5, 0.0, 0.0]);
    let mut pins = Vec::new();
    for name in ["hinge", "second hinge"].into_iter().take(hinges) {
        pins.push(scene.revolute(name, Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0)));
    }
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    scene.force("floor", Floor, rod.coordinates, [], [height.into(), stiffness.into()]);
    let angle = [rod.coordinates[2]];
    scene.cost("end", Angle, Sum::Terminal, angle, [], [torque], []);
    scene.cost("run", Angle, Sum::Integral, angle, [], [torque], []);
    scene.cost("at the touch", Angle, Sum::Event(0), angle, [], [torque], []);
    scene.event_time("time of the reversal", 1);
    let middle = scene.output("middle");
    scene.term(middle, "middle", Angle, Sum::Node(17), angle, [], [torque], []);
    scene.event("touch", Depth, rod.coordinates, [], [], [Param::from(height) + gap]);
    // The share of one of two hinges in their reaction has few digits.
    let weight = if hinges == 1 { 1e-3 } else { 0.0 };
    scene.event("reversal", Turns, angle, [pins[0][0]], [torque], [weight.into()]);
    if without_programs { scene.compile_without_programs() } else { scene.compile() }.expect("a scene")
}

pub fn inputs(system: &System, grid: Grid, nodes: &[(usize, usize)]) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    let times = inputs.grid.times();
    inputs.start = Start::assembled(system).hold(&[system.coordinate(2)]);
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = 1.5 * (4.0 * t).sin());
    inputs.events = nodes.iter().map(|&(event, node)| system.event(event).at(node)).collect();
    inputs
}

/// Steps that differ.
pub fn grid(steps: usize) -> Grid {
    Grid::new(0.2, (0..steps).map(|i| 0.56 / steps as f64 * (1.0 + 0.2 * (0.7 * i as f64).sin())).collect())
}

/// Two touches and a reversal between them.
pub const ALL: [(usize, usize); 3] = [(0, 24), (1, 34), (0, 44)];

#[test]
fn gradients_are_those_of_complex_step() {
    let plain = Settings::default();
    let system = rod(1, false);
    for scheme in Scheme::ALL {
        let what = format!("located: {}", scheme.name);
        assert_gradient_is_exact_with(&what, &system, &inputs(&system, grid(50), &ALL), Settings { scheme, ..plain });
    }
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..plain };
    assert_gradient_is_exact_with("located: restarts", &system, &inputs(&system, grid(50), &ALL), restarted);
    let composed = Grid::composed(16, 0.56 / 16.0, Composition::Suzuki4);
    let nodes = [(0, 30), (1, 45), (0, 60)];
    assert_gradient_is_exact_with("located: composed", &system, &inputs(&system, composed, &nodes), plain);
    let redundant = rod(2, false);
    assert_gradient_is_exact_with("located: redundant", &redundant, &inputs(&redundant, grid(50), &ALL), plain);
    let recorded = rod(1, true);
    assert_gradient_is_exact_with("located: without programs", &recorded, &inputs(&recorded, grid(50), &ALL), plain);
    let ends = [(0, 20), (1, 28)];
    assert_gradient_is_exact_with("located: to the end", &system, &inputs(&system, grid(28), &ends), plain);
}

#[test]
fn products_and_jacobians_are_those_of_hyper_dual_numbers() -> Result<(), Error> {
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..Settings::default() };
    let fine = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    for (settings, hinges) in [(Settings::default(), 1), (restarted, 1), (fine, 1), (Settings::default(), 2)] {
        // Where the floor begins, its force has no second derivative.
        let system = touching(0.02, hinges, false);
        let given = inputs(&system, grid(50), &ALL);
        assert_products_are_exact(&system, &given, settings)?;
    }
    Ok(())
}

#[test]
fn an_event_holds_at_its_node_and_the_motion_ends_when_its_grid_does() -> Result<(), Error> {
    let system = rod(1, false);
    let given = inputs(&system, grid(50), &ALL);
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&given)?.clone();
    for node in [24, 44] {
        let depth = depth([0, 1, 2].map(|k| motion.q[(k, node)]), -0.3, motion.times[node]);
        assert!(depth.abs() < 1e-14, "{depth:e} at node {node}");
    }
    assert!((motion.times[50] - given.grid.times()[50]).abs() < 1e-14);
    // The steps that were found are those of the same motion.
    let found = solver.inputs().clone();
    let again = solver.simulate(&found)?;
    assert!((&again.q - &motion.q).amax() < 1e-13);
    Ok(())
}

#[test]
fn steps_are_halved_before_in_and_after_a_phase() -> Result<(), Error> {
    let system = touching(0.02, 1, false);
    let settings = Settings { max_iterations: 3, ..Settings::default() };
    for nodes in [&[(0, 12), (1, 16)], &[(0, 11), (1, 17)]] {
        let given = inputs(&system, grid(20), nodes);
        let mut solver = Solver::new(&system, settings);
        let inserted = solver.simulate(&given)?.inserted.clone();
        println!("{nodes:?}: inserted {inserted:?}");
        assert!(!inserted.is_empty());
        let own = solver.gradient()?.clone();
        assert!(LongSolver::new(&system, settings, 1_000_000).gradient(&given)? == &own, "checkpoints");
        assert_gradient_is_exact_with(&format!("located: halved {nodes:?}"), &system, &given, settings);
    }
    Ok(())
}
