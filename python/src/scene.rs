//! [`Scene`] and [`System`]: mechanisms, whose parts Python writes as JSON.

use hamiltonian_adjoint as ha;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::convert::{Given, attributes, control_names, coordinate_names, event_names, vector};
use crate::errors::{raised, raised_by_scene};
use crate::signals::in_background;

/// The first coordinates of joints in space.
const JOINTS: [&str; 5] = ["angle", "first angle", "offset", "x", "e0"];

/// A scene under construction: its parts as JSON, and what the library made of them.
#[pyclass(module = "hamiltonian_adjoint._hamiltonian_adjoint")]
#[derive(Default)]
pub(crate) struct Scene {
    scene: ha::Scene,
    parts: Vec<String>,
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Scene::default()
    }

    /// Adds a part; if it is wrong, the scene remains as it was.
    fn add(&mut self, part: String) -> PyResult<()> {
        self.extend(vec![part])
    }

    /// Adds parts; if one of them is wrong, the scene remains as it was.
    fn extend(&mut self, parts: Vec<String>) -> PyResult<()> {
        if let Err(error) = parts.iter().try_for_each(|part| self.scene.add_json(part)) {
            self.scene = ha::Scene::new();
            self.parts.iter().try_for_each(|part| self.scene.add_json(part)).map_err(raised_by_scene)?;
            return Err(raised_by_scene(error));
        }
        self.parts.extend(parts);
        Ok(())
    }

    #[getter]
    fn parts(&self) -> Vec<String> {
        self.parts.clone()
    }

    fn to_json(&self) -> PyResult<String> {
        self.scene.to_json().map_err(raised)
    }

    /// Fails if the file is not a complete scene.
    #[staticmethod]
    fn check_json(json: &str) -> PyResult<()> {
        ha::SceneFile::from_json(json).and_then(ha::SceneFile::complete).map(drop).map_err(raised)
    }

    /// The number of equations of a constraint or joint.
    fn equations(&self, name: &str) -> usize {
        self.scene.multipliers_named(name).map_or(0, |all| all.len())
    }

    /// The kinds of what has this name.
    fn kinds_of(&self, name: &str) -> Vec<&'static str> {
        let kinds = [
            ("coordinate", self.scene.coordinate_named(name).is_some()),
            ("control", self.scene.control_named(name).is_some()),
            ("design variable", self.scene.design_named(name).is_some()),
            ("body", self.scene.frame_named(name).is_some()),
            ("body in space", self.scene.body_in_space_named(name).is_some()),
            ("output", self.scene.output_named(name).is_some()),
            ("event", self.scene.event_named(name).is_some()),
            ("constraint", self.scene.multipliers_named(name).is_some()),
            ("joint", JOINTS.iter().any(|of| self.scene.coordinate_named(&format!("{name}.{of}")).is_some())),
        ];
        kinds.into_iter().filter(|(_, is_there)| *is_there).map(|(kind, _)| kind).collect()
    }

    /// The initial value of a coordinate.
    fn initial(&self, name: &str) -> Option<f64> {
        self.scene.coordinate_named(name).map(|q| self.scene.initial(q))
    }
}

/// A compiled mechanism.
#[pyclass(frozen, subclass, module = "hamiltonian_adjoint._hamiltonian_adjoint")]
pub(crate) struct System {
    pub(crate) system: ha::System,
    /// The scene, in which parts are found by name.
    pub(crate) scene: ha::Scene,
    /// The parts of its scene.
    #[pyo3(get)]
    parts: Vec<String>,
}

/// Names of numbered items.
fn names<'n>(all: impl Iterator<Item = &'n str>) -> Vec<&'n str> {
    all.collect()
}

#[pymethods]
impl System {
    /// Compiles a scene. Ctrl-C leaves the computation, whose thread ends later.
    #[new]
    fn new(py: Python<'_>, scene: &Scene) -> PyResult<Self> {
        let of = scene.scene.clone();
        let system = in_background(py, move || of.compile())?.map_err(raised)?;
        Ok(System { system, scene: scene.scene.clone(), parts: scene.parts.clone() })
    }

    /// The number of coordinates.
    #[getter]
    fn n(&self) -> usize {
        self.system.n()
    }

    /// The number of constraint equations.
    #[getter]
    fn m(&self) -> usize {
        self.system.m()
    }

    /// The number of controls.
    #[getter]
    fn k(&self) -> usize {
        self.system.k()
    }

    /// The names of the coordinates.
    #[getter]
    fn coordinates(&self) -> Vec<&str> {
        names(coordinate_names(&self.system))
    }

    /// The names of the constraint equations, as scene files have them: `rope`, or `hinge.1` for the second equation of a hinge.
    #[getter]
    fn equations(&self) -> Vec<String> {
        let name = |of: &str| match of.rsplit_once("` (equation ") {
            Some((constraint, j)) => format!("{}.{}", constraint.trim_start_matches('`'), j.trim_end_matches(')')),
            None => of.trim_matches('`').to_string(),
        };
        (0..self.system.m()).map(|j| name(self.system.equation_name(j))).collect()
    }

    /// The names of the controls.
    #[getter]
    fn controls(&self) -> Vec<&str> {
        names(control_names(&self.system))
    }

    /// The names of the design variables.
    #[getter]
    fn designs(&self) -> Vec<&str> {
        names((0..self.system.designs()).map(|p| self.system.design_name(p)))
    }

    /// The names of the outputs.
    #[getter]
    fn outputs(&self) -> Vec<&str> {
        names((0..self.system.outputs()).map(|k| self.system.output_name(k)))
    }

    /// The names of the events.
    #[getter]
    fn events(&self) -> Vec<&str> {
        names(event_names(&self.system))
    }

    /// The initial coordinates of the scene, m or rad.
    #[getter]
    fn initial<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.system.initial_coordinates().as_slice())
    }

    /// The values of the design variables of the scene.
    #[getter]
    fn design<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.system.design_values().as_slice())
    }

    /// Names of elements and costs without a program, with the reason.
    #[getter]
    fn without_programs(&self) -> Vec<(&str, &'static str)> {
        self.system.without_programs().collect()
    }

    /// The program of an element or a cost as text.
    fn program(&self, name: &str) -> Option<String> {
        self.system.program(name)
    }

    fn inputs_to_json(&self, inputs: Given<'_>) -> PyResult<String> {
        inputs.inputs(&self.system)?.to_json(&self.system).map_err(raised)
    }

    fn inputs_from_json<'py>(&self, py: Python<'py>, json: &str) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
        attributes(py, &self.system, &ha::Inputs::from_json(&self.system, json).map_err(raised)?)
    }
}

/// An entry of a part: its name, its content, and whether it may be missing.
type Entry = (&'static str, String, bool);

/// The kinds of parts with their entries.
#[pyfunction]
pub(crate) fn kinds() -> Vec<(&'static str, Vec<Entry>)> {
    let entry = |entry: ha::PartEntry| (entry.name, entry.what, entry.is_optional);
    ha::SceneFile::kinds().map(|kind| (kind.name, kind.entries.into_iter().map(entry).collect())).collect()
}

/// The paper's example with its cost, as a scene file.
#[pyfunction]
pub(crate) fn cart_pendulum(links: usize) -> PyResult<String> {
    ha::scenes::CartPendulum::with_links(links).scene().to_json().map_err(raised)
}
