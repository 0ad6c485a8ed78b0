//! Arrays, inputs, gradients and settings between Python and the library.

use hamiltonian_adjoint::{Gradient, Grid, Held, Inputs, Scheme, Settings, Start, System};
use nalgebra::{DMatrix, DVector};
use numpy::npyffi::NPY_ORDER;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{raised, warnings, wrong_input};

pub(crate) fn vector<'py>(py: Python<'py>, x: &[f64]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_slice(py, x)
}

/// A matrix as an array, in column-major order.
pub(crate) fn matrix<'py>(py: Python<'py>, x: &DMatrix<f64>, columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = [x.nrows(), columns];
    vector(py, &x.as_slice()[..x.nrows() * columns]).reshape_with_order(shape, NPY_ORDER::NPY_FORTRANORDER)
}

/// The attributes of `Inputs` of Python.
#[derive(FromPyObject)]
pub(crate) struct Given<'py> {
    t0: f64,
    steps: PyReadonlyArray1<'py, f64>,
    stages: usize,
    start: String,
    q: PyReadonlyArray1<'py, f64>,
    v: PyReadonlyArray1<'py, f64>,
    held: (Vec<String>, Vec<String>),
    controls: PyReadonlyArray2<'py, f64>,
    design: PyReadonlyArray1<'py, f64>,
    events: Vec<(String, usize)>,
    controls_in_time: Vec<String>,
    open: Option<Vec<usize>>,
}

/// The number of a name among names.
pub(crate) fn number<'n>(what: &str, name: &str, mut all: impl Iterator<Item = &'n str>) -> PyResult<usize> {
    all.position(|known| known == name).ok_or_else(|| wrong_input(&format!("the system has no {what} `{name}`")))
}

pub(crate) fn coordinate_names(system: &System) -> impl Iterator<Item = &str> {
    (0..system.n()).map(|i| system.coordinate_name(i))
}

pub(crate) fn control_names(system: &System) -> impl Iterator<Item = &str> {
    (0..system.k()).map(|k| system.control_name(k))
}

pub(crate) fn event_names(system: &System) -> impl Iterator<Item = &str> {
    (0..system.events()).map(|event| system.event_name(event))
}

impl Given<'_> {
    /// The inputs, for outputs that compare nodes with readings.
    pub(crate) fn with_readings(&self, system: &System) -> PyResult<Inputs> {
        let inputs = self.inputs(system)?;
        inputs.check_reading_times(system).map_err(raised)?;
        Ok(inputs)
    }

    pub(crate) fn inputs(&self, system: &System) -> PyResult<Inputs> {
        let list = |x: &PyReadonlyArray1<'_, f64>| x.as_array().to_vec();
        let (q, v) = (DVector::from_vec(list(&self.q)), DVector::from_vec(list(&self.v)));
        let held = |names: &[String]| {
            let held = |name: &String| number("coordinate", name, coordinate_names(system)).map(|i| system.coordinate(i));
            names.iter().map(held).collect::<PyResult<Vec<_>>>()
        };
        let start = match self.start.as_str() {
            "velocity" => Start::Velocity { q, v },
            "momentum" => Start::Momentum { q, p_star: v },
            "assembled" => {
                Start::Assembled { q, v, held: Held { coordinates: held(&self.held.0)?, velocities: held(&self.held.1)? } }
            }
            other => {
                let problem = format!("`start` is '{other}'; it must be 'velocity', 'momentum' or 'assembled'");
                return Err(wrong_input(&problem));
            }
        };
        let u = self.controls.as_array();
        let event = |(name, node): &(String, usize)| {
            number("event", name, event_names(system)).map(|event| system.event(event).at(*node))
        };
        let in_time = |name: &String| number("control", name, control_names(system)).map(|k| system.control(k));
        let equation = |j: &usize| match *j < system.m() {
            true => Ok(system.multiplier(*j)),
            false => Err(wrong_input(&format!("`open`: the system has no constraint equation {j}"))),
        };
        let open = self.open.as_ref().map(|open| open.iter().map(equation).collect::<PyResult<Vec<_>>>());
        Ok(Inputs {
            grid: Grid { stages: self.stages, ..Grid::new(self.t0, list(&self.steps)) },
            start,
            controls: DMatrix::from_fn(u.nrows(), u.ncols(), |k, i| u[[k, i]]),
            design: DVector::from_vec(list(&self.design)),
            events: self.events.iter().map(event).collect::<PyResult<_>>()?,
            controls_in_time: self.controls_in_time.iter().map(in_time).collect::<PyResult<_>>()?,
            open: open.unwrap_or_else(|| Ok(system.open_equations()))?,
        })
    }
}

/// The attributes of `Inputs` of Python, from those of the library.
pub(crate) fn attributes<'py>(py: Python<'py>, system: &System, inputs: &Inputs) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let names = |held: &[hamiltonian_adjoint::Coordinate]| {
        held.iter().map(|q| system.coordinate_name(q.index()).to_string()).collect::<Vec<_>>()
    };
    let (kind, held) = match &inputs.start {
        Start::Velocity { .. } => ("velocity", (Vec::new(), Vec::new())),
        Start::Momentum { .. } => ("momentum", (Vec::new(), Vec::new())),
        Start::Assembled { held, .. } => ("assembled", (names(&held.coordinates), names(&held.velocities))),
    };
    all.set_item("t0", inputs.grid.start)?;
    all.set_item("steps", vector(py, &inputs.grid.steps))?;
    all.set_item("stages", inputs.grid.stages)?;
    all.set_item("start", kind)?;
    all.set_item("q", vector(py, inputs.start.q().as_slice()))?;
    all.set_item("v", vector(py, inputs.start.rate().as_slice()))?;
    all.set_item("held", held)?;
    all.set_item("controls", matrix(py, &inputs.controls, inputs.controls.ncols())?)?;
    all.set_item("design", vector(py, inputs.design.as_slice()))?;
    let events = inputs.events.iter().map(|of| (system.event_name(of.event.index()).to_string(), of.node));
    all.set_item("events", events.collect::<Vec<_>>())?;
    let in_time = inputs.controls_in_time.iter().map(|of| system.control_name(of.index()).to_string());
    all.set_item("controls_in_time", in_time.collect::<Vec<_>>())?;
    let open: Vec<usize> = inputs.open.iter().map(|of| of.index()).collect();
    all.set_item("open", (inputs.open != system.open_equations()).then_some(open))?;
    Ok(all)
}

/// J and its derivatives as the attributes of `Gradient` of Python.
pub(crate) fn derivatives<'py>(py: Python<'py>, of: &Gradient) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("value", of.value)?;
    all.set_item("controls", matrix(py, &of.controls, of.controls.ncols())?)?;
    all.set_item("design", vector(py, of.design.as_slice()))?;
    all.set_item("q", vector(py, of.start.q().as_slice()))?;
    all.set_item("v", vector(py, of.start.rate().as_slice()))?;
    all.set_item("steps", vector(py, &of.steps))?;
    all.set_item("frozen", of.frozen.as_ref().map(|frozen| derivatives(py, frozen)).transpose()?)?;
    all.set_item("warnings", warnings(&of.warnings))?;
    Ok(all)
}

/// Settings from keywords; those that are not given have their default values.
pub(crate) fn settings(given: Option<&Bound<'_, PyDict>>) -> PyResult<Settings> {
    let mut settings = Settings::default();
    for (name, value) in given.into_iter().flat_map(|given| given.iter()) {
        match name.extract::<String>()?.as_str() {
            "scheme" => settings.scheme = scheme(&value.extract::<String>()?)?,
            "tolerance" => settings.tolerance = value.extract()?,
            "max_iterations" => settings.max_iterations = value.extract()?,
            "position_tolerance" => settings.position_tolerance = value.extract()?,
            "velocity_tolerance" => settings.velocity_tolerance = value.extract()?,
            "max_halvings" => settings.max_halvings = value.extract()?,
            "drift_bound" => settings.drift_bound = value.extract()?,
            "rebase_every" => settings.rebase_every = value.extract()?,
            other => {
                let problem = format!(
                    "there is no setting `{other}`; the settings are scheme, tolerance, max_iterations, position_tolerance, \
                     velocity_tolerance, max_halvings, drift_bound, rebase_every"
                );
                return Err(pyo3::exceptions::PyTypeError::new_err(problem));
            }
        }
    }
    Ok(settings)
}

fn scheme(name: &str) -> PyResult<Scheme> {
    let found = Scheme::ALL.into_iter().find(|scheme| scheme.name.eq_ignore_ascii_case(name));
    let known = || Scheme::ALL.map(|scheme| format!("'{}'", scheme.name)).join(", ");
    found.ok_or_else(|| wrong_input(&format!("there is no scheme '{name}'; the schemes are {}", known())))
}
