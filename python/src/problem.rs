//! Optimisation problems as Python states them.

use std::ops::ControlFlow;

use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, MultipleShooting, Problem as Optimised, Quantity, Trials, Variables,
};
use hamiltonian_adjoint::{Coordinate, Error, Inputs, Settings, System as Compiled};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Given, control_names, coordinate_names, number, settings};
use crate::errors::{raised, wrong_input};
use crate::scene::System;

/// A free quantity: its kind, its name, a number, bounds, scale, and whether the variable is its logarithm.
#[derive(FromPyObject)]
pub(crate) struct GivenFree(String, String, usize, (f64, f64), f64, bool);

impl GivenFree {
    pub(crate) fn free(&self, system: &Compiled) -> PyResult<Free> {
        let GivenFree(kind, name, count, (least, most), scale, logarithm) = self;
        let control = || number("control", name, control_names(system)).map(|k| system.control(k));
        let coordinate = || number("coordinate", name, coordinate_names(system)).map(|i| system.coordinate(i));
        let designs = || (0..system.designs()).map(|p| system.design_name(p));
        let quantity = match kind.as_str() {
            "control" => Quantity::Control(control()?),
            "linear" => Quantity::LinearControl(control()?, *count),
            "pieces" => Quantity::PiecewiseControl(control()?, *count),
            "spline" => Quantity::SplineControl(control()?, *count),
            "design" => Quantity::Design(number("design variable", name, designs()).map(|p| system.design(p))?),
            "coordinate" => Quantity::Coordinate(coordinate()?),
            "rate" => Quantity::Rate(coordinate()?),
            "duration" => Quantity::Duration,
            "step" => Quantity::StepLength(*count),
            other => return Err(wrong_input(&format!("`{other}` cannot be free"))),
        };
        let free = Free::new(quantity).within(*least, *most).scaled(*scale);
        Ok(if *logarithm { free.logarithmic() } else { free })
    }
}

/// The motions of a problem of Python, and their division into segments.
#[derive(FromPyObject)]
pub(crate) struct GivenProblem<'py> {
    #[pyo3(attribute("_motions"))]
    motions: Vec<GivenMotion<'py>>,
    #[pyo3(attribute("_shooting"))]
    shooting: Option<GivenShooting>,
    /// True if the motions share only design variables.
    #[pyo3(attribute("_shares_designs"))]
    shares_designs: bool,
}

/// The attributes of `Problem` of Python.
#[derive(FromPyObject)]
struct GivenMotion<'py> {
    system: Bound<'py, System>,
    inputs: Given<'py>,
    #[pyo3(attribute("_free"))]
    free: Vec<GivenFree>,
    #[pyo3(attribute("_constraints"))]
    constraints: Vec<(String, f64, f64)>,
    settings: Bound<'py, PyDict>,
}

/// The number of segments, the names of their states, guessed coordinates and velocities at all nodes, and the outputs that belong to the cost.
#[derive(FromPyObject)]
struct GivenShooting(usize, Vec<String>, Vec<(bool, usize, Vec<f64>)>, Vec<String>);

/// A statement of a problem, from which each thread makes its own problem.
pub(crate) struct Statement {
    pub(crate) motions: Vec<Motion>,
    shooting: Option<Shooting>,
    shares_designs: bool,
}

/// A statement of a problem of one motion.
pub(crate) struct Motion {
    pub(crate) system: Compiled,
    inputs: Inputs,
    free: Vec<Free>,
    /// Outputs by their numbers, with their intervals.
    constraints: Vec<(usize, Interval)>,
    settings: Settings,
}

struct Shooting {
    segments: usize,
    states: Vec<Coordinate>,
    guess: Vec<(bool, usize, Vec<f64>)>,
    minimised: Vec<usize>,
}

/// The number of an output.
pub(crate) fn output(system: &Compiled, name: &str) -> PyResult<usize> {
    number("output", name, (0..system.outputs()).map(|k| system.output_name(k)))
}

impl GivenProblem<'_> {
    pub(crate) fn statement(&self) -> PyResult<Statement> {
        let motions = self.motions.iter().map(GivenMotion::motion).collect::<PyResult<Vec<_>>>()?;
        let shooting = match (&self.shooting, motions.first()) {
            (Some(of), Some(motion)) => Some(of.shooting(&motion.system)?),
            _ => None,
        };
        Ok(Statement { motions, shooting, shares_designs: self.shares_designs })
    }
}

impl GivenMotion<'_> {
    fn motion(&self) -> PyResult<Motion> {
        let system = self.system.get().system.clone();
        let interval = |(name, least, most): &(String, f64, f64)| Ok((output(&system, name)?, Interval::new(*least, *most)));
        Ok(Motion {
            inputs: self.inputs.inputs(&system)?,
            free: self.free.iter().map(|free| free.free(&system)).collect::<PyResult<_>>()?,
            constraints: self.constraints.iter().map(interval).collect::<PyResult<_>>()?,
            settings: settings(Some(&self.settings))?,
            system,
        })
    }
}

impl GivenShooting {
    fn shooting(&self, system: &Compiled) -> PyResult<Shooting> {
        let GivenShooting(segments, states, guess, minimised) = self;
        let state = |name: &String| number("coordinate", name, coordinate_names(system)).map(|i| system.coordinate(i));
        Ok(Shooting {
            segments: *segments,
            states: states.iter().map(state).collect::<PyResult<_>>()?,
            guess: guess.clone(),
            minimised: minimised.iter().map(|name| output(system, name)).collect::<PyResult<_>>()?,
        })
    }
}

/// A single motion, one in segments, or several motions.
pub(crate) enum Problem {
    Motion(Box<MotionProblem>),
    Shooting(Box<MultipleShooting>),
    Trials(Trials),
}

impl Statement {
    /// The problem; each motion stops if its callback returns `Break`.
    pub(crate) fn problem<W>(&self, watcher: impl Fn() -> W) -> Result<Problem, Error>
    where
        W: FnMut() -> ControlFlow<()> + Send + 'static,
    {
        match (&self.motions[..], &self.shooting) {
            ([motion], None) if !self.shares_designs => Ok(Problem::Motion(Box::new(motion.problem(watcher())?))),
            ([motion], Some(of)) => Ok(Problem::Shooting(Box::new(motion.in_segments(of, watcher())?))),
            _ => Ok(Problem::Trials(self.trials(watcher)?)),
        }
    }

    /// The motions as trials, also a single one.
    pub(crate) fn trials<W>(&self, watcher: impl Fn() -> W) -> Result<Trials, Error>
    where
        W: FnMut() -> ControlFlow<()> + Send + 'static,
    {
        let motions = self.motions.iter().map(|motion| motion.problem(watcher())).collect::<Result<_, Error>>()?;
        if self.shares_designs { Trials::sharing_designs(motions) } else { Trials::new(motions) }
    }

    /// The problem without a callback.
    pub(crate) fn unwatched(&self) -> Result<Problem, Error> {
        self.problem(|| || ControlFlow::Continue(()))
    }
}

impl Motion {
    pub(crate) fn problem(
        &self,
        mut watch: impl FnMut() -> ControlFlow<()> + Send + 'static,
    ) -> Result<MotionProblem, Error> {
        let Motion { system, inputs, free, settings, .. } = self;
        let variables = Variables::new(system, inputs, free.clone())?;
        let mut problem = MotionProblem::new(system, *settings, inputs.clone(), variables)?;
        self.constraints.iter().for_each(|(k, to)| problem.constrain(system.output(*k), *to));
        problem.solver.watch(move |_| watch());
        Ok(problem)
    }

    fn in_segments(
        &self,
        of: &Shooting,
        mut watch: impl FnMut() -> ControlFlow<()> + Send + 'static,
    ) -> Result<MultipleShooting, Error> {
        let Motion { system, inputs, free, settings, .. } = self;
        let mut problem = MultipleShooting::new(system, *settings, inputs.clone(), free.clone(), &of.states, of.segments)?;
        problem.guess(|node, q, v| {
            for (is_rate, i, values) in &of.guess {
                (if *is_rate { &mut *v } else { &mut *q })[*i] = values[node];
            }
        })?;
        of.minimised.iter().for_each(|k| problem.minimise(system.output(*k)));
        self.constraints.iter().for_each(|(k, to)| problem.constrain(system.output(*k), *to));
        problem.watch(move |_| watch());
        Ok(problem)
    }
}

impl Problem {
    pub(crate) fn any(&mut self) -> &mut dyn Optimised {
        match self {
            Problem::Motion(of) => &mut **of,
            Problem::Shooting(of) => &mut **of,
            Problem::Trials(of) => of,
        }
    }

    pub(crate) fn start(&self) -> Vec<f64> {
        match self {
            Problem::Motion(of) => of.start(),
            Problem::Shooting(of) => of.start(),
            Problem::Trials(of) => of.start(),
        }
    }

    /// The inputs of each motion at a point.
    pub(crate) fn inputs_at(&self, x: &[f64]) -> Vec<Inputs> {
        match self {
            Problem::Motion(of) => vec![of.inputs_at(x)],
            Problem::Shooting(of) => vec![of.inputs_at(x)],
            Problem::Trials(of) => of.inputs_at(x),
        }
    }

    fn seen(&self) -> &dyn Optimised {
        match self {
            Problem::Motion(of) => &**of,
            Problem::Shooting(of) => &**of,
            Problem::Trials(of) => of,
        }
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let of = self.seen();
        (0..of.variables()).map(|i| of.variable_name(i)).collect()
    }

    /// Names, lower and upper bounds of the constraints.
    pub(crate) fn limits(&self) -> Vec<(String, f64, f64)> {
        let limits = self.seen().constraints().into_iter().enumerate();
        limits.map(|(j, of)| (self.seen().constraint_name(j), of.least, of.most)).collect()
    }
}

/// The variables of the inputs, and their names.
#[pyfunction]
pub(crate) fn start(problem: GivenProblem<'_>) -> PyResult<(Vec<f64>, Vec<String>)> {
    let problem = problem.statement()?.unwatched().map_err(raised)?;
    Ok((problem.start(), problem.names()))
}
