//! The forward sweep: consistent start, then one step after the other.

use nalgebra::{DMatrix, DVector};

use crate::linear::Breakdown;
use crate::predict::Predictor;
use crate::start;
use crate::system::At;
use crate::trajectory::{Report, column, column_mut};
use crate::trapezoid::{Given, Newton, StepFailure, StepStart, Unknowns};
use crate::{Error, Grid, Inputs, Settings, Start, System, Trajectory};

/// A motion, with what the adjoint sweep needs of it.
pub(crate) struct Forward {
    pub(crate) inputs: Inputs,
    pub(crate) trajectory: Trajectory,
    /// The second derivatives of all varying elements, one column a node.
    pub(crate) blocks: DMatrix<f64>,
    pub(crate) newton: Newton,
    pub(crate) report: Report,
    predictor: Predictor,
    start_q: Vec<f64>,
    start_p: Vec<f64>,
}

impl Forward {
    pub(crate) fn new(system: &System) -> Self {
        let empty = Inputs {
            grid: Grid { start: 0.0, steps: Vec::new() },
            start: Start::Velocity { q: DVector::zeros(0), v: DVector::zeros(0) },
            controls: DMatrix::zeros(0, 0),
            design: DVector::zeros(0),
        };
        Forward {
            inputs: empty,
            trajectory: Trajectory::zeros(system, 0),
            blocks: DMatrix::zeros(0, 0),
            newton: Newton::new(system),
            report: Report::default(),
            predictor: Predictor::new(),
            start_q: vec![0.0; system.n()],
            start_p: vec![0.0; system.n()],
        }
    }

    pub(crate) fn run(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<(), Error> {
        self.trajectory.computed = 0;
        inputs.check(system)?;
        self.prepare(system, inputs);
        self.newton.evaluation.set_design(system, inputs.design.as_slice());
        start::solve(self, system, settings)?;
        for step in 1..self.inputs.grid.nodes() {
            self.step(system, step, settings)?;
        }
        Ok(())
    }

    /// Copies the inputs and makes room; allocates only when the grid is longer than any before.
    fn prepare(&mut self, system: &System, inputs: &Inputs) {
        let nodes = inputs.grid.nodes();
        if self.trajectory.times.len() != nodes {
            self.trajectory = Trajectory::zeros(system, nodes);
            self.blocks = DMatrix::zeros(system.block_len(), nodes);
        }
        self.inputs.copy_from(inputs);
        self.report = Report::default();
        let times = &mut self.trajectory.times;
        times[0] = inputs.grid.start;
        for (i, dt) in inputs.grid.steps.iter().enumerate() {
            times[i + 1] = times[i] + dt;
        }
    }

    fn step(&mut self, system: &System, i: usize, settings: &Settings) -> Result<(), Error> {
        let h = 0.5 * self.inputs.grid.steps[i - 1];
        let before = self.trajectory.columns(i - 1);
        let advance = |start: &mut [f64], x: &[f64], rate: &[f64]| {
            start.iter_mut().zip(x.iter().zip(rate)).for_each(|(start, (x, rate))| *start = x + h * rate);
        };
        advance(&mut self.start_q, before.q, before.v);
        advance(&mut self.start_p, before.p_star, before.p_star_dot);
        self.predictor.predict(&self.inputs.grid.steps, &mut self.trajectory, i);
        self.solve_node(system, i, h, settings)?;
        let rates = column(&self.trajectory.p_star_dot, i);
        let now = column_mut(&mut self.trajectory.p_star, i);
        for ((p_star, start), rate) in now.iter_mut().zip(&self.start_p).zip(rates) {
            *p_star = start + h * rate;
        }
        self.trajectory.computed = i + 1;
        Ok(())
    }

    /// Solves for (v, σ) of node `i` from the values in its columns, with q = start_q + h v.
    pub(crate) fn solve_node(&mut self, system: &System, i: usize, h: f64, settings: &Settings) -> Result<(), Error> {
        let from = StepStart { h, q: &self.start_q, p_star: &self.start_p };
        let given = Given {
            u: column(&self.inputs.controls, i),
            t: self.trajectory.times[i],
            design: self.inputs.design.as_slice(),
        };
        let mut unknowns = Unknowns {
            q: column_mut(&mut self.trajectory.q, i),
            v: column_mut(&mut self.trajectory.v, i),
            sigma: column_mut(&mut self.trajectory.sigma, i),
            p_star_dot: column_mut(&mut self.trajectory.p_star_dot, i),
        };
        let solved = self.newton.solve_step(system, &from, given, &mut unknowns, settings, &mut self.report);
        solved.map_err(|failure| self.explain(system, i, failure))?;
        column_mut(&mut self.blocks, i).copy_from_slice(&self.newton.evaluation.blocks);
        Ok(())
    }

    pub(crate) fn set_start(&mut self, q: &[f64], p_star: &[f64]) {
        self.start_q.copy_from_slice(q);
        self.start_p.copy_from_slice(p_star);
    }

    /// Factors K(0) at the given state, before anything is solved with it.
    pub(crate) fn factor_start(&mut self, system: &System) -> Result<(), Breakdown> {
        let from = StepStart { h: 0.0, q: &self.start_q, p_star: &self.start_p };
        let given = Given {
            u: column(&self.inputs.controls, 0),
            t: self.trajectory.times[0],
            design: self.inputs.design.as_slice(),
        };
        let (v, sigma) = (column(&self.trajectory.v, 0), column(&self.trajectory.sigma, 0));
        self.newton.factor_at(system, &from, given, (v, sigma), &mut self.report)
    }

    fn explain(&self, system: &System, i: usize, failure: StepFailure) -> Error {
        let time = self.trajectory.times[i];
        match failure {
            StepFailure::Singular(breakdown) if !breakdown.pivot.is_finite() => self.not_finite(system, i),
            StepFailure::Singular(breakdown) => system.singular_step(&breakdown, i, time),
            StepFailure::Diverged { iterations, residual, unknown } => {
                Error::Newton { step: i, time, iterations, residual, equation: system.residual_name(unknown) }
            }
            StepFailure::NotFinite => self.not_finite(system, i),
        }
    }

    /// Which element is to blame for a value that is not finite: tried where the last good node stood.
    fn not_finite(&self, system: &System, i: usize) -> Error {
        let time = self.trajectory.times[i];
        let y = self.trajectory.columns(i.saturating_sub(1));
        let (u, design) = (column(&self.inputs.controls, i), self.inputs.design.as_slice());
        let q = if i == 0 { &self.start_q } else { y.q };
        let at = At { q, v: y.v, sigma: y.sigma, u, t: time, design };
        match system.find_not_finite(&at) {
            Some(element) => Error::Model { element, node: i, time },
            None => Error::Newton {
                step: i,
                time,
                iterations: self.report.most_iterations,
                residual: f64::INFINITY,
                equation: "all equations (the iteration overflowed)".into(),
            },
        }
    }
}
