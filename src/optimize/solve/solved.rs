//! [`Solved`]: the result of [`solve`](super::solve()), with what was tried.

use std::fmt;

use super::super::{Options, Outcome, Reason};

/// The result of [`solve`](super::solve()).
#[derive(Clone, Debug)]
pub struct Solved {
    /// The outcome for the problem as stated.
    pub outcome: Outcome,
    /// What was tried, in this order.
    pub attempts: Vec<Attempt>,
}

/// One of the ways that were tried.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The way.
    pub what: String,
    /// How it ended.
    pub reason: Reason,
    /// J at its end.
    pub value: f64,
    /// The largest violation of a constraint at its end.
    pub violation: f64,
    /// The number of its iterations.
    pub iterations: usize,
    /// True if segments met, but a single motion with their controls violates the constraints because it is unstable.
    pub is_unstable: bool,
}

impl Attempt {
    pub(in super::super) fn of(what: String, outcome: &Outcome, options: &Options) -> Self {
        let Outcome { reason, value, violation, iterations, .. } = *outcome;
        let is_unstable = reason.is_converged() && violation > options.violation;
        Attempt { what, reason, value, violation, iterations, is_unstable }
    }
}

/// A table of what was tried, if no minimum was found the violated constraints of the outcome, and its warnings.
impl fmt::Display for Solved {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{:<16} {:>10} {:>14} {:>10}  end", "tried", "iterations", "J", "violation")?;
        for Attempt { what, reason, value, violation, iterations, is_unstable } in &self.attempts {
            let end = if *is_unstable { "unstable as a single motion".into() } else { reason.to_string() };
            writeln!(f, "{what:<16} {iterations:>10} {value:>14.6e} {violation:>10.1e}  {end}")?;
        }
        let is_converged = self.outcome.reason.is_converged();
        self.outcome.named_violations().filter(|_| !is_converged).map_or(Ok(()), |named| writeln!(f, "{named}"))?;
        self.outcome.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))
    }
}
