//! The values of free quantities as variables.

use hamiltonian_adjoint::{Gradient, Start, optimize};
use nalgebra::{DMatrix, DVector};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Given, attributes, vector};
use crate::errors::raised;
use crate::problem::GivenFree;
use crate::scene::System;

/// The attributes of `Gradient` of Python.
#[derive(FromPyObject)]
pub(crate) struct GivenGradient<'py> {
    value: f64,
    q: PyReadonlyArray1<'py, f64>,
    v: PyReadonlyArray1<'py, f64>,
    steps: PyReadonlyArray1<'py, f64>,
    controls: PyReadonlyArray2<'py, f64>,
    design: PyReadonlyArray1<'py, f64>,
}

impl GivenGradient<'_> {
    fn gradient(&self) -> Gradient {
        let list = |x: &PyReadonlyArray1<'_, f64>| x.as_array().to_vec();
        let u = self.controls.as_array();
        Gradient {
            value: self.value,
            controls: DMatrix::from_fn(u.nrows(), u.ncols(), |k, i| u[[k, i]]),
            design: DVector::from_vec(list(&self.design)),
            start: Start::Velocity { q: DVector::from_vec(list(&self.q)), v: DVector::from_vec(list(&self.v)) },
            steps: list(&self.steps),
            frozen: None,
            warnings: Vec::new(),
        }
    }
}

/// Variables of a system and a grid.
#[pyclass(frozen, module = "hamiltonian_adjoint._hamiltonian_adjoint")]
pub(crate) struct Variables {
    system: Py<System>,
    variables: optimize::Variables,
}

#[pymethods]
impl Variables {
    #[new]
    fn new(system: Py<System>, inputs: Given<'_>, free: Vec<GivenFree>) -> PyResult<Self> {
        let of = &system.get().system;
        let inputs = inputs.inputs(of)?;
        let quantities = free.iter().map(|free| free.free(of)).collect::<PyResult<Vec<_>>>()?;
        let variables = optimize::Variables::new(of, &inputs, quantities).map_err(raised)?;
        Ok(Variables { variables, system })
    }

    #[getter]
    fn names(&self) -> Vec<String> {
        (0..self.variables.len()).map(|i| self.variables.name(i).to_string()).collect()
    }

    /// The variables of inputs.
    fn of<'py>(&self, py: Python<'py>, inputs: Given<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(vector(py, &self.variables.of(&inputs.inputs(&self.system.get().system)?)))
    }

    /// These inputs with the values of the variables.
    fn apply<'py>(&self, py: Python<'py>, x: Vec<f64>, inputs: Given<'py>) -> PyResult<Bound<'py, PyDict>> {
        let system = &self.system.get().system;
        let mut inputs = inputs.inputs(system)?;
        self.variables.apply(&x, &mut inputs).map_err(raised)?;
        attributes(py, system, &inputs)
    }

    /// The change of inputs along a direction of the variables; `change` contains zeros.
    fn push_forward<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        direction: Vec<f64>,
        change: Given<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let system = &self.system.get().system;
        let mut change = change.inputs(system)?;
        self.variables.push_forward(&x, &direction, &mut change);
        attributes(py, system, &change)
    }

    /// The derivatives by the variables.
    fn pull_back<'py>(&self, py: Python<'py>, x: Vec<f64>, of: GivenGradient<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.pulled_back(&x, &of))
    }

    /// The product of a Hessian with a direction by the variables, from that by the inputs and the gradient by the variables.
    fn product<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
        gradient: Vec<f64>,
        direction: Vec<f64>,
        of: GivenGradient<'py>,
    ) -> Bound<'py, PyArray1<f64>> {
        let mut product = self.pulled_back(&x, &of);
        self.variables.add_curvature(&direction, &gradient, &mut product);
        vector(py, &product)
    }
}

impl Variables {
    fn pulled_back(&self, x: &[f64], of: &GivenGradient<'_>) -> Vec<f64> {
        let mut gradient = vec![0.0; self.variables.len()];
        self.variables.pull_back(x, &of.gradient(), &mut gradient);
        gradient
    }
}
