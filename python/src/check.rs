//! Checks of gradients and of Jacobians.

use std::cell::RefCell;

use hamiltonian_adjoint::TextFunction;
use hamiltonian_adjoint::check::{self, Verdict};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Given, number, settings};
use crate::errors::{in_python, raised};
use crate::progress::Bar;
use crate::scene::System;
use crate::signals::Signals;

/// True if the check passed, the verdict, and the report.
type Checked = (bool, String, String);

fn checked(passed: bool, verdict: Verdict, report: String) -> Checked {
    (passed, format!("{verdict:?}"), in_python(&report))
}

/// Checks the gradient of J or of an output in four ways.
#[pyfunction]
#[pyo3(signature = (system, inputs, output, complete, tolerance, directions, seed, **keywords))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn check_gradient(
    py: Python<'_>,
    system: &System,
    inputs: Given<'_>,
    output: Option<&str>,
    complete: bool,
    tolerance: f64,
    directions: usize,
    seed: u64,
    keywords: Option<&Bound<'_, PyDict>>,
) -> PyResult<Checked> {
    let (of, settings) = (&system.system, settings(keywords)?);
    let inputs = if output.is_some() { inputs.with_readings(of)? } else { inputs.inputs(of)? };
    let names = (0..of.outputs()).map(|k| of.output_name(k));
    let output = output.map(|name| number("output", name, names)).transpose()?.map(|k| of.output(k));
    let signals = Signals::default();
    let mut check = check::gradient(of, &inputs, settings).tolerance(tolerance).directions(directions, seed);
    if let Some(output) = output {
        check = check.output(output);
    }
    if complete {
        check = check.complete();
    }
    let check = check.watch(Bar::new(None).watcher(&signals));
    let report = py.detach(|| check.run());
    signals.take()?;
    let report = report.map_err(raised)?;
    Ok(checked(report.passed(), report.verdict(), report.to_string()))
}

pub(crate) fn strings(list: &[String]) -> Vec<&str> {
    list.iter().map(String::as_str).collect()
}

/// Checks a Jacobian that Python computes, of a function that is given as text.
#[pyfunction]
pub(crate) fn check_function(
    text: (Vec<String>, Vec<String>),
    names: (Vec<String>, Vec<String>),
    jacobian: Bound<'_, PyAny>,
    points: Vec<Vec<f64>>,
    random: (usize, u64),
    magnitudes: Vec<f64>,
) -> PyResult<Checked> {
    let function = TextFunction::read(&strings(&text.0), &strings(&text.1), names.0.len()).map_err(raised)?;
    let problem = RefCell::new(None);
    let not_a_number = || DMatrix::from_element(names.1.len(), names.0.len(), f64::NAN);
    let hand = |x: &[f64]| {
        // After an exception, such as that of Ctrl-C, nothing is compared any more.
        if problem.borrow().is_some() {
            return not_a_number();
        }
        let call = || {
            let result = jacobian.call1((PyArray1::from_slice(jacobian.py(), x),))?;
            let array: PyReadonlyArray2<'_, f64> = result.extract()?;
            let array = array.as_array();
            Ok(DMatrix::from_fn(array.nrows(), array.ncols(), |i, j| array[[i, j]]))
        };
        call().unwrap_or_else(|error: PyErr| {
            *problem.borrow_mut() = Some(error);
            not_a_number()
        })
    };
    let check = check::function(&function, strings(&names.0), strings(&names.1)).magnitudes(&magnitudes).jacobian(hand);
    let check = points.iter().fold(check, |check, point| check.at(point)).random_points(random.0, random.1);
    let report = check.run();
    match problem.into_inner() {
        Some(error) => Err(error),
        None => Ok(checked(report.passed(), report.verdict(), report.to_string())),
    }
}
