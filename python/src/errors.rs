//! Errors and warnings of the library as exceptions of Python, defined in `_errors.py`.

use hamiltonian_adjoint::{Error, Warning};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyModule;

static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();

/// The result of a function or a class of `_errors.py` for a message.
fn called<'py>(py: Python<'py>, name: &str, message: &str) -> PyResult<Bound<'py, PyAny>> {
    let module = MODULE.get_or_try_init(py, || py.import("hamiltonian_adjoint._errors").map(Bound::unbind))?;
    module.bind(py).getattr(name)?.call1((message,))
}

/// The exception of a class with a message.
fn exception(class: &str, message: &str) -> PyErr {
    Python::attach(|py| called(py, class, &in_python(message)).map_or_else(|error| error, PyErr::from_value))
}

/// A message with the names that items of the library have in Python.
pub(crate) fn in_python(message: &str) -> String {
    Python::attach(|py| match called(py, "in_python", message).and_then(|text| text.extract()) {
        Ok(text) => text,
        Err(_) => message.to_string(),
    })
}

/// The class of an error.
fn class(error: &Error) -> &'static str {
    use Error::*;
    match error {
        DuplicateName { .. }
        | Foreign { .. }
        | Particle { .. }
        | ParameterFormula { .. }
        | RepeatedCoordinate { .. }
        | NoBody { .. }
        | Inertia { .. }
        | NoJoint { .. }
        | SecondJoint { .. }
        | CarriesGround { .. }
        | NothingToCut { .. }
        | NotCarried { .. }
        | MissingInertia { .. }
        | EmptyScene
        | EventArguments { .. } => "SceneError",
        File { .. } => "FileError",
        Parameter { .. }
        | StartKind { .. }
        | Size { .. }
        | NotFinite { .. }
        | TimeStep { .. }
        | NoSuchInput { .. }
        | NoSuchEvent { .. }
        | Held { .. }
        | NotIndependent { .. }
        | ReadingTime { .. }
        | EventsInPart
        | Memory { .. }
        | OutOfMemory { .. } => "InputError",
        NotInSegments { .. } | NotAVariable { .. } | NotFree { .. } | NoMinimum { .. } => "OptimiseError",
        _ => "MotionError",
    }
}

/// An error of the library.
pub(crate) fn raised(error: Error) -> PyErr {
    exception(class(&error), &error.to_string())
}

/// An error of a scene under construction.
pub(crate) fn raised_by_scene(error: Error) -> PyErr {
    match error {
        Error::File { .. } => exception("SceneError", &error.to_string()),
        error => raised(error),
    }
}

/// A wrong input that the library does not see.
pub(crate) fn wrong_input(message: &str) -> PyErr {
    exception("InputError", message)
}

/// A wrong file that the library does not read.
pub(crate) fn file_error(message: &str) -> PyErr {
    exception("FileError", message)
}

/// An error of the interface.
pub(crate) fn busy() -> PyErr {
    exception(
        "Error",
        "this solver is computing in another thread; use one solver in each thread, or `gradients` for many motions",
    )
}

/// The kinds and messages of warnings.
pub(crate) fn warnings<'w>(all: impl IntoIterator<Item = &'w Warning>) -> Vec<(String, String)> {
    let kind = |warning: &Warning| format!("{warning:?}").chars().take_while(|c| c.is_ascii_alphanumeric()).collect();
    all.into_iter().map(|warning| (kind(warning), in_python(&warning.to_string()))).collect()
}
