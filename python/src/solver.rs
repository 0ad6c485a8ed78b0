//! Solvers, and motions as data.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use hamiltonian_adjoint as ha;
use hamiltonian_adjoint::Error;
use nalgebra::DMatrix;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::convert::{Given, attributes, derivatives, matrix, settings, vector};
use crate::errors::{busy, raised, warnings};
use crate::estimate::estimated;
use crate::progress::Bar;
use crate::scene::System;
use crate::signals::{Signals, on_all_cores};

/// A solver behind a lock, the signals that stop it, and what shows its progress.
struct Guarded<T> {
    solver: Mutex<T>,
    signals: Signals,
    bar: Bar,
}

impl<T: Send> Guarded<T> {
    fn lock(&self) -> PyResult<MutexGuard<'_, T>> {
        match self.solver.try_lock() {
            Ok(solver) => Ok(solver),
            // A solver begins every motion anew.
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(busy()),
        }
    }

    /// Computes without the lock of the interpreter.
    fn run<R: Send>(&self, py: Python<'_>, compute: impl FnOnce(&mut T) -> Result<R, Error> + Send) -> PyResult<R> {
        let mut solver = self.lock()?;
        let solver = &mut *solver;
        let result = py.detach(|| compute(solver));
        let closed = self.bar.close(py);
        self.signals.take()?;
        closed?;
        result.map_err(raised)
    }
}

/// A solver of one system for many inputs.
#[pyclass(frozen, module = "hamiltonian_adjoint._hamiltonian_adjoint")]
pub(crate) struct Solver {
    guarded: Guarded<ha::Solver>,
    /// The first reading whose time is not that of its node, for the last motion.
    wrong_time: Mutex<Option<Error>>,
}

impl Solver {
    fn begin(&self, system: &ha::System, inputs: &ha::Inputs) {
        *self.wrong_time.lock().unwrap_or_else(PoisonError::into_inner) = inputs.check_reading_times(system).err();
    }

    /// Fails if the last motion has readings at other times.
    fn check_times(&self) -> PyResult<()> {
        let wrong = self.wrong_time.lock().unwrap_or_else(PoisonError::into_inner).clone();
        wrong.map_or(Ok(()), |error| Err(raised(error)))
    }
}

#[pymethods]
impl Solver {
    #[new]
    #[pyo3(signature = (system, progress=None, **keywords))]
    fn new(system: &System, progress: Option<Py<PyAny>>, keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let (signals, bar) = (Signals::default(), Bar::new(progress));
        let mut solver = ha::Solver::new(&system.system, settings(keywords)?);
        solver.watch(bar.watcher(&signals));
        let guarded = Guarded { solver: Mutex::new(solver), signals, bar };
        Ok(Solver { guarded, wrong_time: Mutex::new(None) })
    }

    fn simulate(&self, py: Python<'_>, system: Py<System>, inputs: Given<'_>) -> PyResult<Motion> {
        let inputs = inputs.inputs(&system.get().system)?;
        self.guarded.run(py, |solver| solver.simulate(&inputs).map(drop))?;
        self.begin(&system.get().system, &inputs);
        self.motion(system)
    }

    /// The last motion, up to a failed step.
    fn motion(&self, system: Py<System>) -> PyResult<Motion> {
        let solver = self.guarded.lock()?;
        let data = Data { inputs: solver.inputs().clone(), trajectory: solver.trajectory().clone() };
        Ok(Motion { system, data: Arc::new(data) })
    }

    /// J and its derivatives for inputs.
    fn solve<'py>(&self, py: Python<'py>, system: &System, inputs: Given<'py>) -> PyResult<Bound<'py, PyDict>> {
        let inputs = inputs.inputs(&system.system)?;
        let gradient = self.guarded.run(py, |solver| {
            solver.simulate(&inputs)?;
            solver.gradient().cloned()
        })?;
        self.begin(&system.system, &inputs);
        derivatives(py, &gradient)
    }

    /// The attributes of `Estimate` of Python.
    fn estimate<'py>(&self, py: Python<'py>, system: &System, inputs: Given<'py>) -> PyResult<Bound<'py, PyDict>> {
        let inputs = inputs.inputs(&system.system)?;
        let found = self.guarded.run(py, |solver| solver.estimate(&inputs))?;
        estimated(py, &found)
    }

    /// J and its derivatives for the last motion.
    fn gradient<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.guarded.run(py, |solver| solver.gradient().cloned()).and_then(|of| derivatives(py, &of))
    }

    fn weighted_gradient<'py>(&self, py: Python<'py>, cost: f64, outputs: Vec<f64>) -> PyResult<Bound<'py, PyDict>> {
        if outputs.iter().any(|weight| *weight != 0.0) {
            self.check_times()?;
        }
        self.guarded.run(py, |solver| solver.weighted_gradient(cost, &outputs).cloned()).and_then(|of| derivatives(py, &of))
    }

    fn jacobian<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.check_times()?;
        self.guarded.run(py, |solver| solver.jacobian())?.iter().map(|of| derivatives(py, of)).collect()
    }

    fn hessian_product<'py>(&self, py: Python<'py>, system: &System, of: Given<'py>) -> PyResult<Bound<'py, PyDict>> {
        let direction = of.inputs(&system.system)?;
        self.guarded.run(py, |solver| solver.hessian_product(&direction).cloned()).and_then(|of| derivatives(py, &of))
    }

    fn cost(&self, py: Python<'_>) -> PyResult<f64> {
        self.guarded.run(py, |solver| solver.cost())
    }

    fn outputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.check_times()?;
        self.guarded.run(py, |solver| solver.outputs()).map(|outputs| vector(py, outputs.as_slice()))
    }

    /// Inputs on an adaptive grid, with an assembled start, or with events.
    #[pyo3(signature = (system, inputs, way, number))]
    fn prepared<'py>(
        &self,
        py: Python<'py>,
        system: &System,
        inputs: Given<'py>,
        way: &str,
        number: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let inputs = inputs.inputs(&system.system)?;
        let prepared = self.guarded.run(py, |solver| match way {
            "adapt" => solver.adapt(&inputs, number),
            "find phases" => solver.find_phases(&inputs, number as usize),
            _ => solver.assemble(&inputs),
        })?;
        attributes(py, &system.system, &prepared)
    }

    /// Reports of the last motion and of the last backward sweep.
    fn report(&self) -> PyResult<(String, String)> {
        let solver = self.guarded.lock()?;
        Ok((solver.report().to_string(), solver.adjoint_report().to_string()))
    }

    fn warnings(&self) -> PyResult<Vec<(String, String)>> {
        Ok(warnings(&self.guarded.lock()?.report().warnings))
    }
}

/// A solver of motions that do not fit into memory.
#[pyclass(frozen, module = "hamiltonian_adjoint._hamiltonian_adjoint")]
pub(crate) struct LongSolver(Guarded<ha::LongSolver>);

#[pymethods]
impl LongSolver {
    #[new]
    #[pyo3(signature = (system, bytes, progress=None, **keywords))]
    fn new(
        system: &System,
        bytes: usize,
        progress: Option<Py<PyAny>>,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let (signals, bar) = (Signals::default(), Bar::new(progress));
        let mut solver = ha::LongSolver::new(&system.system, settings(keywords)?, bytes);
        solver.watch(bar.watcher(&signals));
        Ok(LongSolver(Guarded { solver: Mutex::new(solver), signals, bar }))
    }

    fn solve<'py>(&self, py: Python<'py>, system: &System, inputs: Given<'py>) -> PyResult<Bound<'py, PyDict>> {
        let inputs = inputs.inputs(&system.system)?;
        self.0.run(py, |solver| solver.gradient(&inputs).cloned()).and_then(|of| derivatives(py, &of))
    }

    fn jacobian<'py>(&self, py: Python<'py>, system: &System, of: Given<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let inputs = of.with_readings(&system.system)?;
        self.0.run(py, |solver| solver.jacobian(&inputs))?.iter().map(|of| derivatives(py, of)).collect()
    }
}

/// J and its derivatives for each of many inputs, on all cores; for a motion that fails, its exception.
#[pyfunction]
#[pyo3(signature = (system, inputs, progress=None, **keywords))]
pub(crate) fn gradients<'py>(
    py: Python<'py>,
    system: &System,
    inputs: Vec<Given<'py>>,
    progress: Option<Py<PyAny>>,
    keywords: Option<&Bound<'py, PyDict>>,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let (system, settings) = (&system.system, settings(keywords)?);
    let inputs = inputs.iter().map(|inputs| inputs.inputs(system)).collect::<PyResult<Vec<_>>>()?;
    let worker = |stop: Arc<std::sync::atomic::AtomicBool>| {
        let mut solver = ha::Solver::new(system, settings);
        solver.watch(move |_| match stop.load(std::sync::atomic::Ordering::Relaxed) {
            true => std::ops::ControlFlow::Break(()),
            false => std::ops::ControlFlow::Continue(()),
        });
        solver
    };
    let work = |solver: &mut ha::Solver, inputs: &ha::Inputs| {
        solver.simulate(inputs)?;
        solver.gradient().cloned()
    };
    let done = on_all_cores(py, &inputs, worker, work, (&Bar::new(progress), "motions"))?;
    let each = |of: Result<ha::Gradient, Error>| match of {
        Ok(of) => derivatives(py, &of).map(Bound::into_any),
        Err(error) => Ok(raised(error).into_value(py).into_bound(py).into_any()),
    };
    done.into_iter().map(each).collect()
}

/// A matrix with one column for each computed node.
type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// A motion with its inputs.
#[pyclass(frozen, module = "hamiltonian_adjoint._hamiltonian_adjoint")]
pub(crate) struct Motion {
    pub(crate) system: Py<System>,
    pub(crate) data: Arc<Data>,
}

pub(crate) struct Data {
    pub(crate) inputs: ha::Inputs,
    pub(crate) trajectory: ha::Trajectory,
}

impl Motion {
    fn system(&self) -> &ha::System {
        &self.system.get().system
    }
}

#[pymethods]
impl Motion {
    /// The number of computed nodes.
    #[getter]
    fn computed(&self) -> usize {
        self.data.trajectory.computed
    }

    /// The numbers of the nodes that halved steps inserted.
    #[getter]
    fn inserted(&self) -> Vec<usize> {
        self.data.trajectory.inserted.clone()
    }

    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.data.trajectory.times[..self.computed()])
    }

    /// A matrix with one column for each computed node.
    fn matrix<'py>(&self, py: Python<'py>, which: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Data { inputs, trajectory } = &*self.data;
        let of = match which {
            "q" => &trajectory.q,
            "v" => &trajectory.v,
            "p" => &trajectory.p_star,
            "p_dot" => &trajectory.p_star_dot,
            "sigma" => &trajectory.sigma,
            _ => &inputs.controls,
        };
        matrix(py, of, self.computed())
    }

    /// Φ or dΦ/dt at all nodes.
    fn constraints<'py>(&self, py: Python<'py>, rate: bool) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Data { inputs, trajectory } = &*self.data;
        let of = if rate { ha::Trajectory::phi_dot } else { ha::Trajectory::phi };
        let all = of(trajectory, self.system(), inputs).map_err(raised)?;
        matrix(py, &all, self.computed())
    }

    /// Accelerations and reactions at all nodes.
    fn accelerations<'py>(&self, py: Python<'py>) -> PyResult<(Rows<'py>, Rows<'py>)> {
        let (Data { inputs, trajectory }, system, nodes) = (&*self.data, self.system(), self.computed());
        let (mut v_dot, mut lambda) = (DMatrix::zeros(system.n(), nodes), DMatrix::zeros(system.m(), nodes));
        py.detach(|| {
            (0..nodes).try_for_each(|node| {
                let (of_node, reactions) = ha::Mechanics::at_node(system, inputs, trajectory, node)?.accelerations()?;
                v_dot.set_column(node, &of_node);
                lambda.set_column(node, &reactions);
                Ok(())
            })
        })
        .map_err(raised)?;
        Ok((matrix(py, &v_dot, nodes)?, matrix(py, &lambda, nodes)?))
    }

    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        attributes(py, self.system(), &self.data.inputs)
    }

    fn to_csv(&self) -> PyResult<String> {
        self.data.trajectory.to_csv(self.system(), &self.data.inputs).map_err(raised)
    }

    /// The first line of the CSV.
    fn csv_header(&self) -> PyResult<String> {
        let mut empty = self.data.trajectory.clone();
        empty.computed = 0;
        empty.to_csv(self.system(), &self.data.inputs).map_err(raised)
    }

    /// The motion as JSON, and its inputs.
    fn to_json(&self) -> PyResult<(String, String)> {
        let Data { inputs, trajectory } = &*self.data;
        let motion = trajectory.to_json(self.system()).map_err(raised)?;
        Ok((motion, inputs.to_json(self.system()).map_err(raised)?))
    }

    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, system: Py<System>, motion: &str, inputs: &str) -> PyResult<Self> {
        let of = &system.get().system;
        let trajectory = ha::Trajectory::from_json(of, motion).map_err(raised)?;
        let data = Data { inputs: ha::Inputs::from_json(of, inputs).map_err(raised)?, trajectory };
        Ok(Motion { system, data: Arc::new(data) })
    }

    /// A page that plays the motion, or its picture at a time.
    #[pyo3(signature = (title, time=None))]
    fn picture(&self, py: Python<'_>, title: &str, time: Option<f64>) -> PyResult<String> {
        let Data { inputs, trajectory } = &*self.data;
        let system = self.system();
        py.detach(|| {
            let animation = ha::Animation::new(system, inputs, trajectory)?.title(title);
            Ok(time.map_or_else(|| animation.html(), |time| animation.svg(time)))
        })
        .map_err(raised)
    }
}
