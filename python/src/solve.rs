//! Optimisation from a guess of the states.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use hamiltonian_adjoint::optimize::{self, Attempt, Guess, Iterate, MotionProblem, Parameter, Search, Watcher};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPoolBuilder;

use crate::errors::{raised, wrong_input};
use crate::optimise::{described, options, stopped, watcher};
use crate::problem::{GivenProblem, Motion, Problem, output};
use crate::signals::{STACK, Signals};

/// Signals are examined at least this often.
const EVERY: Duration = Duration::from_millis(50);

/// The name of a guess, q and v at all nodes, or the variables and the multipliers of an optimum.
#[derive(FromPyObject)]
pub(crate) enum GivenGuess<'py> {
    Name(String),
    States(PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>),
    Optimum(Vec<f64>, Vec<f64>),
}

impl GivenGuess<'_> {
    fn guess(&self) -> PyResult<Guess> {
        let matrix = |x: &PyReadonlyArray2<'_, f64>| {
            let x = x.as_array();
            DMatrix::from_fn(x.nrows(), x.ncols(), |i, node| x[[i, node]])
        };
        match self {
            GivenGuess::States(q, v) => Ok(Guess::States { q: matrix(q), v: matrix(v) }),
            GivenGuess::Optimum(x, multipliers) => Ok(Guess::Optimum { x: x.clone(), multipliers: multipliers.clone() }),
            GivenGuess::Name(name) => match name.as_str() {
                "straight" => Ok(Guess::Straight),
                "inputs" => Ok(Guess::Inputs),
                other => Err(wrong_input(&format!("there is no guess '{other}'"))),
            },
        }
    }
}

/// Minimises from a guess of the states, and from random starts on all cores.
#[pyfunction]
pub(crate) fn solve<'py>(
    py: Python<'py>,
    problem: GivenProblem<'py>,
    guess: GivenGuess<'py>,
    asked: (usize, Option<f64>),
    given_options: &Bound<'py, PyDict>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (starts, accuracy) = asked;
    let (statement, options, search) =
        (problem.statement()?, options(given_options)?, Search { accuracy, ..guess.guess()?.starts(starts) });
    let [of] = &statement.motions[..] else { return Err(wrong_input("`solve` has one motion")) };
    let (mut motion, stop) = stoppable(of)?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(starts);
    let found = in_pool(py, threads, (&stop, callback), |watch| optimize::solve(&mut motion, search, &options, watch))?;
    let solved = found.map_err(raised)?;
    let (table, scheme) = (solved.to_string(), motion.solver.trajectory().scheme.name);
    let all = described(py, &statement, &Problem::Motion(Box::new(motion)), &(solved.outcome, None))?;
    all.set_item("attempts", solved.attempts.iter().map(attempt).collect::<Vec<_>>())?;
    all.set_item("_table", table)?;
    all.set_item("scheme", scheme)?;
    Ok(all)
}

/// The name of an output whose target changes, or the number of a variable whose bounds change.
#[derive(FromPyObject)]
pub(crate) enum GivenParameter {
    Target(String),
    Bound(usize),
}

/// The derivatives of the variables and of J at a minimum that is solved again, from its variables and multipliers.
#[pyfunction]
pub(crate) fn sensitivities<'py>(
    py: Python<'py>,
    problem: GivenProblem<'py>,
    optimum: (Vec<f64>, Vec<f64>),
    by: Vec<GivenParameter>,
    given_options: &Bound<'py, PyDict>,
) -> PyResult<Vec<(Bound<'py, PyArray1<f64>>, f64)>> {
    let (statement, options, (x, multipliers)) = (problem.statement()?, options(given_options)?, optimum);
    let [of] = &statement.motions[..] else { return Err(wrong_input("`sensitivities` has one motion")) };
    let parameter = |given: &GivenParameter| match given {
        GivenParameter::Target(name) => Ok(Parameter::Target(of.system.output(output(&of.system, name)?))),
        GivenParameter::Bound(i) => Ok(Parameter::Bound(*i)),
    };
    let parameters = by.iter().map(parameter).collect::<PyResult<Vec<_>>>()?;
    let (mut motion, stop) = stoppable(of)?;
    let found = in_pool(py, 1, (&stop, None), |watch| {
        let minimum = optimize::solve(&mut motion, Guess::Optimum { x, multipliers }, &options, watch)?.outcome;
        optimize::sensitivities(&mut motion, &minimum, &parameters, &options)
    })?;
    let all = found.map_err(raised)?;
    Ok(all.into_iter().map(|of| (PyArray1::from_vec(py, of.x), of.value)).collect())
}

/// Fits all motions, also from far away.
#[pyfunction]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    problem: GivenProblem<'py>,
    given_options: &Bound<'py, PyDict>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (statement, options, signals) = (problem.statement()?, options(given_options)?, Signals::default());
    let mut trials = statement.trials(|| signals.watcher()).map_err(raised)?;
    let mut watch = watcher(&signals, callback);
    let result = py.detach(|| optimize::identify(&mut trials, &options, &mut watch));
    signals.take()?;
    let found = result.map_err(raised)?;
    let attempts: Vec<_> = found.attempts.iter().map(attempt).collect();
    let table = found.table();
    let solved = (found.fit.outcome.clone(), Some(found.fit));
    let all = described(py, &statement, &Problem::Trials(trials), &solved)?;
    all.set_item("attempts", attempts)?;
    all.set_item("_table", table)?;
    Ok(all)
}

/// The problem of a motion, and the flag that stops it.
fn stoppable(of: &Motion) -> PyResult<(MotionProblem, Arc<AtomicBool>)> {
    let stop = Arc::new(AtomicBool::new(false));
    let is_stopped = stop.clone();
    Ok((of.problem(move || stopped(&is_stopped)).map_err(raised)?, stop))
}

/// The entries of `Attempt` of Python.
fn attempt(of: &Attempt) -> (&str, String, f64, f64, usize, bool) {
    (&of.what, of.reason.to_string(), of.value, of.violation, of.iterations, of.is_unstable)
}

/// Runs a method without the lock of the interpreter, in a pool of its own: a common pool would have no threads in forked processes. The thread that calls
/// this function examines signals, which set the flag, and calls the callback with the iterates.
fn in_pool<T: Send>(
    py: Python<'_>,
    threads: usize,
    (stop, callback): (&AtomicBool, Option<Py<PyAny>>),
    method: impl FnOnce(&mut Watcher) -> T + Send,
) -> PyResult<T> {
    let signals = Signals::default();
    let (mut call, mut examine) = (watcher(&signals, callback), signals.watcher());
    let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
    let pool = pool.map_err(|error| PyOSError::new_err(error.to_string()))?;
    let found = py.detach(|| {
        let (iterate, iterates) = channel::<(Iterate, Vec<f64>)>();
        let (answer, answers) = channel();
        let ask = move |at: &Iterate, x: &[f64]| {
            let is_sent = iterate.send((*at, x.to_vec())).is_ok();
            if is_sent { answers.recv().unwrap_or(ControlFlow::Break(())) } else { ControlFlow::Break(()) }
        };
        std::thread::scope(|scope| {
            let thread = scope.spawn(|| {
                let mut ask = ask;
                pool.install(|| method(&mut ask))
            });
            loop {
                match iterates.recv_timeout(EVERY) {
                    Ok((at, x)) => drop(answer.send(call(&at, &x))),
                    Err(RecvTimeoutError::Timeout) if examine().is_break() => stop.store(true, Relaxed),
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            }
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    });
    signals.take()?;
    Ok(found)
}
