//! [`Monitor`]: the report and the warnings of a run.

use crate::Warning;
use crate::motion::{Examiner, Report};
use crate::node::Lengths;
use crate::system::Order;

/// The report of a run, and the quantities from which its warnings are derived.
pub(crate) struct Monitor {
    pub(crate) report: Report,
    pub(crate) examiner: Examiner,
    /// Largest rotation of an angle in a step, if it is worth a warning.
    pub(crate) most_turn: f64,
    pub(crate) lengths: Lengths,
}

impl Monitor {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Monitor {
            report: Report::default(),
            examiner: Examiner::new(Order::First),
            most_turn: Warning::TURN,
            lengths: Lengths::new(n, m),
        }
    }
}
