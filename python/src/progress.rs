//! Progress of long computations.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use hamiltonian_adjoint::{Progress, Task};
use pyo3::prelude::*;

use crate::signals::Signals;

/// Progress is reported at most this often, because a report needs the lock of the interpreter.
const EVERY: Duration = Duration::from_millis(100);

/// An object of Python that shows progress, if any. It is called with a task, the number of finished items and the number of all items; the method
/// `close` ends a computation.
#[derive(Clone)]
pub(crate) struct Bar(Option<Arc<Py<PyAny>>>);

impl Bar {
    pub(crate) fn new(object: Option<Py<PyAny>>) -> Self {
        Bar(object.map(Arc::new))
    }

    /// A callback of a solver that examines signals and reports progress.
    pub(crate) fn watcher(&self, signals: &Signals) -> impl FnMut(Progress) -> ControlFlow<()> + Send + 'static {
        let (mut examine, mut report) = (signals.watcher(), self.reporter(signals));
        move |at| {
            examine()?;
            let task = match at.task {
                Task::Simulation => "motion",
                Task::Gradient => "gradient",
            };
            report(task, at.done, at.of)
        }
    }

    /// A callback that reports progress. It returns `Break` if the object raises an exception, which is kept.
    pub(crate) fn reporter(&self, signals: &Signals) -> impl FnMut(&str, usize, usize) -> ControlFlow<()> + Send + 'static {
        let (bar, signals, mut last) = (self.0.clone(), signals.clone(), Instant::now());
        move |task, done, of| {
            let Some(bar) = bar.as_ref().filter(|_| last.elapsed() >= EVERY) else { return ControlFlow::Continue(()) };
            last = Instant::now();
            match Python::attach(|py| bar.call1(py, (task, done, of))) {
                Ok(_) => ControlFlow::Continue(()),
                Err(error) => {
                    signals.keep(error);
                    ControlFlow::Break(())
                }
            }
        }
    }

    /// Ends a computation.
    pub(crate) fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.0.as_ref().map_or(Ok(()), |bar| bar.call_method0(py, "close").map(drop))
    }
}
