//! How far a computation has come, told to whoever wants to know.

use std::ops::ControlFlow;

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

/// About so many times a task is told of.
const TIMES: usize = 100;
/// Where the number of all nodes is a guess, at most so many are between two times.
const MOST_BETWEEN: usize = 100;

/// Who is told, if anybody.
#[derive(Default)]
pub(crate) struct Watch {
    callback: Option<Box<dyn FnMut(Progress) -> ControlFlow<()> + Send>>,
    /// The way back has begun: parts of the motion that are computed again are not told.
    is_back: bool,
    /// How many nodes of a longer motion, which is told of, come before those that are computed and behind them.
    around: [usize; 2],
    /// What was done when it was told of last.
    told: usize,
}

impl Watch {
    pub(crate) fn new(callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) -> Self {
        Watch::of_part(callback, [0, 0])
    }

    /// Of a part of a motion, with so many nodes before and behind it.
    pub(crate) fn of_part(callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static, around: [usize; 2]) -> Self {
        Watch { callback: Some(Box::new(callback)), is_back: false, around, told: 0 }
    }

    /// Another motion begins.
    pub(crate) fn begin(&mut self) {
        (self.is_back, self.told) = (false, 0);
    }

    /// The way back begins.
    pub(crate) fn turn(&mut self) {
        (self.is_back, self.told) = (true, 0);
    }

    /// Tells of every hundredth part.
    ///
    /// # Errors
    /// If the answer is to stop.
    #[inline]
    pub(crate) fn tell(&mut self, task: Task, done: usize, of: usize) -> Result<(), Error> {
        self.tell_every(usize::MAX, task, done, of)
    }

    /// The same where the number of all nodes is a guess, which may grow faster than what is done.
    ///
    /// # Errors
    /// As [`tell`](Self::tell).
    pub(crate) fn tell_of_guess(&mut self, task: Task, done: usize, of: usize) -> Result<(), Error> {
        self.tell_every(MOST_BETWEEN, task, done, of)
    }

    #[inline]
    fn tell_every(&mut self, most: usize, task: Task, done: usize, of: usize) -> Result<(), Error> {
        let Some(callback) = &mut self.callback else { return Ok(()) };
        let [before, behind] = self.around;
        let (done, of) = (before + done, before + of + behind);
        // A period that changes with the guess may pass over its multiples.
        let is_due =
            done == of || done.is_multiple_of(of.div_ceil(TIMES).min(most)) || done >= self.told.saturating_add(most);
        if !is_due || self.is_back && task == Task::Simulation {
            return Ok(());
        }
        self.told = done;
        match callback(Progress { task, done, of }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted { done, of }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[test]
    fn a_guess_that_grows_is_told_of_every_hundred_steps_at_least() {
        let told = Arc::new(Mutex::new(vec![0]));
        let seen = told.clone();
        let mut watch = Watch::new(move |progress| {
            seen.lock().expect("no panic").push(progress.done);
            ControlFlow::Continue(())
        });
        watch.begin();
        // Its hundredth part is never one of which what is done is a multiple.
        for done in 1..2000 {
            let of = if done % 97 == 0 { 8900 } else { 9700 };
            watch.tell_of_guess(Task::Simulation, done, of).expect("nobody stops");
        }
        let told = told.lock().expect("no panic");
        assert!(told.windows(2).all(|pair| pair[1] - pair[0] <= 100) && told.last() == Some(&1900), "{told:?}");
    }
}
