//! The gradient at frozen grid phase: its definition, and what it is good for.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Error, Force, ForcePoint, Gradient, Grid, Inputs, Scalar, Scene, Scheme, Settings, Solver,
    Start, Sum, System,
};
use nalgebra::{DMatrix, DVector, SVector};

/// The height of a moving floor over the tip of a rod.
pub fn depth<S: Scalar>(q: [S; 3], b: S, t: S) -> S {
    b + (t * 5.0).sin() * 0.02 - (q[1] + q[2].sin() * 0.5)
}

/// A moving floor under the tip of a rod with the coordinates x, y and φ.
pub struct Floor;

impl Force<3, 0, 2> for Floor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 0>, b: &SVector<S, 2>) -> SVector<S, 3> {
        let push = b[1] * depth(at.q.into(), b[0], at.t).max(S::zero()).powf(1.5);
        SVector::from([S::zero(), push, push * at.q[2].cos() * 0.5])
    }
}

/// The depth of the tip in the floor.
pub struct Depth;

impl Cost<3, 0, 0, 1> for Depth {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, b: &SVector<S, 1>) -> S {
        depth(at.q.into(), b[0], at.t)
    }
}

struct Angle;

impl Cost<1, 0, 1, 0> for Angle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.v[0] * at.v[0] * 0.1 + at.u[0] * at.u[0] * 0.01
    }
}

/// What else a scene has.
#[derive(Clone, Copy, Default)]
pub struct Extra {
    /// A node at which the angle is read.
    pub reading: Option<usize>,
    /// Whether a second hinge repeats the first.
    pub repeats_hinge: bool,
}

/// A rod on a hinge, with a motor, that falls on a floor; the depth at some nodes is an output.
pub fn rod(nodes: &[usize], extra: Extra) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [height, stiffness] = [scene.design("height", -0.3), scene.design("stiffness", 4000.0)];
    let rod = scene.body("rod", 1.2, 0.1, [0.5, 0.0, 0.0]);
    for name in ["hinge", "second hinge"].into_iter().take(1 + usize::from(extra.repeats_hinge)) {
        scene.revolute(name, Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    }
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, rod, torque);
    scene.force("floor", Floor, rod.coordinates, [], [height.into(), stiffness.into()]);
    let angle = [rod.coordinates[2]];
    scene.cost("end", Angle, Sum::Terminal, angle, [], [torque], []);
    scene.cost("run", Angle, Sum::Integral, angle, [], [torque], []);
    if let Some(node) = extra.reading {
        scene.cost("reading", Angle, Sum::Node(node), angle, [], [torque], []);
    }
    for &node in nodes {
        let name = format!("depth at {node}");
        let output = scene.output(&name);
        scene.term(output, &name, Depth, Sum::Node(node), rod.coordinates, [], [], [height.into()]);
    }
    scene.compile().expect("a scene")
}

pub fn inputs(system: &System, grid: Grid) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    let times = inputs.grid.times();
    inputs.start = Start::assembled(system).hold(&[system.coordinate(2)]);
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = 1.5 * (4.0 * t).sin());
    inputs
}

/// Steps that differ.
pub fn grid(steps: usize) -> Grid {
    Grid::new(0.2, (0..steps).map(|i| 1.2 / steps as f64 * (1.0 + 0.2 * (0.7 * i as f64).sin())).collect())
}

fn simulate(system: &System, grid: &Grid, settings: Settings) -> Result<Solver, Error> {
    let mut solver = Solver::new(system, settings);
    solver.simulate(&inputs(system, grid.clone()))?;
    Ok(solver)
}

/// The nodes that follow kinks, and those that stay.
fn stops(system: &System, grid: &Grid, settings: Settings, stays: Option<usize>) -> Result<Vec<(usize, bool)>, Error> {
    let solver = simulate(system, grid, settings)?;
    let motion = solver.trajectory();
    let depth = |i: usize| depth([0, 1, 2].map(|k| motion.q[(k, i)]), -0.3, motion.times[i]);
    let last = grid.steps.len();
    let is_kink = |i: usize| i.is_multiple_of(grid.stages) && depth(i - grid.stages) * depth(i) < 0.0;
    let all = (1..last).map(|i| (i, is_kink(i) && stays != Some(i))).filter(|&(i, is_kink)| is_kink || stays == Some(i));
    Ok([(0, false)].into_iter().chain(all).chain([(last, false)]).collect())
}

/// All derivatives in one list.
fn list(gradient: &Gradient) -> DVector<f64> {
    let start = [gradient.start.q(), gradient.start.rate()].map(|list| list.as_slice().to_vec()).concat();
    DVector::from([gradient.controls.as_slice(), gradient.design.as_slice(), &start, &gradient.steps].concat())
}

/// The derivative by the time of a stop, whose neighbours stay.
fn by_time(motion: &Solver, gradient: &Gradient, [before, stop, after]: [usize; 3]) -> f64 {
    let (times, u) = (&motion.trajectory().times, &motion.inputs().controls);
    let rate = |i: usize| (u[(0, i + 1)] - u[(0, i - 1)]) / (times[i + 1] - times[i - 1]);
    let moves = |i: usize| {
        let stays = if i <= stop { before } else { after };
        (times[i] - times[stays]) / (times[stop] - times[stays])
    };
    let end = gradient.steps.len();
    let moves = |i: usize| if i <= before || i >= after.min(end) { 0.0 } else { moves(i) };
    let steps = (1..=end).map(|i| gradient.steps[i - 1] * (moves(i) - moves(i - 1)));
    let controls = (1..end).map(|i| gradient.controls[(0, i)] * rate(i) * moves(i));
    steps.chain(controls).sum()
}

/// dJ − (dJ/dτ) (dg/dτ)⁻¹ dg, with all dg by a Jacobian.
fn assert_is_defined(name: &str, grid: Grid, settings: Settings, extra: Extra) -> Result<(), Error> {
    let all = stops(&rod(&[], extra), &grid, settings, extra.reading)?;
    let kinks: Vec<usize> = (0..all.len()).filter(|&k| all[k].1).collect();
    assert!(kinks.len() >= 3, "{name}: {all:?}");
    let system = rod(&kinks.iter().map(|&k| all[k].0).collect::<Vec<_>>(), extra);
    let mut solver = simulate(&system, &grid, settings)?;
    let gradient = solver.gradient()?.clone();
    let of_kinks = solver.jacobian()?;
    let around = |k: usize| [k - 1, k, k + 1].map(|k| all[k].0);
    let times = |gradient: &Gradient| kinks.iter().map(|&k| by_time(&solver, gradient, around(k))).collect::<Vec<f64>>();
    let of_times = DMatrix::from_fn(kinks.len(), kinks.len(), |row, col| times(&of_kinks[row])[col]);
    let mu = of_times.transpose().lu().solve(&DVector::from(times(&gradient))).expect("kinks that are not grazed");
    let expected = of_kinks.iter().zip(&mu).fold(list(&gradient), |sum, (of, mu)| sum - list(of) * *mu);
    let frozen = gradient.frozen.as_ref().expect("kinks between nodes");
    let error = (list(frozen) - &expected).norm() / expected.norm();
    assert!(error < 1e-9, "{name}: {error:.1e}");
    assert!((&expected - list(&gradient)).norm() > 1e-3 * expected.norm(), "{name}: nothing to correct");
    Ok(())
}

#[test]
fn it_is_the_derivative_of_grids_that_follow_the_kinks() -> Result<(), Error> {
    let plain = Settings::default();
    for scheme in Scheme::ALL {
        assert_is_defined(scheme.name, grid(60), Settings { scheme, ..plain }, Extra::default())?;
    }
    let reading = Extra { reading: Some(35), ..Extra::default() };
    assert_is_defined("a reading", grid(60), plain, reading)?;
    assert_is_defined("restarts", grid(60), Settings { rebase_every: 1, drift_bound: 0.0, ..plain }, reading)?;
    let repeats_hinge = Extra { repeats_hinge: true, ..reading };
    let composed = Grid::composed(40, 0.03, Composition::Suzuki4);
    assert_is_defined("composed", composed, plain, Extra::default())?;
    assert_is_defined("dependent constraints", grid(60), plain, repeats_hinge)
}
