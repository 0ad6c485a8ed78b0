//! Mechanical quantities at a single state.

use hamiltonian_adjoint as ha;
use hamiltonian_adjoint::check::Function;
use hamiltonian_adjoint::{Error, TextFunction, planar, spatial};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::check::strings;
use crate::convert::{Given, control_names, coordinate_names, matrix, number, vector};
use crate::errors::{raised, wrong_input};
use crate::operating_point;
use crate::scene::System;
use crate::solver::Motion;

type Vector<'py> = Bound<'py, PyArray1<f64>>;

/// Numbers as formulas of the design variables `x[i]`: the parts that precede them, and the numbers.
type Numbers = (Vec<String>, Vec<String>);

/// The axes of a marker: `along`, `toward` and `turned`, if they are given.
type Axes = [Option<Numbers>; 3];

/// What determines the mechanics of a system.
type State = (Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>, f64, Vec<usize>);

/// The mechanics of a system at one state.
#[pyclass(frozen, module = "hamiltonian_adjoint._hamiltonian_adjoint")]
pub(crate) struct Mechanics {
    system: Py<System>,
    at: ha::Mechanics,
    design: Vec<f64>,
}

fn made(system: Py<System>, at: Result<ha::Mechanics, Error>, design: &[f64]) -> PyResult<Mechanics> {
    Ok(Mechanics { system, at: at.map_err(raised)?, design: design.to_vec() })
}

impl Mechanics {
    /// A state of the same system, after a change of this one.
    fn changed(&self, py: Python<'_>, at: Result<ha::Mechanics, Error>, design: &[f64]) -> PyResult<Self> {
        made(self.system.clone_ref(py), at, design)
    }

    /// The coordinates with these names.
    fn coordinates(&self, names: &[String]) -> PyResult<Vec<ha::Coordinate>> {
        let system = &self.system.get().system;
        let of = |name: &String| number("coordinate", name, coordinate_names(system)).map(|i| system.coordinate(i));
        names.iter().map(of).collect()
    }

    fn controls_named(&self, names: &[String]) -> PyResult<Vec<ha::Control>> {
        let system = &self.system.get().system;
        let of = |name: &String| number("control", name, control_names(system)).map(|k| system.control(k));
        names.iter().map(of).collect()
    }

    /// Numbers at the values of the design variables.
    fn numbers<const N: usize>(&self, (parts, results): &Numbers) -> PyResult<[f64; N]> {
        let function = TextFunction::read(&strings(parts), &strings(results), self.design.len()).map_err(raised)?;
        let numbers = function.value(&self.design).try_into();
        numbers.map_err(|_| wrong_input(&format!("{N} numbers are expected, not {}", results.len())))
    }
}

/// The body with a name; the ground has none.
fn body_of<T>(name: Option<&str>, ground: T, find: impl FnOnce(&str) -> Option<T>) -> PyResult<T> {
    let Some(name) = name else { return Ok(ground) };
    find(name).ok_or_else(|| wrong_input(&format!("the system has no body `{name}`")))
}

#[pymethods]
impl Mechanics {
    #[new]
    fn new(system: Py<System>, q: Vec<f64>, v: Vec<f64>) -> PyResult<Self> {
        let of = system.get().system.clone();
        made(system, ha::Mechanics::new(&of, &q, &v), of.design_values().as_slice())
    }

    #[staticmethod]
    fn at_start(py: Python<'_>, system: Py<System>, inputs: Given<'_>) -> PyResult<Self> {
        let of = system.get().system.clone();
        let inputs = inputs.inputs(&of)?;
        made(system, py.detach(|| ha::Mechanics::at_start(&of, &inputs)), inputs.design.as_slice())
    }

    #[staticmethod]
    fn at_node(py: Python<'_>, motion: &Motion, node: usize) -> PyResult<Self> {
        let (system, data) = (motion.system.clone_ref(py), &*motion.data);
        let at = ha::Mechanics::at_node(&system.get().system, &data.inputs, &data.trajectory, node);
        made(system, at, data.inputs.design.as_slice())
    }

    /// q, v, controls, the design, t, and the numbers of open equations.
    fn state(&self) -> State {
        let open = self.at.open().iter().map(ha::Multiplier::index).collect();
        (self.at.q().to_vec(), self.at.v().to_vec(), self.at.controls().to_vec(), self.design.clone(), self.at.t(), open)
    }

    #[staticmethod]
    fn of_state(system: Py<System>, state: State) -> PyResult<Self> {
        let (q, v, u, design, t, open) = state;
        let of = system.get().system.clone();
        let open: Vec<_> = open.into_iter().filter(|j| *j < of.m()).map(|j| of.multiplier(j)).collect();
        let at = ha::Mechanics::new(&of, &q, &v)
            .and_then(|at| at.with_controls(&u)?.with_design(&design)?.at_time(t)?.with_open(&open));
        made(system, at, &design)
    }

    fn with_controls(&self, py: Python<'_>, u: Vec<f64>) -> PyResult<Self> {
        self.changed(py, self.at.clone().with_controls(&u), &self.design)
    }

    fn with_design(&self, py: Python<'_>, design: Vec<f64>) -> PyResult<Self> {
        self.changed(py, self.at.clone().with_design(&design), &design)
    }

    fn at_time(&self, py: Python<'_>, t: f64) -> PyResult<Self> {
        self.changed(py, self.at.clone().at_time(t), &self.design)
    }

    fn vector<'py>(&self, py: Python<'py>, which: &str) -> Vector<'py> {
        match which {
            "q" => vector(py, self.at.q()),
            "v" => vector(py, self.at.v()),
            "controls" => vector(py, self.at.controls()),
            "phi" => vector(py, self.at.phi().as_slice()),
            "phi_dot" => vector(py, self.at.phi_dot().as_slice()),
            _ => vector(py, self.at.momenta().as_slice()),
        }
    }

    fn matrix<'py>(&self, py: Python<'py>, which: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let of = if which == "phi_q" { self.at.phi_q() } else { self.at.mass() };
        matrix(py, &of, of.ncols())
    }

    /// T and V, J.
    fn energies(&self) -> (f64, f64) {
        (self.at.kinetic_energy(), self.at.potential_energy())
    }

    fn degrees_of_freedom(&self) -> usize {
        self.at.degrees_of_freedom()
    }

    fn accelerations<'py>(&self, py: Python<'py>) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let (v_dot, lambda) = py.detach(|| self.at.accelerations()).map_err(raised)?;
        Ok((vector(py, v_dot.as_slice()), vector(py, lambda.as_slice())))
    }

    /// The linearised motion, as the attributes of `LinearModel` of Python.
    fn linear_model<'py>(&self, py: Python<'py>, chosen: Vec<String>) -> PyResult<Bound<'py, PyDict>> {
        let chosen = self.coordinates(&chosen)?;
        let model = py.detach(|| self.at.linear_model(&chosen)).map_err(raised)?;
        operating_point::linear_model(py, &model)
    }

    /// The state of an equilibrium, and the other attributes of `Equilibrium` of Python.
    fn equilibrium<'py>(
        &self,
        py: Python<'py>,
        held: Vec<String>,
        stable: bool,
    ) -> PyResult<(Mechanics, Bound<'py, PyDict>)> {
        let held = self.coordinates(&held)?;
        let find = if stable { ha::Mechanics::stable_equilibrium } else { ha::Mechanics::equilibrium };
        let found = py.detach(|| find(&self.at, &held)).map_err(raised)?;
        let attributes = operating_point::equilibrium(py, &found)?;
        Ok((self.changed(py, Ok(found.state), &self.design)?, attributes))
    }

    fn inverse_dynamics(
        &self,
        py: Python<'_>,
        accelerations: (Vec<String>, Vec<f64>),
        controls: Vec<String>,
    ) -> PyResult<Mechanics> {
        let (names, values) = accelerations;
        let given: Vec<_> = self.coordinates(&names)?.into_iter().zip(values).collect();
        let controls = self.controls_named(&controls)?;
        let at = py.detach(|| self.at.clone().inverse_dynamics(&given, &controls));
        self.changed(py, at, &self.design)
    }

    fn relative_degree(&self, py: Python<'_>, coordinate: &str, controls: Vec<String>) -> PyResult<Option<usize>> {
        let (coordinates, controls) = (self.coordinates(&[coordinate.to_string()])?, self.controls_named(&controls)?);
        py.detach(|| self.at.relative_degree(coordinates[0], &controls)).map_err(raised)
    }

    /// Position and velocity of a point in the plane.
    fn point<'py>(&self, py: Python<'py>, body: Option<&str>, at: Numbers) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let frame = body_of(body, planar::Body::GROUND, |name| self.system.get().scene.frame_named(name))?;
        let [x, y] = self.numbers(&at)?;
        let point = frame.at(x, y);
        Ok((vector(py, &self.at.position(point)), vector(py, &self.at.velocity(point))))
    }

    /// Position, axes, velocity, angular velocity, acceleration and angular acceleration of a marker in space.
    fn marker<'py>(
        &self,
        py: Python<'py>,
        body: Option<&str>,
        at: Option<Numbers>,
        axes: Axes,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let body = body_of(body, spatial::Body::GROUND, |name| self.system.get().scene.body_in_space_named(name))?;
        let place = at.map_or(Ok([0.0; 3]), |at| self.numbers(&at))?;
        let [along, toward, turned] = axes.map(|of| of.map(|of| self.numbers::<3>(&of)).transpose());
        let marker = match (along?, toward?, turned?) {
            (Some(z), Some(x), _) => body.at(place).along_and_toward(z, x),
            (Some(z), ..) => body.at(place).along(z),
            (.., Some(angles)) => body.at(place).turned(angles),
            _ => body.at(place),
        };
        let state = py.detach(|| self.at.marker(marker)).map_err(raised)?;
        let axes =
            PyArray2::from_vec2(py, &state.axes.map(|row| row.to_vec())).map_err(|error| wrong_input(&error.to_string()))?;
        let rates = [state.velocity, state.angular_velocity, state.acceleration, state.angular_acceleration];
        let all = [vector(py, &state.position).into_any(), axes.into_any()];
        Ok(all.into_iter().chain(rates.map(|of| vector(py, &of).into_any())).collect())
    }
}
