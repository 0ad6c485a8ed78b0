//! One row of a table: a scene, its inputs, and the timed computations.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId};
use hamiltonian_adjoint::{Grid, Inputs, LongSolver, Scene, Settings, Solver, System};

/// A compiled scene at rest with constant controls.
pub struct Row {
    /// The scene.
    pub system: System,
    /// Inputs, starting from rest.
    pub inputs: Inputs,
    /// Settings, initially the default ones.
    pub settings: Settings,
}

impl Row {
    /// A scene with the given number of steps and one value for all controls.
    pub fn new(scene: Scene, steps: usize, dt: f64, control: f64) -> Self {
        Self::of(scene.compile().expect("a scene"), steps, dt, control)
    }

    /// A compiled scene with the given number of steps and one value for all controls.
    pub fn of(system: System, steps: usize, dt: f64, control: f64) -> Self {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
        inputs.controls.fill(control);
        Row { system, inputs, settings: Settings::default() }
    }

    /// The number of planar bodies.
    pub fn bodies(&self) -> usize {
        self.system.n() / 3
    }

    /// Times a simulation.
    pub fn simulate(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, self.settings);
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| solver.simulate(&self.inputs).expect("a motion").computed)
        });
    }

    /// Times a simulation, and prints corrections and factorisations per step.
    pub fn simulate_and_count(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, self.settings);
        solver.simulate(&self.inputs).expect("a motion");
        let (report, steps) = (solver.report(), self.inputs.grid.steps.len() as f64);
        let [iterations, factorisations, reused] =
            [report.newton_iterations, report.factorisations, report.reused_factors].map(|count| count as f64 / steps);
        println!(
            "{function}, {name}: {iterations:.2} corrections a step, {reused:.2} with old factors, {factorisations:.2} factorisations"
        );
        self.simulate(group, function, name);
    }

    /// Times the adjoint sweep alone, after one simulation.
    pub fn gradient(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, self.settings);
        solver.simulate(&self.inputs).expect("a motion");
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| solver.gradient().expect("a gradient").value)
        });
    }

    /// Times a product of the Hessian with a direction of the controls, after one gradient.
    pub fn product(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, self.settings);
        solver.simulate(&self.inputs).expect("a motion");
        let mut direction = self.inputs.no_change();
        direction.controls.fill(1.0);
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| solver.hessian_product(&direction).expect("a product").value)
        });
    }

    /// Times a simulation and its gradient.
    pub fn both(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, self.settings);
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| {
                solver.simulate(&self.inputs).expect("a motion");
                solver.gradient().expect("a gradient").value
            })
        });
    }

    /// Times a simulation and the gradients of all outputs.
    pub fn jacobian(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, self.settings);
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| {
                solver.simulate(&self.inputs).expect("a motion");
                solver.jacobian().expect("a Jacobian").len()
            })
        });
    }

    /// Times a simulation and its gradient within the given number of bytes.
    pub fn both_within(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str, bytes: usize) {
        let mut solver = LongSolver::new(&self.system, self.settings, bytes);
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| solver.gradient(&self.inputs).expect("a gradient").value)
        });
    }
}
