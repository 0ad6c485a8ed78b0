//! Optimisation of motions.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use hamiltonian_adjoint::optimize::{
    self, Fit, Iterate, MotionProblem, Options, Outcome, augmented_lagrangian, interior_point, lbfgs, levenberg_marquardt,
    stages,
};
use hamiltonian_adjoint::{Error, Inputs, System as Compiled};
use numpy::PyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Given, attributes, matrix, vector};
use crate::errors::{in_python, raised, warnings};
use crate::problem::{GivenProblem, Problem, Statement};
use crate::progress::Bar;
use crate::signals::{Signals, on_all_cores};

/// Options from keywords.
pub(crate) fn options(given: &Bound<'_, PyDict>) -> PyResult<Options> {
    let mut options = Options::default();
    for (name, value) in given.iter() {
        match name.extract::<String>()?.as_str() {
            "iterations" => options.iterations = value.extract()?,
            "target" => options.target = value.extract()?,
            "stationarity" => options.stationarity = value.extract()?,
            "violation" => options.violation = value.extract()?,
            "memory" => options.memory = value.extract()?,
            "first_step" => options.first_step = value.extract()?,
            other => return Err(PyTypeError::new_err(format!("there is no option `{other}`"))),
        }
    }
    Ok(options)
}

/// An outcome, and the fit that it belongs to.
type Solved = (Outcome, Option<Fit>);

/// Runs the method with a name.
fn run(
    method: &str,
    problem: &mut Problem,
    start: &[f64],
    options: &Options,
    watch: &mut optimize::Watcher,
) -> Result<Solved, Error> {
    if let ("stages", Problem::Shooting(of)) = (method, &mut *problem) {
        return Ok((stages(of, start, options, watch)?, None));
    }
    let problem = problem.any();
    match method {
        "L-BFGS" => Ok((lbfgs(problem, start, options, watch)?, None)),
        "augmented Lagrangian" => Ok((augmented_lagrangian(problem, start, options, watch)?, None)),
        "Levenberg-Marquardt" => {
            let fit = levenberg_marquardt(problem, start, options, watch)?;
            Ok((fit.outcome.clone(), Some(fit)))
        }
        _ => Ok((interior_point(problem, start, options, watch)?, None)),
    }
}

/// A callback of a method that examines signals and calls a function of Python, whose exception is kept.
pub(crate) fn watcher(
    signals: &Signals,
    callback: Option<Py<PyAny>>,
) -> impl FnMut(&Iterate, &[f64]) -> ControlFlow<()> + Send {
    let (signals, mut examine) = (signals.clone(), signals.watcher());
    move |at, x| {
        examine()?;
        let Some(callback) = &callback else { return ControlFlow::Continue(()) };
        let stops = Python::attach(|py| {
            callback.bind(py).call1((iterate(at), PyArray1::from_slice(py, x)))?.extract::<Option<bool>>()
        });
        match stops {
            Ok(Some(true)) => ControlFlow::Break(()),
            Ok(_) => ControlFlow::Continue(()),
            Err(error) => {
                signals.keep(error);
                ControlFlow::Break(())
            }
        }
    }
}

/// Minimises from a start, by default from the variables of the inputs.
#[pyfunction]
pub(crate) fn minimise<'py>(
    py: Python<'py>,
    problem: GivenProblem<'py>,
    method: &str,
    start: Option<Vec<f64>>,
    given_options: &Bound<'py, PyDict>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (statement, options, signals) = (problem.statement()?, options(given_options)?, Signals::default());
    let mut problem = statement.problem(|| signals.watcher()).map_err(raised)?;
    let (start, mut watch) = (start.unwrap_or_else(|| problem.start()), watcher(&signals, callback));
    let result = py.detach(|| run(method, &mut problem, &start, &options, &mut watch));
    signals.take()?;
    described(py, &statement, &problem, &result.map_err(raised)?)
}

/// Minimises from many starts on all cores.
#[pyfunction]
pub(crate) fn multi_start<'py>(
    py: Python<'py>,
    problem: GivenProblem<'py>,
    starts: Vec<Vec<f64>>,
    method: &str,
    given_options: &Bound<'py, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let (statement, options) = (problem.statement()?, options(given_options)?);
    let mut known = statement.unwatched().map_err(raised)?;
    starts.iter().try_for_each(|start| options.fit(known.any(), start)).map_err(raised)?;
    let worker = |stop: Arc<AtomicBool>| {
        let watcher = || {
            let stop = stop.clone();
            move || stopped(&stop)
        };
        (statement.problem(watcher), stop.clone())
    };
    let work = |(problem, stop): &mut (Result<Problem, Error>, Arc<AtomicBool>), start: &Vec<f64>| {
        let problem = problem.as_mut().map_err(|error| error.clone())?;
        run(method, problem, start, &options, &mut |_, _| stopped(stop))
    };
    let done = on_all_cores(py, &starts, worker, work, (&Bar::new(progress), "starts"))?;
    done.into_iter().map(|solved| described(py, &statement, &known, &solved.map_err(raised)?)).collect()
}

pub(crate) fn stopped(stop: &AtomicBool) -> ControlFlow<()> {
    if stop.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Solves a sequence of problems, whose inputs a function of Python changes.
#[pyfunction]
pub(crate) fn homotopy<'py>(
    py: Python<'py>,
    problem: GivenProblem<'py>,
    set: Py<PyAny>,
    given_options: &Bound<'py, PyDict>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (statement, options, signals) = (problem.statement()?, options(given_options)?, Signals::default());
    let [of] = &statement.motions[..] else { return Err(PyTypeError::new_err("a homotopy has one motion")) };
    let mut motion = of.problem(signals.watcher()).map_err(raised)?;
    let (start, mut watch) = (motion.start(), watcher(&signals, callback));
    let mut is_over = false;
    let mut set = |motion: &mut MotionProblem, s: f64| {
        // After an exception, the function is not called again.
        let interrupted = Error::Interrupted { done: 0, of: motion.solver.inputs().grid.nodes() };
        if is_over {
            return Err(interrupted);
        }
        match Python::attach(|py| changed(py, &of.system, motion, &set, s)) {
            Ok(inputs) => motion.change(|of| *of = inputs),
            Err(error) => {
                is_over = true;
                signals.keep(error);
                Err(interrupted)
            }
        }
    };
    let result = py.detach(|| optimize::homotopy(&mut motion, &start, &options, &mut set, &mut watch));
    signals.take()?;
    let outcome = result.map_err(raised)?;
    described(py, &statement, &Problem::Motion(Box::new(motion)), &(outcome, None))
}

/// The inputs that a function of Python makes of the current ones.
fn changed(py: Python<'_>, system: &Compiled, motion: &MotionProblem, set: &Py<PyAny>, s: f64) -> PyResult<Inputs> {
    let current = attributes(py, system, &motion.inputs_at(&motion.start()))?;
    set.bind(py).call1((current, s))?.extract::<Given<'_>>()?.inputs(system)
}

/// Value, violation, stationarity, step and evaluations.
fn iterate(at: &Iterate) -> (f64, f64, f64, f64, usize) {
    (at.value, at.violation, at.stationarity, at.step, at.evaluations)
}

pub(crate) fn described<'py>(
    py: Python<'py>,
    statement: &Statement,
    problem: &Problem,
    (outcome, fit): &Solved,
) -> PyResult<Bound<'py, PyDict>> {
    let (all, fit, names) = (PyDict::new(py), fit.as_ref(), problem.names());
    let inputs = statement.motions.iter().zip(problem.inputs_at(&outcome.x));
    let inputs = inputs.map(|(motion, inputs)| attributes(py, &motion.system, &inputs));
    all.set_item("inputs", inputs.collect::<PyResult<Vec<_>>>()?)?;
    all.set_item("x", vector(py, &outcome.x))?;
    all.set_item("value", outcome.value)?;
    all.set_item("constraints", vector(py, &outcome.constraints))?;
    all.set_item("limits", problem.limits())?;
    all.set_item("violation", outcome.violation)?;
    all.set_item("multipliers", vector(py, &outcome.multipliers))?;
    all.set_item("reason", outcome.reason.to_string())?;
    all.set_item("converged", outcome.reason.is_converged())?;
    all.set_item("message", in_python(&fit.map_or_else(|| outcome.to_string(), Fit::to_string)))?;
    all.set_item("iterations", outcome.iterations)?;
    all.set_item("evaluations", outcome.evaluations)?;
    all.set_item("gradients", outcome.gradients)?;
    all.set_item("products", outcome.products)?;
    all.set_item("history", outcome.history.iter().map(iterate).collect::<Vec<_>>())?;
    all.set_item("warnings", warnings(&outcome.warnings))?;
    all.set_item("first_failure", outcome.first_failure.as_ref().map(|error| in_python(&error.to_string())))?;
    let columns = |of: nalgebra::DMatrix<f64>| matrix(py, &of, of.ncols());
    all.set_item("standard_errors", fit.and_then(Fit::standard_errors).map(|errors| vector(py, &errors)))?;
    all.set_item("absolute_errors", fit.and_then(Fit::absolute_errors).map(|errors| vector(py, &errors)))?;
    all.set_item("jacobian", fit.map(|fit| columns(fit.jacobian.clone())).transpose()?)?;
    all.set_item("covariance", fit.and_then(Fit::covariance).map(columns).transpose()?)?;
    all.set_item("chi_squared", fit.map(Fit::chi_squared))?;
    all.set_item("degrees_of_freedom", fit.map(Fit::degrees_of_freedom))?;
    all.set_item("grid_shifts", fit.and_then(Fit::grid_shifts).map(|shifts| vector(py, &shifts)))?;
    all.set_item(
        "undetermined",
        fit.map(|fit| fit.undetermined().into_iter().map(|i| names[i].clone()).collect::<Vec<_>>()),
    )?;
    all.set_item("names", names)?;
    Ok(all)
}
