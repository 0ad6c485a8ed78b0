//! Values of formulas.

use hamiltonian_adjoint::TextFunction;
use hamiltonian_adjoint::check::Function;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::check::strings;
use crate::convert::vector;
use crate::errors::raised;

/// The values of a formula of `x[0]`, `x[1]` …: the parts that precede it, and the formula. `x` has one row for each argument and one column for each value.
#[pyfunction]
pub(crate) fn values<'py>(
    py: Python<'py>,
    text: (Vec<String>, Vec<String>),
    x: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let x = x.as_array();
    let function = TextFunction::read(&strings(&text.0), &strings(&text.1), x.nrows()).map_err(raised)?;
    let values: Vec<f64> = x.columns().into_iter().map(|x| function.value(&x.to_vec())[0]).collect();
    Ok(vector(py, &values))
}
