//! Errors of a run.

use std::{fmt, io, path::PathBuf};

/// A run that could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene, a simulation or a gradient failed.
    #[error("the simulation failed: {0}")]
    Simulation(#[from] hamiltonian_adjoint::Error),
    /// A figure could not be drawn, for the reason that the drawing library states.
    #[error("cannot draw the figure: {0}")]
    Drawing(String),
    /// Unknown or invalid flags.
    #[error("{0} (try --help)")]
    Usage(String),
    #[error("cannot write to standard output: {0}")]
    Output(io::Error),
    /// A file or folder could not be written.
    #[error("cannot write {}: {source}; choose another folder with --out", path.display())]
    File { path: PathBuf, source: io::Error },
}

impl Error {
    pub fn drawing(reason: impl fmt::Display) -> Self {
        Error::Drawing(reason.to_string())
    }
}
