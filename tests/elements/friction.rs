//! Dry friction that saturates within a step: nodes satisfy their equations, and derivatives are checked to the end.

use hamiltonian_adjoint::check::{self, Input, Random, complex_step};
use hamiltonian_adjoint::{
    Cost, CostPoint, Force, ForcePoint, Grid, Inputs, KineticEnergy, Scalar, Scene, Scheme, Settings, Solver, Sum, System,
};
use nalgebra::SVector;

/// T = ½ m v², and J = (q − 1)² + v².
struct Block;
impl KineticEnergy<1, 1> for Block {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 1>, v: &SVector<S, 1>, m: &SVector<S, 1>) -> S {
        v[0] * v[0] * m[0] * 0.5
    }
}
impl Cost<1> for Block {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        (at.q[0] - 1.0).powi(2) + at.v[0] * at.v[0]
    }
}

/// u − F tanh(v/s) + a v with b = [F, s, a].
struct Dry;
impl Force<1, 1, 3> for Dry {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 3>) -> SVector<S, 1> {
        SVector::from([at.u[0] - b[0] * (at.v[0] / b[1]).tanh() + b[2] * at.v[0]])
    }
}

/// Blocks side by side under one force, each with its mass and b.
fn blocks(all: &[(f64, [f64; 3])]) -> System {
    let mut scene = Scene::new();
    let push = scene.control("push");
    for (k, (mass, b)) in all.iter().enumerate() {
        let [q] = scene.coordinates(&format!("block {k}"), ["x"]);
        scene.kinetic_energy(&format!("mass {k}"), Block, [q], [(*mass).into()]);
        scene.force(&format!("friction {k}"), Dry, [q], [push], b.map(Into::into));
        scene.cost(&format!("end {k}"), Block, Sum::Terminal, [q], [], [], []);
    }
    scene.compile().expect("scene")
}

/// What is left of the trapezoidal rule's equations at the worst node, and their terms: |r_k|/√m_k of all blocks.
fn left(all: &[(f64, [f64; 3])], solver: &Solver) -> f64 {
    let (motion, inputs) = (solver.trajectory(), solver.inputs());
    let force = |[f, s, a]: [f64; 3], i: usize, v: f64| inputs.controls[(0, i)] - f * (v / s).tanh() + a * v;
    let mut worst = 0.0f64;
    for i in 1..motion.computed {
        let h = 0.5 * inputs.grid.steps[i - 1];
        let (mut residual, mut terms) = (0.0f64, 0.0f64);
        for (k, &(m, b)) in all.iter().enumerate() {
            let (v, before) = (motion.v[(k, i)], motion.v[(k, i - 1)]);
            let (now, last) = (force(b, i, v), force(b, i - 1, before));
            residual = residual.max((m * (v - before) - h * (now + last)).abs() / m.sqrt());
            terms = terms.max((m * (v.abs() + before.abs()) + h * (now.abs() + last.abs())) / m.sqrt());
        }
        worst = worst.max(residual / terms);
    }
    worst
}

/// Blocks of which one is lighter by up to nine orders: its velocity and its slip are small beside what the other's is rounded by.
#[test]
fn nodes_satisfy_their_equations_whatever_the_masses() {
    let mut random = Random::new(3);
    let mut log = |a: f64, b: f64| a * (b / a).powf(random.uniform(0.0, 1.0));
    let mut worst = 0.0f64;
    for case in 0..400 {
        let all: Vec<_> = (0..1 + case % 3).map(|_| (log(1e-6, 1e3), [log(0.1, 1e3), log(1e-7, 0.3), 0.0])).collect();
        let system = blocks(&all);
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(12, log(1e-3, 0.1)));
        let size = log(0.1, 300.0);
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = if (i / 3) % 2 == 0 { size } else { -size });
        inputs.start.rate_mut().iter_mut().for_each(|v| *v = log(1e-2, 3.0));
        let mut solver = Solver::new(&system, Settings::default());
        let _ = solver.simulate(&inputs);
        let left = left(&all, &solver);
        worst = worst.max(left);
    }
    println!("at most {worst:.1e}");
    assert!(worst <= 1e-8, "{worst:e}");
}

/// Behind a bend K is small, and corrections are up to 10⁸ times as long as what they are for.
#[test]
fn corrections_that_are_shortened_keep_all_digits() {
    for small in [1e-5, 1e-6, 1e-7, 1e-8] {
        for slip in [1e-2, 1e-3] {
            let h = 0.01;
            let all = [(1.0, [1.0 / h, slip, (1.0 - small) / h])];
            let system = blocks(&all);
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 2.0 * h));
            inputs.controls.fill((small - 0.7) / (2.0 * h));
            inputs.start.rate_mut().fill(1.0);
            let mut solver = Solver::new(&system, Settings { tolerance: 0.0, ..Settings::default() });
            let _ = solver.simulate(&inputs);
            let left = left(&all, &solver);
            println!("{small:e}, {slip}: {left:.1e} up to node {}", solver.trajectory().computed - 1);
            assert!(left <= 1e-15 && solver.trajectory().computed > 1, "{small:e}, {slip}: {left:e}");
        }
    }
}

/// A block that creeps forgets the lengths of steps before: that derivative of the force is what is left of terms that cancel.
#[test]
fn derivatives_of_a_block_that_creeps_are_checked_to_the_end() {
    for scheme in Scheme::ALL {
        for slip in [1e-2, 1e-4, 1e-5] {
            let system = blocks(&[(1.0, [250.0, slip, 0.0])]);
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(24, 0.01));
            inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = if (i / 3) % 2 == 0 { 20.0 } else { -20.0 });
            let settings = Settings { scheme, ..Settings::default() };
            complex_step(&system, &inputs, settings, &Input::all(&inputs)).expect("a complex step");
            let report = check::gradient(&system, &inputs, settings).run().expect("a check");
            assert!(report.passed(), "{}, {slip} m/s: {report}", scheme.name);
        }
    }
}
