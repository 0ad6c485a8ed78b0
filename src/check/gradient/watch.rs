//! [`Watch`]: the progress callback of a check, which all its solvers share.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::{Error, Progress, Solver};

/// A progress callback, if there is one.
#[derive(Clone, Default)]
pub(super) struct Watch(Option<Arc<Mutex<Shared>>>);

struct Shared {
    callback: Box<dyn FnMut(Progress) -> ControlFlow<()> + Send>,
    /// Where the callback stopped the check. It is not called again, because motions that fail are left out in some comparisons.
    stopped: Option<Progress>,
}

fn lock(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watch {
    pub(super) fn new(callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) -> Self {
        Watch(Some(Arc::new(Mutex::new(Shared { callback: Box::new(callback), stopped: None }))))
    }

    /// A solver that calls the callback.
    pub(super) fn over(&self, mut solver: Solver) -> Solver {
        if let Some(shared) = self.0.clone() {
            solver.watch(move |at| {
                let Shared { callback, stopped } = &mut *lock(&shared);
                if stopped.is_none() && callback(at).is_break() {
                    *stopped = Some(at);
                }
                if stopped.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
        }
        solver
    }

    /// Ends a check.
    ///
    /// # Errors
    /// If the callback has stopped it.
    pub(super) fn end(&self) -> Result<(), Error> {
        let stopped = self.0.as_ref().and_then(|shared| lock(shared).stopped.take());
        stopped.map_or(Ok(()), |Progress { done, of, .. }| Err(Error::Interrupted { done, of }))
    }
}
