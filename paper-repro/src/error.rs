//! What can go wrong in a run.

use std::{error, fmt, io, path::PathBuf};

/// A run that could not be finished.
#[derive(Debug)]
pub enum Error {
    /// A scene, a simulation or a gradient failed.
    Simulation(hamiltonian_adjoint::Error),
    /// A figure could not be drawn, for the reason that the drawing library states.
    Drawing(String),
    /// Flags that are unknown, or make no sense.
    Usage(String),
    Output(io::Error),
    /// A file or folder could not be written.
    File {
        path: PathBuf,
        source: io::Error,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Simulation(source) => write!(out, "the simulation failed: {source}"),
            Error::Usage(problem) => write!(out, "{problem} (try --help)"),
            Error::Output(source) => write!(out, "cannot write to standard output: {source}"),
            Error::Drawing(reason) => write!(out, "cannot draw the figure: {reason}"),
            Error::File { path, source } => {
                write!(out, "cannot write {}: {source}; choose another folder with --out", path.display())
            }
        }
    }
}

impl error::Error for Error {}

impl Error {
    pub fn drawing(reason: impl fmt::Display) -> Self {
        Error::Drawing(reason.to_string())
    }
}

impl From<hamiltonian_adjoint::Error> for Error {
    fn from(source: hamiltonian_adjoint::Error) -> Self {
        Error::Simulation(source)
    }
}
