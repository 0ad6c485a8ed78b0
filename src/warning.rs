//! What a run has to say although it succeeded.

use std::fmt;

use crate::error::seconds;

/// A finding about the mechanism or the numbers of a run, by name, place and size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Constraints that follow from others; they were given a compliance, see [`Trajectory::compliance`](crate::Trajectory::compliance).
    DependentConstraints {
        /// The equations that take part in the dependency.
        equations: Vec<String>,
        /// When, s.
        time: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Warning::DependentConstraints { equations, time } => write!(
                f,
                "at t = {} s these constraints depend on each other: {}; the motion is determined, the share of each in their \
                 common reaction is not, and was chosen by a small compliance",
                seconds(*time),
                equations.join(", ")
            ),
        }
    }
}
