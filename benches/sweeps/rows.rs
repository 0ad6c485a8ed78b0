//! One row of a table: a scene, its inputs, and what is timed of it.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId};
use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, Solver, System};

/// A compiled scene at rest with constant controls.
pub struct Row {
    system: System,
    inputs: Inputs,
}

impl Row {
    pub fn new(scene: Scene, steps: usize, dt: f64, control: f64) -> Self {
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
        inputs.controls.fill(control);
        Row { system, inputs }
    }

    /// The number of planar bodies.
    pub fn bodies(&self) -> usize {
        self.system.n() / 3
    }

    pub fn simulate(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, Settings::default());
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| solver.simulate(&self.inputs).expect("a motion").computed)
        });
    }

    /// The adjoint sweep alone, after one simulation.
    pub fn gradient(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, Settings::default());
        solver.simulate(&self.inputs).expect("a motion");
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| solver.gradient().expect("a gradient").value)
        });
    }

    pub fn both(&self, group: &mut BenchmarkGroup<WallTime>, function: &str, name: &str) {
        let mut solver = Solver::new(&self.system, Settings::default());
        group.bench_function(BenchmarkId::new(function, name), |bencher| {
            bencher.iter(|| {
                solver.simulate(&self.inputs).expect("a motion");
                solver.gradient().expect("a gradient").value
            })
        });
    }
}
