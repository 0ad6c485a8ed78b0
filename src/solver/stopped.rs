//! [`Stopped`]: an error with the motion up to it.

use std::fmt;

use crate::{Error, Trajectory};

/// A simulation that stopped, with all that it had computed.
#[derive(Clone)]
pub struct Stopped {
    /// Why.
    pub error: Error,
    /// The nodes that were computed before ([`Trajectory::computed`] tells how many; the others are zero).
    pub trajectory: Box<Trajectory>,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} ({} nodes were computed)", self.error, self.trajectory.computed)
    }
}

/// The sentence of `Display`, without the motion: it is what `expect`, and a `main` that returns the error, print.
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
