//! Progress reports to a callback.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};

use crate::Error;

/// Progress of a simulation or an adjoint sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The task being computed.
    pub task: Task,
    /// Number of nodes computed.
    pub done: usize,
    /// Number of all nodes.
    pub of: usize,
}

/// A task whose progress is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The simulation.
    Simulation,
    /// The adjoint sweep.
    Gradient,
}

/// Approximate number of progress reports per task.
const TIMES: usize = 100;
/// Largest number of nodes between two reports if the number of all nodes is an estimate.
const MOST_BETWEEN: usize = 100;

/// A callback for several motions, which may be computed by several threads.
type Callback = Arc<Mutex<dyn FnMut(Progress) -> ControlFlow<()> + Send>>;

/// Reports progress to a callback, if there is one.
#[derive(Default)]
pub(crate) struct Watch {
    callback: Option<Callback>,
    /// True after the backward sweep has begun: parts of the motion that are recomputed are not reported.
    is_back: bool,
    /// Numbers of nodes before and after the computed ones in a longer motion, to which the reports refer.
    around: [usize; 2],
    /// Number of nodes done at the last report.
    told: usize,
}

impl Watch {
    pub(crate) fn new(callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) -> Self {
        Watch { callback: Some(Arc::new(Mutex::new(callback))), ..Watch::default() }
    }

    /// Reports of another motion to the same callback. The motion is a part of a longer one, with `around[0]` nodes before it and `around[1]` nodes
    /// after it.
    pub(crate) fn shared(&self, around: [usize; 2]) -> Self {
        Watch { callback: self.callback.clone(), around, ..Watch::default() }
    }

    /// Begins another motion.
    pub(crate) fn begin(&mut self) {
        (self.is_back, self.told) = (false, 0);
    }

    /// Begins the backward sweep.
    pub(crate) fn turn(&mut self) {
        (self.is_back, self.told) = (true, 0);
    }

    /// Reports progress about a hundred times per task.
    ///
    /// # Errors
    /// If the callback stops the computation.
    #[inline]
    pub(crate) fn tell(&mut self, task: Task, done: usize, of: usize) -> Result<(), Error> {
        self.tell_every(usize::MAX, task, done, of)
    }

    /// Reports progress if the number of all nodes is an estimate, which may grow faster than the number of nodes done.
    ///
    /// # Errors
    /// As [`tell`](Self::tell).
    pub(crate) fn tell_of_guess(&mut self, task: Task, done: usize, of: usize) -> Result<(), Error> {
        self.tell_every(MOST_BETWEEN, task, done, of)
    }

    #[inline]
    fn tell_every(&mut self, most: usize, task: Task, done: usize, of: usize) -> Result<(), Error> {
        let Some(callback) = &self.callback else { return Ok(()) };
        let [before, behind] = self.around;
        let (done, of) = (before + done, before + of + behind);
        // If the period changes with the estimate, its multiples may be skipped.
        let is_due =
            done == of || done.is_multiple_of(of.div_ceil(TIMES).min(most)) || done >= self.told.saturating_add(most);
        if !is_due || self.is_back && task == Task::Simulation {
            return Ok(());
        }
        self.told = done;
        let mut callback = callback.lock().unwrap_or_else(PoisonError::into_inner);
        match (*callback)(Progress { task, done, of }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted { done, of }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guess_that_grows_is_told_of_every_hundred_steps_at_least() {
        let told = Arc::new(Mutex::new(vec![0]));
        let seen = told.clone();
        let mut watch = Watch::new(move |progress| {
            seen.lock().expect("no panic").push(progress.done);
            ControlFlow::Continue(())
        });
        watch.begin();
        // The number of nodes done is never a multiple of a hundredth of the estimate.
        for done in 1..2000 {
            let of = if done % 97 == 0 { 8900 } else { 9700 };
            watch.tell_of_guess(Task::Simulation, done, of).expect("nobody stops");
        }
        let told = told.lock().expect("no panic");
        assert!(told.windows(2).all(|pair| pair[1] - pair[0] <= 100) && told.last() == Some(&1900), "{told:?}");
    }
}
