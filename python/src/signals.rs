//! Ctrl-C during long computations.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use crate::progress::Bar;

/// Signals are examined at most this often, because another thread may hold the lock of the interpreter.
const EVERY: Duration = Duration::from_millis(50);
/// The stack of a thread that computes in the background, bytes: not less than that of the main thread.
pub(crate) const STACK: usize = 16 << 20;
/// Approximate time between two readings of the clock; slower calls read it each time.
const READ_EVERY: Duration = Duration::from_millis(1);

/// Examines signals during computations without the lock of the interpreter, and keeps the exception that one of them raises.
#[derive(Clone, Default)]
pub(crate) struct Signals(Arc<Shared>);

#[derive(Default)]
struct Shared {
    /// The number of finished computations.
    finished: AtomicUsize,
    raised: Mutex<Option<PyErr>>,
}

impl Signals {
    /// A callback that returns `Break` if a signal has raised an exception. The first call of a computation only begins the first interval.
    pub(crate) fn watcher(&self) -> impl FnMut() -> ControlFlow<()> + Send + 'static {
        let (signals, mut pulse) = (self.clone(), Pulse::new());
        move || {
            if pulse.is_due(signals.0.finished.load(Relaxed))
                && let Err(error) = Python::attach(|py| py.check_signals())
            {
                signals.keep(error);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        }
    }

    /// Keeps an exception.
    pub(crate) fn keep(&self, error: PyErr) {
        *self.0.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
    }

    /// Ends a computation, with the exception that was kept.
    pub(crate) fn take(&self) -> PyResult<()> {
        self.0.finished.fetch_add(1, Relaxed);
        let raised = self.0.raised.lock().unwrap_or_else(PoisonError::into_inner).take();
        raised.map_or(Ok(()), Err)
    }
}

/// The times at which signals are examined. In fast computations the clock is not read at every call, which would take a tenth of their time.
struct Pulse {
    /// The number of the computation.
    computation: usize,
    /// The time of the last examination.
    examined: Instant,
    /// The time at which the clock was read.
    read: Instant,
    /// Number of calls from one reading of the clock to the next.
    stride: usize,
    /// Number of calls until the clock is read.
    left: usize,
}

impl Pulse {
    fn new() -> Self {
        let now = Instant::now();
        Pulse { computation: usize::MAX, examined: now, read: now, stride: 1, left: 1 }
    }

    fn is_due(&mut self, computation: usize) -> bool {
        if self.computation != computation {
            *self = Pulse { computation, ..Pulse::new() };
            return false;
        }
        self.left -= 1;
        if self.left > 0 {
            return false;
        }
        let now = Instant::now();
        self.stride = match now - self.read {
            took if took < READ_EVERY / 2 => 2 * self.stride,
            took if took < 2 * READ_EVERY => self.stride,
            _ => 1,
        };
        (self.left, self.read) = (self.stride, now);
        let is_due = now - self.examined >= EVERY;
        if is_due {
            self.examined = now;
        }
        is_due
    }
}

/// Computes in a thread of its own, without the lock of the interpreter. Ctrl-C leaves the computation, whose thread ends later.
pub(crate) fn in_background<T: Send + 'static>(py: Python<'_>, compute: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(compute)?;
    let mut pause = Duration::from_micros(20);
    while !thread.is_finished() {
        py.detach(|| std::thread::sleep(pause));
        py.check_signals()?;
        pause = (2 * pause).min(Duration::from_millis(5));
    }
    Ok(thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
}

/// Runs a computation on all cores. `work` computes one item with a worker of its thread and stops if the flag is set.
pub(crate) fn on_all_cores<I: Sync, W, T: Send>(
    py: Python<'_>,
    items: &[I],
    worker: impl Fn(Arc<AtomicBool>) -> W + Sync,
    work: impl Fn(&mut W, &I) -> T + Sync,
    (bar, task): (&Bar, &str),
) -> PyResult<Vec<T>> {
    let (signals, stop, next) = (Signals::default(), Arc::new(AtomicBool::new(false)), AtomicUsize::new(0));
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(items.len());
    let take = || Some(next.fetch_add(1, Relaxed)).filter(|&i| i < items.len() && !stop.load(Relaxed));
    let mut done: Vec<(usize, T)> = py.detach(|| {
        std::thread::scope(|scope| {
            let one = || {
                let mut worker = worker(stop.clone());
                std::iter::from_fn(|| take().map(|i| (i, work(&mut worker, &items[i])))).collect::<Vec<_>>()
            };
            let threads: Vec<_> = (0..cores).map(|_| scope.spawn(one)).collect();
            let (mut pause, mut watch, mut report) = (Duration::from_micros(20), signals.watcher(), bar.reporter(&signals));
            while threads.iter().any(|thread| !thread.is_finished()) {
                std::thread::sleep(pause);
                pause = (pause * 2).min(EVERY / 10);
                let begun = next.load(Relaxed).min(items.len());
                if watch().is_break() || report(task, begun.saturating_sub(cores), items.len()).is_break() {
                    stop.store(true, Relaxed);
                }
            }
            let joined = |thread: std::thread::ScopedJoinHandle<'_, Vec<_>>| {
                thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            threads.into_iter().flat_map(joined).collect()
        })
    });
    let closed = bar.close(py);
    signals.take()?;
    closed?;
    done.sort_unstable_by_key(|(i, _)| *i);
    Ok(done.into_iter().map(|(_, result)| result).collect())
}
