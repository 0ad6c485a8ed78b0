//! The runs that the figures need. Each is computed once, when it is first needed.

use std::cell::{OnceCell, RefCell};

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::optimize::{Free, MotionProblem, Variables};
use hamiltonian_adjoint::{Inputs, Settings as SolverSettings, Solver, System, Trajectory};

use crate::bar::bar;
use crate::constraints::Violations;
use crate::error::Error;
use crate::settings::Settings;
use crate::statistics::relative_difference;
use crate::steepest_descent::{self, Iterate};
use crate::timing::{self, Timing};

/// The example with its runs.
pub struct Experiment {
    pub settings: Settings,
    pub system: System,
    /// The inputs of the starting iteration.
    pub inputs: Inputs,
    pub(crate) violations: OnceCell<Violations>,
    pub(crate) gradients: OnceCell<Gradients>,
    pub(crate) optimum: OnceCell<Optimum>,
    pub(crate) timing: OnceCell<Timing>,
    /// Warnings of the library in these runs, without duplicates.
    pub warnings: RefCell<Vec<String>>,
}

/// dJ/du at the start, by two methods.
pub struct Gradients {
    pub adjoint: Vec<f64>,
    /// By complex step, one simulation for each control.
    pub complex_step: Vec<f64>,
}

/// The optimisation and its final motion.
pub struct Optimum {
    /// All iterates, including the start.
    pub history: Vec<Iterate>,
    /// The motion under the identified force, and its inputs.
    pub motion: Trajectory,
    pub inputs: Inputs,
}

impl Experiment {
    pub fn new(settings: Settings) -> Result<Self, Error> {
        let system = settings.example().scene().compile()?;
        Ok(Experiment {
            inputs: settings.inputs(&system),
            settings,
            system,
            violations: OnceCell::new(),
            gradients: OnceCell::new(),
            optimum: OnceCell::new(),
            timing: OnceCell::new(),
            warnings: RefCell::default(),
        })
    }

    /// Constraint violations of the starting iteration.
    pub fn violations(&self) -> Result<&Violations, Error> {
        once(&self.violations, || {
            let mut solver = Solver::new(&self.system, SolverSettings::default());
            solver.simulate(&self.inputs)?;
            self.note_warnings(&solver);
            Ok(Violations::of(&self.system, solver.inputs(), solver.trajectory())?)
        })
    }

    /// The gradients at the start.
    pub fn gradients(&self) -> Result<&Gradients, Error> {
        once(&self.gradients, || {
            let settings = SolverSettings::default();
            let mut solver = Solver::new(&self.system, settings);
            solver.simulate(&self.inputs)?;
            let gradient = solver.gradient()?.clone();
            self.note_warnings(&solver);
            let controls = self.controls();
            Ok(Gradients {
                adjoint: controls.iter().map(|control| control.in_gradient(&gradient)).collect(),
                complex_step: complex_step(&self.system, &self.inputs, settings, &controls)?,
            })
        })
    }

    /// The optimisation, with a progress bar on a terminal.
    pub fn optimum(&self) -> Result<&Optimum, Error> {
        once(&self.optimum, || {
            let iterations = self.settings.iterations;
            let bar = bar("steepest descent", iterations as usize);
            let force = Free::control(self.system.control(0));
            let variables = Variables::new(&self.system, &self.inputs, vec![force])?;
            let mut problem = MotionProblem::new(&self.system, SolverSettings::default(), self.inputs.clone(), variables)?;
            let u = problem.start();
            let report = |iterate: &Iterate| {
                bar.set_message(format!("J = {:.3e}", iterate.cost));
                bar.inc(u64::from(iterate.step > 0.0));
            };
            let history = steepest_descent::minimise(&mut problem, u, &self.settings.search, iterations as usize, report)?;
            bar.finish_and_clear();
            let inputs = problem.inputs_at(&history[history.len() - 1].u);
            let motion = problem.solver.simulate(&inputs)?.clone();
            self.note_warnings(&problem.solver);
            let inputs = problem.solver.inputs().clone();
            Ok(Optimum { history, motion, inputs })
        })
    }

    /// The timing of section 4.
    pub fn timing(&self) -> Result<&Timing, Error> {
        once(&self.timing, || Ok(timing::measure(&self.system, &self.inputs, &self.controls())?))
    }

    fn note_warnings(&self, solver: &Solver) {
        let mut known = self.warnings.borrow_mut();
        for warning in solver.report().warnings.iter().chain(&solver.adjoint_report().warnings).map(ToString::to_string) {
            if !known.contains(&warning) {
                known.push(warning);
            }
        }
    }

    /// u_0 … u_N.
    fn controls(&self) -> Vec<Input> {
        (0..self.inputs.grid.nodes()).map(|node| Input::Control { channel: 0, node }).collect()
    }
}

impl Gradients {
    /// |adjoint − complex step| at each node.
    pub fn differences(&self) -> Vec<f64> {
        self.adjoint.iter().zip(&self.complex_step).map(|(a, c)| (a - c).abs()).collect()
    }

    /// The largest difference relative to the gradient at the same node, and that node.
    pub fn worst_component(&self) -> (usize, f64) {
        let relative = |(d, c): (f64, &f64)| if d == 0.0 { 0.0 } else { d / c.abs() };
        let relative = self.differences().into_iter().zip(&self.complex_step).map(relative).enumerate();
        relative.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// The largest difference relative to the largest component.
    pub fn relative_error(&self) -> f64 {
        relative_difference(&self.adjoint, &self.complex_step)
    }
}

impl Optimum {
    pub fn end(&self) -> &Iterate {
        &self.history[self.history.len() - 1]
    }

    /// The first iteration with a cost below the bound.
    pub fn first_below(&self, cost: f64) -> Option<usize> {
        self.history.iter().position(|iterate| iterate.cost < cost)
    }

    /// Number of iterations.
    pub fn iterations(&self) -> usize {
        self.history.len() - 1
    }

    /// The node at which the cart is furthest to the right.
    pub fn cart_rightmost(&self) -> usize {
        self.motion.q.row(0).transpose().imax()
    }

    /// s.
    pub fn cart_rightmost_time(&self) -> f64 {
        self.motion.times[self.cart_rightmost()]
    }
}

/// The value in the cell; computed if the cell is empty.
fn once<T>(cell: &OnceCell<T>, make: impl FnOnce() -> Result<T, Error>) -> Result<&T, Error> {
    match cell.get() {
        Some(value) => Ok(value),
        None => make().map(|value| cell.get_or_init(|| value)),
    }
}
