//! Robots from URDF files.

use hamiltonian_adjoint as ha;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use urdf::{Base, Damping, Options, Robot};

use crate::errors::{file_error, raised};

/// The parts of a robot as a scene file, and its joints and links by their names in the URDF file.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn robot<'py>(
    py: Python<'py>,
    urdf: &str,
    floating: bool,
    locked: Vec<(String, f64)>,
    prefix: String,
    damping: bool,
    ignore_mimic: bool,
    accept_impossible_inertias: bool,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let base = if floating { Base::Floating } else { Base::Fixed };
    let damping = if damping { Damping::File } else { Damping::None };
    let options = Options { base, locked, prefix, damping, ignore_mimic, accept_impossible_inertias };
    let mut scene = ha::Scene::new();
    let added = Robot::from_text(urdf).and_then(|robot| robot.add_to(&mut scene, &options)).map_err(in_python)?;
    let all = PyDict::new(py);
    let joints = PyDict::new(py);
    for joint in &added.joints {
        let limit = joint.limit.map(|of| (of.lower, of.upper, of.velocity, of.effort));
        joints.set_item(&joint.name, (joint.coordinates.len(), limit, joint.damping, joint.friction))?;
    }
    let followers = added.followers.into_iter().map(|of| (of.name, (of.of, of.factor, of.offset)));
    all.set_item("joints", joints)?;
    all.set_item("links", added.links.into_iter().map(|(name, _)| name).collect::<Vec<_>>())?;
    all.set_item("is_floating", added.base.is_some())?;
    all.set_item("locked", added.locked.into_iter().map(|of| (of.name, of.value)).collect::<Vec<_>>())?;
    all.set_item("followers", followers.collect::<Vec<_>>())?;
    Ok((scene.to_json().map_err(raised)?, all))
}

/// The error with the names that options have in Python.
fn in_python(error: urdf::Error) -> PyErr {
    let message =
        error.to_string().replace("set `Options::accept_impossible_inertias`", "pass `accept_impossible_inertias=True`");
    file_error(&message.replace("set `Options::ignore_mimic`", "pass `ignore_mimic=True`"))
}
