//! Checks of gradients and of Jacobians.

use std::cell::RefCell;
use std::time::Duration;

use hamiltonian_adjoint::TextFunction;
use hamiltonian_adjoint::check::{self, Verdict};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Given, number, settings};
use crate::errors::{in_python, raised};
use crate::scene::System;

/// The stack of a thread that computes in the background, bytes: not less than that of the main thread.
const STACK: usize = 16 << 20;

/// True if the check passed, the verdict, and the report.
type Checked = (bool, String, String);

fn checked(passed: bool, verdict: Verdict, report: String) -> Checked {
    (passed, format!("{verdict:?}"), in_python(&report))
}

/// Checks the gradient of J or of an output in four ways. Ctrl-C leaves the check, whose thread ends later.
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
    let (of, settings) = (system.system.clone(), settings(keywords)?);
    let inputs = if output.is_some() { inputs.with_readings(&of)? } else { inputs.inputs(&of)? };
    let names = (0..of.outputs()).map(|k| of.output_name(k));
    let output = output.map(|name| number("output", name, names)).transpose()?.map(|k| of.output(k));
    let run = move || {
        let mut check = check::gradient(&of, &inputs, settings).tolerance(tolerance).directions(directions, seed);
        if let Some(output) = output {
            check = check.output(output);
        }
        if complete {
            check = check.complete();
        }
        check.run().map(|report| checked(report.passed(), report.verdict(), report.to_string()))
    };
    in_background(py, run)?.map_err(raised)
}

/// Computes in a thread of its own, without the lock of the interpreter. Ctrl-C leaves the computation, whose thread ends later.
pub(crate) fn in_background<T: Send + 'static>(py: Python<'_>, compute: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(compute)?;
    let mut pause = Duration::from_micros(20);
    while !thread.is_finished() {
        py.detach(|| std::thread::sleep(pause));
        py.check_signals()?;
        pause = (2 * pause).min(Duration::from_millis(5));
    }
    Ok(thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
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
    let hand = |x: &[f64]| {
        let call = || {
            let result = jacobian.call1((PyArray1::from_slice(jacobian.py(), x),))?;
            let array: PyReadonlyArray2<'_, f64> = result.extract()?;
            let array = array.as_array();
            Ok(DMatrix::from_fn(array.nrows(), array.ncols(), |i, j| array[[i, j]]))
        };
        call().unwrap_or_else(|error: PyErr| {
            problem.borrow_mut().get_or_insert(error);
            DMatrix::from_element(names.1.len(), names.0.len(), f64::NAN)
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
