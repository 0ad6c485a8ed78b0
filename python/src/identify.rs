//! Readings: tables of measured values, and grids with nodes at their times.

use hamiltonian_adjoint as ha;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::convert::vector;
use crate::errors::{raised, wrong_input};

/// A column: its name, the times of its values, and the values.
type Column<'py> = (String, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// The times of the rows of a table in CSV, and its columns without empty cells.
#[pyfunction]
pub(crate) fn table<'py>(py: Python<'py>, csv: &str) -> PyResult<(Bound<'py, PyArray1<f64>>, Vec<Column<'py>>)> {
    let ha::Table { names, times, columns } = ha::Table::from_csv(csv).map_err(raised)?;
    let column = |(name, column): (String, Vec<Option<f64>>)| {
        let known = times.iter().zip(column).filter_map(|(t, value)| value.map(|value| (*t, value)));
        let (times, values): (Vec<f64>, Vec<f64>) = known.unzip();
        (name, vector(py, &times), vector(py, &values))
    };
    let columns = names.into_iter().zip(columns).map(column).collect();
    Ok((vector(py, &times), columns))
}

/// The lengths of steps with nodes at these times.
#[pyfunction]
pub(crate) fn steps_through<'py>(py: Python<'py>, times: Vec<f64>, longest: f64) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let grid = ha::Grid::through(&times, longest).map_err(|error| wrong_input(&error.to_string()))?;
    Ok(vector(py, &grid.steps))
}

/// The nodes of a grid at which readings are made.
#[pyfunction]
pub(crate) fn nodes_of_readings(name: &str, times: Vec<f64>, steps: Vec<f64>, t0: f64) -> PyResult<Vec<usize>> {
    let values = vec![Some(0.0); times.len()];
    let table = ha::Table { names: vec![name.to_string()], times, columns: vec![values] };
    match table.readings(0, &ha::Grid::new(t0, steps)) {
        Ok(readings) => Ok(readings.into_iter().map(|(node, _)| node).collect()),
        Err(ha::Error::File { problem, .. }) => Err(wrong_input(&format!("readings `{name}`: {problem}"))),
        Err(error) => Err(raised(error)),
    }
}
