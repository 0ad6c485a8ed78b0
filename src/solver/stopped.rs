//! [`Stopped`]: an error together with the motion computed before it.

use std::fmt;

use crate::{Error, Trajectory};

/// The error of a simulation, together with the nodes computed before it.
#[derive(Clone)]
pub struct Stopped {
    /// The error.
    pub error: Error,
    /// The motion up to the error; [`Trajectory::computed`] is the number of computed nodes. All other nodes are zero.
    pub trajectory: Box<Trajectory>,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} ({} nodes were computed)", self.error, self.trajectory.computed)
    }
}

/// The message of `Display` without the motion, because `expect`, and a `main` that returns the error, print `Debug`.
impl fmt::Debug for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Stopped {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.error)
    }
}

impl From<Stopped> for Error {
    fn from(stopped: Stopped) -> Error {
        stopped.error
    }
}
