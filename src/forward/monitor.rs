//! [`Monitor`]: the report and the warnings of a run.

use super::ForwardSweep;
use super::coarse::Oscillation;
use crate::Warning;
use crate::motion::{Examiner, Report};
use crate::node::Lengths;
use crate::redundancy::Losses;
use crate::system::Order;

/// The report of a run, and the quantities from which its warnings are derived.
pub(crate) struct Monitor {
    pub(crate) report: Report,
    pub(crate) examiner: Examiner,
    /// Largest rotation of an angle in a step, if it is worth a warning.
    pub(crate) most_turn: f64,
    pub(crate) lengths: Lengths,
    pub(super) oscillation: Oscillation,
}

/// What the checks of a motion have found so far, apart from the work.
pub(super) struct Found {
    warnings: Vec<Warning>,
    worst_pivot: f64,
    most_turn: f64,
    examiner: Examiner,
    counted: usize,
    losses: Losses,
    oscillation: Oscillation,
}

impl ForwardSweep {
    /// What has been found, to be restored if steps are computed anew with other lengths.
    pub(super) fn found(&self) -> Found {
        let ForwardSweep { monitor, stepper, dependence, .. } = self;
        Found {
            warnings: monitor.report.warnings.clone(),
            worst_pivot: monitor.report.worst_pivot,
            most_turn: monitor.most_turn,
            examiner: monitor.examiner,
            counted: stepper.continuation.counted,
            losses: dependence.losses,
            oscillation: monitor.oscillation.clone(),
        }
    }

    pub(super) fn restore_found(&mut self, found: &Found) {
        let ForwardSweep { monitor, stepper, dependence, .. } = self;
        monitor.report.warnings.clone_from(&found.warnings);
        monitor.oscillation.clone_from(&found.oscillation);
        (monitor.report.worst_pivot, monitor.most_turn, monitor.examiner) =
            (found.worst_pivot, found.most_turn, found.examiner);
        (stepper.continuation.counted, dependence.losses) = (found.counted, found.losses);
    }
}

impl Monitor {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Monitor {
            report: Report::default(),
            examiner: Examiner::new(Order::First),
            most_turn: Warning::TURN,
            lengths: Lengths::new(n, m),
            oscillation: Oscillation::default(),
        }
    }
}
