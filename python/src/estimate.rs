//! J and its gradient with estimates of their errors.

use hamiltonian_adjoint::Estimate;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::derivatives;
use crate::errors::in_python;

/// The attributes of `Estimate` of Python.
pub(crate) fn estimated<'py>(py: Python<'py>, found: &Estimate) -> PyResult<Bound<'py, PyDict>> {
    let bounds = found.derivatives.iter().map(|one| (one.of.as_str(), one.value, one.uncertainty));
    let all = PyDict::new(py);
    all.set_item("text", in_python(&found.to_string()))?;
    all.set_item("value", found.value)?;
    all.set_item("gradient", derivatives(py, &found.gradient)?)?;
    all.set_item("uncertainty", found.uncertainty)?;
    all.set_item("gradient_uncertainty", found.gradient_uncertainty)?;
    all.set_item("derivatives", bounds.collect::<Vec<_>>())?;
    all.set_item("corrected", found.corrected.as_ref().map(|of| derivatives(py, of)).transpose()?)?;
    all.set_item("residual", found.residual)?;
    all.set_item("largest", found.largest)?;
    all.set_item("withdrawn", found.withdrawn.as_ref().map(|why| in_python(&why.to_string())))?;
    Ok(all)
}
