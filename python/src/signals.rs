//! Ctrl-C during long computations.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Signals are examined at most this often, because another thread may hold the lock of the interpreter.
const EVERY: Duration = Duration::from_millis(50);

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
        let (signals, mut last) = (self.clone(), (usize::MAX, Instant::now()));
        move || {
            let finished = signals.0.finished.load(Relaxed);
            if last.0 != finished {
                last = (finished, Instant::now());
            } else if last.1.elapsed() >= EVERY {
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    signals.keep(error);
                    return ControlFlow::Break(());
                }
                last.1 = Instant::now();
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

/// Runs a computation on all cores. `work` computes one item with a worker of its thread and stops if the flag is set.
pub(crate) fn on_all_cores<I: Sync, W, T: Send>(
    py: Python<'_>,
    items: &[I],
    worker: impl Fn(Arc<AtomicBool>) -> W + Sync,
    work: impl Fn(&mut W, &I) -> T + Sync,
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
            let (mut pause, mut watch) = (Duration::from_micros(20), signals.watcher());
            while threads.iter().any(|thread| !thread.is_finished()) {
                std::thread::sleep(pause);
                pause = (pause * 2).min(EVERY / 10);
                if watch().is_break() {
                    stop.store(true, Relaxed);
                }
            }
            let joined = |thread: std::thread::ScopedJoinHandle<'_, Vec<_>>| {
                thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            threads.into_iter().flat_map(joined).collect()
        })
    });
    signals.take()?;
    done.sort_unstable_by_key(|(i, _)| *i);
    Ok(done.into_iter().map(|(_, result)| result).collect())
}
