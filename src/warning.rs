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
    /// Steps had no solution and were divided.
    HalvedSteps {
        /// The first of them, counted from 1.
        step: usize,
        /// When it begins, s.
        time: f64,
        /// How many nodes were inserted in all steps.
        inserted: usize,
        /// The length of the shortest part, s.
        shortest: f64,
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
            Warning::HalvedSteps { step, time, inserted, shortest } => write!(
                f,
                "steps had no solution and were halved, the first of them step {step} (t = {} s): {inserted} nodes were inserted, \
                 the shortest part is {shortest:.3e} s long; the gradient is that of the motion on this grid",
                seconds(*time)
            ),
        }
    }
}
