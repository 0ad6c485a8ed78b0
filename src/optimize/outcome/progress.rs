//! The development of violation and stationarity before a method stopped.

use std::fmt;

use super::{Outcome, Reason, significant};

/// Number of last iterates that are compared, half of them with the other half.
const LATELY: usize = 20;
/// A quantity that falls below this fraction within half of them improves.
const IMPROVES: f64 = 0.5;
/// Violations below this fraction of the largest one so far almost vanish.
const ALMOST: f64 = 1e-6;

/// The smallest violation and stationarity of the iterates before the last few, and of the last few.
struct Progress {
    iterations: usize,
    violation: [f64; 2],
    stationarity: [f64; 2],
    largest_violation: f64,
}

impl Outcome {
    /// True if more iterations are likely to help: in the last ten iterations, the smallest violation fell below half of its value in the ten
    /// iterations before or, if constraints almost hold, the smallest stationarity did. If false after [`Reason::Iterations`], the method made hardly
    /// any progress; another start or another statement of the problem is more likely to help.
    pub fn is_improving(&self) -> bool {
        self.progress().is_some_and(|of| of.improves())
    }

    fn progress(&self) -> Option<Progress> {
        let lately = &self.history[self.history.len().saturating_sub(LATELY)..];
        let (before, last) = lately.split_at(lately.len() / 2);
        if before.is_empty() {
            return None;
        }
        let least =
            |of: fn(&super::Iterate) -> f64| [before, last].map(|some| some.iter().map(of).fold(f64::INFINITY, f64::min));
        let largest_violation = self.history.iter().fold(0.0, |most: f64, it| most.max(it.violation));
        let (violation, stationarity) = (least(|it| it.violation), least(|it| it.stationarity));
        Some(Progress { iterations: lately.len() - 1, violation, stationarity, largest_violation })
    }

    /// Writes how violation and stationarity developed, if the method did not reach a solution.
    pub(super) fn describe_progress(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Some(progress) = self.progress() else { return Ok(()) };
        match self.reason {
            // Too few to tell.
            Reason::Iterations if progress.iterations + 1 < LATELY => write!(f, "; {progress}"),
            Reason::Iterations if progress.improves() => write!(f, "; {progress}, so more iterations are likely to help"),
            Reason::Iterations => write!(f, "; {progress}, so more iterations are unlikely to help"),
            Reason::NoLowerValue => write!(f, "; {progress}"),
            _ => Ok(()),
        }
    }
}

impl Progress {
    fn improves(&self) -> bool {
        let falls = |[before, last]: [f64; 2]| last < IMPROVES * before;
        let almost_holds = self.violation[1] <= ALMOST * self.largest_violation;
        if almost_holds { falls(self.stationarity) } else { falls(self.violation) }
    }
}

/// For example "in the last 19 iterations, the violation fell from 0.1 to 0.001, and the stationarity rose from 1 to 2".
impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let change = |[before, last]: [f64; 2]| match (significant(before, 2), significant(last, 2)) {
            (before, last) if before == last => format!("stayed at {last}"),
            (from, to) => format!("{} from {from} to {to}", if last < before { "fell" } else { "rose" }),
        };
        match self.iterations {
            1 => write!(f, "in the last iteration, ")?,
            many => write!(f, "in the last {many} iterations, ")?,
        }
        if self.largest_violation > 0.0 {
            write!(f, "the violation {}, and ", change(self.violation))?;
        }
        write!(f, "the stationarity {}", change(self.stationarity))
    }
}
