//! Linear models and equilibria as attributes of Python objects.

use hamiltonian_adjoint as ha;
use nalgebra::{Complex, DMatrix};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{matrix, vector};

/// The attributes of `LinearModel`.
pub(crate) fn linear_model<'py>(py: Python<'py>, of: &ha::LinearModel) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("names", &of.names)?;
    let matrices = [("a", &of.a), ("b", &of.b), ("by_design", &of.by_design), ("q_z", &of.q_z), ("v_z", &of.v_z)];
    set_matrices(&all, &matrices)?;
    all.set_item("eigenvalues", complex(py, &of.eigenvalues))?;
    Ok(all)
}

/// The attributes of `Equilibrium`, without its state.
pub(crate) fn equilibrium<'py>(py: Python<'py>, of: &ha::Equilibrium) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("lam", vector(py, of.lambda.as_slice()))?;
    all.set_item("holding", vector(py, of.holding.as_slice()))?;
    all.set_item("eigenvalues", complex(py, &of.eigenvalues))?;
    all.set_item("is_stable", of.is_stable())?;
    all.set_item("by_controls", sensitivity(py, &of.by_controls)?)?;
    all.set_item("by_design", sensitivity(py, &of.by_design)?)?;
    Ok(all)
}

/// The attributes of `Sensitivity`.
fn sensitivity<'py>(py: Python<'py>, of: &ha::Sensitivity) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    set_matrices(&all, &[("q", &of.q), ("lam", &of.lambda), ("holding", &of.holding)])?;
    Ok(all)
}

fn set_matrices(all: &Bound<'_, PyDict>, matrices: &[(&str, &DMatrix<f64>)]) -> PyResult<()> {
    matrices.iter().try_for_each(|(name, of)| all.set_item(name, matrix(all.py(), of, of.ncols())?))
}

fn complex<'py>(py: Python<'py>, x: &[Complex<f64>]) -> Bound<'py, PyArray1<Complex<f64>>> {
    PyArray1::from_slice(py, x)
}
