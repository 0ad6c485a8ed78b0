//! How far a computation has come, told to whoever wants to know.

use std::ops::ControlFlow;

use crate::Error;

/// How far a motion, or the way back through it, has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is under way.
    pub task: Task,
    /// Nodes that are done, and how many there are.
    pub done: usize,
    /// All nodes.
    pub of: usize,
}

/// What takes its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The motion.
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
}

impl Watch {
    pub(crate) fn new(callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) -> Self {
        Watch { callback: Some(Box::new(callback)), is_back: false }
    }

    /// Another motion begins.
    pub(crate) fn begin(&mut self) {
        self.is_back = false;
    }

    /// The way back begins.
    pub(crate) fn turn(&mut self) {
        self.is_back = true;
    }

    /// Tells of every hundredth part.
    ///
    /// # Errors
    /// If the answer is to stop.
    #[inline]
    pub(crate) fn tell(&mut self, task: Task, done: usize, of: usize) -> Result<(), Error> {
        self.tell_every(of.div_ceil(TIMES), task, done, of)
    }

    /// The same where the number of all nodes is a guess, which may grow faster than what is done.
    ///
    /// # Errors
    /// As [`tell`](Self::tell).
    pub(crate) fn tell_of_guess(&mut self, task: Task, done: usize, of: usize) -> Result<(), Error> {
        self.tell_every(of.div_ceil(TIMES).min(MOST_BETWEEN), task, done, of)
    }

    #[inline]
    fn tell_every(&mut self, nodes: usize, task: Task, done: usize, of: usize) -> Result<(), Error> {
        match &mut self.callback {
            Some(_) if self.is_back && task == Task::Simulation => Ok(()),
            Some(callback) if done == of || done.is_multiple_of(nodes) => match callback(Progress { task, done, of }) {
                ControlFlow::Continue(()) => Ok(()),
                ControlFlow::Break(()) => Err(Error::Interrupted { done, of }),
            },
            _ => Ok(()),
        }
    }
}
