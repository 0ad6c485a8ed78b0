//! The compiled part of the Python package `hamiltonian_adjoint`.
//!
//! Python writes the parts of a scene as JSON and formulas as text (`_entries.py`, `_formula.py`), so that whatever is built there can be stored in a scene
//! file; this module passes them to the library, runs it without the lock of the interpreter, and returns arrays.

mod check;
mod convert;
mod errors;
mod estimate;
mod formula;
mod identify;
mod mechanics;
mod operating_point;
mod optimise;
mod problem;
mod progress;
mod robot;
mod scene;
mod signals;
mod solve;
mod solver;
mod variables;

use pyo3::prelude::*;

#[pymodule]
fn _hamiltonian_adjoint(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<scene::Scene>()?;
    module.add_class::<scene::System>()?;
    module.add_class::<solver::Solver>()?;
    module.add_class::<solver::LongSolver>()?;
    module.add_class::<solver::Motion>()?;
    module.add_class::<mechanics::Mechanics>()?;
    module.add_class::<variables::Variables>()?;
    module.add_function(wrap_pyfunction!(scene::kinds, module)?)?;
    module.add_function(wrap_pyfunction!(scene::cart_pendulum, module)?)?;
    module.add_function(wrap_pyfunction!(solver::gradients, module)?)?;
    module.add_function(wrap_pyfunction!(check::check_gradient, module)?)?;
    module.add_function(wrap_pyfunction!(check::check_function, module)?)?;
    module.add_function(wrap_pyfunction!(formula::values, module)?)?;
    module.add_function(wrap_pyfunction!(identify::table, module)?)?;
    module.add_function(wrap_pyfunction!(solve::identify, module)?)?;
    module.add_function(wrap_pyfunction!(identify::steps_through, module)?)?;
    module.add_function(wrap_pyfunction!(identify::nodes_of_readings, module)?)?;
    module.add_function(wrap_pyfunction!(robot::robot, module)?)?;
    module.add_function(wrap_pyfunction!(problem::start, module)?)?;
    module.add_function(wrap_pyfunction!(optimise::minimise, module)?)?;
    module.add_function(wrap_pyfunction!(optimise::multi_start, module)?)?;
    module.add_function(wrap_pyfunction!(optimise::homotopy, module)?)?;
    module.add_function(wrap_pyfunction!(solve::sensitivities, module)?)?;
    module.add_function(wrap_pyfunction!(solve::solve, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    Ok(())
}
