//! Motions of any length, piece by piece, and how exact their gradients are.

use hamiltonian_adjoint::check::{Input, complex_step, direct_differentiation, no_change};
use hamiltonian_adjoint::{Error, Gradient, Grid, Inputs, Report, Settings, Solver, Start, System, Trajectory, gradient};
use nalgebra::DVector;

use crate::statistics::{largest, relative_difference};

/// Steps to a piece: a piece of a long motion is dropped when it has been seen.
const PIECE: usize = 2000;

/// A motion with equal steps and the same force in all controls.
pub struct March<'a> {
    pub system: &'a System,
    pub start: Start,
    pub steps: usize,
    pub dt: f64,
    pub control: fn(f64) -> f64,
    pub settings: Settings,
    /// Every step starts from q and v, with σ = 0: what belongs to σ leaves p*.
    pub rebased: bool,
}

impl<'a> March<'a> {
    /// From rest, without controls.
    pub fn new(system: &'a System, steps: usize, dt: f64) -> Self {
        let start = Start::Velocity { q: system.initial_coordinates(), v: DVector::zeros(system.n()) };
        // A piece starts where the one before has drifted to.
        let settings = Settings { position_tolerance: f64::INFINITY, ..Settings::default() };
        March { system, start, steps, dt, control: |_| 0.0, settings, rebased: false }
    }

    /// Simulates piece by piece and shows each; a piece starts with the last node of the one before, from its q and p*
    /// unless it is rebased.
    ///
    /// # Errors
    /// A step without a solution.
    pub fn run(&self, mut see: impl FnMut(&Trajectory, &Inputs)) -> Result<Report, Error> {
        let mut solver = Solver::new(self.system, self.settings);
        let mut inputs = Inputs::at_rest(self.system, Grid::uniform(0, self.dt));
        inputs.start = self.start.clone();
        let mut all = Report::default();
        let piece = if self.rebased { 1 } else { PIECE };
        for first in (0..self.steps).step_by(piece) {
            let count = piece.min(self.steps - first);
            inputs.grid = Grid { start: first as f64 * self.dt, steps: vec![self.dt; count] };
            let times = inputs.grid.times();
            inputs.controls = nalgebra::DMatrix::from_fn(self.system.k(), count + 1, |_, i| (self.control)(times[i]));
            let motion = solver.simulate(&inputs)?;
            see(motion, &inputs);
            let (q, v) = (motion.q.column(count).into_owned(), motion.v.column(count).into_owned());
            inputs.start = match self.rebased {
                true => Start::Velocity { q, v },
                false => Start::Momentum { q, p_star: motion.p_star.column(count).into_owned() },
            };
            let report = solver.report();
            all.worst_pivot = all.worst_pivot.min(report.worst_pivot);
            all.most_iterations = all.most_iterations.max(report.most_iterations);
            all.newton_iterations += report.newton_iterations;
        }
        Ok(all)
    }

    /// A number of each node and its time, up to where a step has no solution.
    pub fn record(&self, mut number: impl FnMut(&[f64], &[f64]) -> f64) -> Record {
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(self.steps + 1);
        let result = self.run(|motion, _| {
            points.pop();
            for i in 0..motion.computed {
                let (q, v) = (motion.q.column(i), motion.v.column(i));
                points.push((motion.times[i], number(q.as_slice(), v.as_slice())));
            }
        });
        Record { points, stopped: result.err() }
    }

    /// ‖Φ‖∞ of each node and its time, up to where a step has no solution.
    pub fn violations(&self) -> Record {
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(self.steps + 1);
        let result = self.run(|motion, inputs| {
            points.pop();
            let phi = motion.phi(self.system, inputs).expect("the inputs of this piece");
            points.extend(phi.column_iter().zip(&motion.times).map(|(phi, &time)| (time, phi.amax())));
        });
        Record { points, stopped: result.err() }
    }
}

/// A number over time, and why it ends early if it does.
#[derive(Default)]
pub struct Record {
    pub points: Vec<(f64, f64)>,
    pub stopped: Option<Error>,
}

impl Record {
    /// All of it.
    ///
    /// # Errors
    /// Why it ends early.
    pub fn complete(self) -> Result<Vec<(f64, f64)>, Error> {
        self.stopped.map_or(Ok(self.points), Err)
    }
}

/// The largest |deviation| from the first value, so far, at up to a hundred places.
pub fn envelope(record: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let start = record.first().map_or(0.0, |first| first.1);
    let stride = record.len().div_ceil(100).max(1);
    let mut most = 0.0f64;
    let so_far = record.chunks(stride).map(|chunk| {
        most = chunk.iter().fold(most, |most, (_, value)| most.max((value - start).abs()));
        (chunk[chunk.len() - 1].0, most)
    });
    so_far.filter(|(time, _)| *time > 0.0).collect()
}

/// The largest |deviation| from the first value among the nodes of these shares of the record.
pub fn deviation(record: &[(f64, f64)], (from, to): (f64, f64)) -> f64 {
    let at = |share: f64| (share * record.len() as f64) as usize;
    let start = record[0].1;
    record[at(from)..at(to)].iter().fold(0.0, |most, (_, value)| f64::max(most, (value - start).abs()))
}

/// At rest, all controls this wave of an amplitude.
pub fn shaken(system: &System, steps: usize, dt: f64, amplitude: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, dt));
    let nodes = inputs.controls.ncols();
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| {
        *u = amplitude * (0.4 + (7.0 * i as f64 / nodes as f64).sin());
    });
    inputs
}

/// The relative differences of the adjoint from complex step with respect to controls, design variables, q₀, v₀ or p*₀, and step
/// lengths, each relative to the largest derivative of its kind; of each kind up to `most` inputs are looked at.
///
/// # Errors
/// A step without a solution.
pub fn gradient_errors(system: &System, inputs: &Inputs, settings: Settings, most: usize) -> Result<[f64; 5], Error> {
    let gradient = gradient(system, inputs, settings)?;
    let kinds: [fn(&Input) -> bool; 5] = [
        |input| matches!(input, Input::Control { .. }),
        |input| matches!(input, Input::Design(_)),
        |input| matches!(input, Input::Coordinate(_)),
        |input| matches!(input, Input::Rate(_)),
        |input| matches!(input, Input::Step(_)),
    ];
    let all = Input::all(inputs);
    let mut errors = [0.0; 5];
    for (error, kind) in errors.iter_mut().zip(kinds) {
        let of_kind: Vec<Input> = all.iter().filter(|input| kind(input)).copied().collect();
        let stride = of_kind.len().div_ceil(most).max(1);
        let sample: Vec<Input> = of_kind.into_iter().step_by(stride).collect();
        *error = difference(system, inputs, settings, &gradient, &sample)?;
    }
    Ok(errors)
}

/// The worst of them.
///
/// # Errors
/// A step without a solution.
pub fn gradient_error(system: &System, inputs: &Inputs, settings: Settings, most: usize) -> Result<f64, Error> {
    Ok(largest(&gradient_errors(system, inputs, settings, most)?))
}

/// By how much a motion amplifies a change of its start: the largest |δq| that follows from one in all v₀ or p*₀ of size 1.
///
/// Rounding is amplified alike, and two computations of one motion, or of its gradient, cannot agree better.
///
/// # Errors
/// A step without a solution.
pub fn amplification(system: &System, inputs: &Inputs) -> Result<f64, Error> {
    let mut direction = no_change(inputs);
    direction.start.rate_mut().fill(1.0);
    let settings = Settings { position_tolerance: f64::INFINITY, velocity_tolerance: f64::INFINITY, ..Settings::default() };
    Ok(direct_differentiation(system, inputs, settings, &direction)?.motion.q.amax())
}

fn difference(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    gradient: &Gradient,
    sample: &[Input],
) -> Result<f64, Error> {
    let reference = complex_step(system, inputs, settings, sample)?;
    let ours: Vec<f64> = sample.iter().map(|input| input.in_gradient(gradient)).collect();
    Ok(if ours == reference { 0.0 } else { relative_difference(&ours, &reference) })
}

/// The largest |derivative| with respect to a control.
pub fn size(gradient: &Gradient) -> f64 {
    gradient.controls.amax()
}
