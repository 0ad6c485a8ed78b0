//! Optimisation of motions.

use std::ops::ControlFlow;

use hamiltonian_adjoint::optimize::{
    Fit, Free, Interval, Iterate, MotionProblem, Options, Outcome, Quantity, Variables, augmented_lagrangian,
    interior_point, lbfgs, levenberg_marquardt,
};
use hamiltonian_adjoint::{Error, System as Compiled};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Given, attributes, control_names, coordinate_names, matrix, number, settings, vector};
use crate::errors::{raised, warnings, wrong_input};
use crate::scene::System;
use crate::signals::Signals;

/// A free quantity: its kind, its name, a number, bounds, scale, and whether the variable is its logarithm.
#[derive(FromPyObject)]
pub(crate) struct GivenFree(String, String, usize, (f64, f64), f64, bool);

impl GivenFree {
    fn free(&self, system: &Compiled) -> PyResult<Free> {
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

/// Options from keywords.
fn options(given: &Bound<'_, PyDict>) -> PyResult<Options> {
    let mut options = Options::default();
    for (name, value) in given.iter() {
        match name.extract::<String>()?.as_str() {
            "iterations" => options.iterations = value.extract()?,
            "target" => options.target = value.extract()?,
            "stationarity" => options.stationarity = value.extract()?,
            "violation" => options.violation = value.extract()?,
            "memory" => options.memory = value.extract()?,
            "first_step" => options.first_step = value.extract()?,
            other => return Err(wrong_input(&format!("there is no option `{other}`"))),
        }
    }
    Ok(options)
}

/// Minimises J of a motion.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn minimise<'py>(
    py: Python<'py>,
    system: &System,
    inputs: Given<'py>,
    free: Vec<GivenFree>,
    constraints: Vec<(String, f64, f64)>,
    method: &str,
    given_options: &Bound<'py, PyDict>,
    given_settings: &Bound<'py, PyDict>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let of = &system.system;
    let (inputs, options, signals) = (inputs.inputs(of)?, options(given_options)?, Signals::default());
    let free = free.iter().map(|free| free.free(of)).collect::<PyResult<Vec<_>>>()?;
    let variables = Variables::new(of, &inputs, free).map_err(raised)?;
    let mut problem = MotionProblem::new(of, settings(Some(given_settings))?, inputs, variables).map_err(raised)?;
    for (name, least, most) in constraints {
        let output = number("output", &name, (0..of.outputs()).map(|k| of.output_name(k)))?;
        problem.constrain(of.output(output), Interval::new(least, most));
    }
    let (mut watch_motion, mut examine) = (signals.watcher(), signals.watcher());
    problem.solver.watch(move |_| watch_motion());
    let mut watch = |at: &Iterate, x: &[f64]| {
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
    };
    let start = problem.start();
    let result: Result<(Outcome, Option<Fit>), Error> = py.detach(|| match method {
        "L-BFGS" => Ok((lbfgs(&mut problem, &start, &options, &mut watch)?, None)),
        "augmented Lagrangian" => Ok((augmented_lagrangian(&mut problem, &start, &options, &mut watch)?, None)),
        "Levenberg-Marquardt" => {
            let fit = levenberg_marquardt(&mut problem, &start, &options, &mut watch)?;
            Ok((fit.outcome.clone(), Some(fit)))
        }
        _ => Ok((interior_point(&mut problem, &start, &options, &mut watch)?, None)),
    });
    signals.take()?;
    let (outcome, fit) = result.map_err(raised)?;
    let names: Vec<&str> = (0..problem.free().len()).map(|i| problem.free().name(i)).collect();
    let all = described(py, &outcome, fit.as_ref(), &names)?;
    all.set_item("names", names)?;
    all.set_item("inputs", attributes(py, of, &problem.inputs_at(&outcome.x))?)?;
    Ok(all)
}

/// Value, violation, stationarity, step and evaluations.
fn iterate(at: &Iterate) -> (f64, f64, f64, f64, usize) {
    (at.value, at.violation, at.stationarity, at.step, at.evaluations)
}

fn described<'py>(py: Python<'py>, outcome: &Outcome, fit: Option<&Fit>, names: &[&str]) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("x", vector(py, &outcome.x))?;
    all.set_item("value", outcome.value)?;
    all.set_item("constraints", vector(py, &outcome.constraints))?;
    all.set_item("violation", outcome.violation)?;
    all.set_item("multipliers", vector(py, &outcome.multipliers))?;
    all.set_item("reason", outcome.reason.to_string())?;
    all.set_item("converged", outcome.reason.is_converged())?;
    all.set_item("message", fit.map_or_else(|| outcome.to_string(), Fit::to_string))?;
    all.set_item("iterations", outcome.iterations)?;
    all.set_item("evaluations", outcome.evaluations)?;
    all.set_item("gradients", outcome.gradients)?;
    all.set_item("products", outcome.products)?;
    all.set_item("history", outcome.history.iter().map(iterate).collect::<Vec<_>>())?;
    all.set_item("warnings", warnings(&outcome.warnings))?;
    all.set_item("first_failure", outcome.first_failure.as_ref().map(ToString::to_string))?;
    let columns = |of: nalgebra::DMatrix<f64>| matrix(py, &of, of.ncols());
    all.set_item("standard_errors", fit.and_then(Fit::standard_errors).map(|errors| vector(py, &errors)))?;
    all.set_item("covariance", fit.and_then(Fit::covariance).map(columns).transpose()?)?;
    all.set_item("chi_squared", fit.map(Fit::chi_squared))?;
    all.set_item("degrees_of_freedom", fit.map(Fit::degrees_of_freedom))?;
    all.set_item("grid_shifts", fit.and_then(Fit::grid_shifts).map(|shifts| vector(py, &shifts)))?;
    all.set_item("undetermined", fit.map(|fit| fit.undetermined().into_iter().map(|i| names[i]).collect::<Vec<_>>()))?;
    Ok(all)
}
