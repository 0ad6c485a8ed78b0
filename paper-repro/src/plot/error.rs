//! What can go wrong in the making of a figure.

use std::{error::Error, fmt, io};

/// A figure could not be drawn or written.
#[derive(Debug)]
pub enum PlotError {
    /// A file could not be written.
    Io(io::Error),
    /// The drawing backend refused, for the stated reason.
    Draw(String),
}

impl PlotError {
    /// Wraps an error of the drawing backend.
    pub(super) fn draw(reason: impl fmt::Display) -> Self {
        Self::Draw(reason.to_string())
    }
}

impl fmt::Display for PlotError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(error) => write!(out, "cannot write the figure: {error}"),
            Self::Draw(reason) => write!(out, "cannot draw the figure: {reason}"),
        }
    }
}

impl Error for PlotError {}

impl From<io::Error> for PlotError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}
