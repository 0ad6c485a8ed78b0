//! What can go wrong in a run.

use std::{error, fmt, io, path::PathBuf};

use crate::plot::PlotError;

/// A run that could not be finished.
#[derive(Debug)]
pub enum Error {
    /// A scene, a simulation or a gradient failed.
    Simulation(hamiltonian_adjoint::Error),
    /// A figure could not be drawn or written.
    Figure {
        /// The path of its files, without suffix.
        stem: PathBuf,
        /// Why.
        source: PlotError,
    },
    /// A file or folder could not be written.
    File {
        /// Its path.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Simulation(source) => write!(out, "the simulation failed: {source}"),
            Error::Figure { stem, source } => write!(out, "{}: {source}", stem.display()),
            Error::File { path, source } => {
                write!(out, "cannot write {}: {source}; choose another folder with --out", path.display())
            }
        }
    }
}

impl error::Error for Error {}

impl From<hamiltonian_adjoint::Error> for Error {
    fn from(source: hamiltonian_adjoint::Error) -> Self {
        Error::Simulation(source)
    }
}
