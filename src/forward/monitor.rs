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
    /// Largest loss of kinetic energy by the compliances of dependent constraints, if it is worth a warning; largest kinetic energy at checked nodes.
    pub(crate) most_braked: f64,
    pub(crate) most_kinetic: f64,
    /// Loss of energy since left-out equations were chosen, if it is worth another choice.
    pub(crate) brake: f64,
    /// True if left-out equations must be chosen anew, or positions projected, as soon as possible.
    pub(crate) is_urgent: bool,
    pub(crate) lengths: Lengths,
}

impl Monitor {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Monitor {
            report: Report::default(),
            examiner: Examiner::new(Order::First),
            most_turn: Warning::TURN,
            most_braked: Warning::BRAKED,
            most_kinetic: 0.0,
            brake: 0.0,
            is_urgent: false,
            lengths: Lengths::new(n, m),
        }
    }

    /// Resets the losses by compliances.
    pub(crate) fn forget_brakes(&mut self) {
        (self.most_braked, self.most_kinetic, self.brake) = (Warning::BRAKED, 0.0, 0.0);
        self.is_urgent = false;
    }
}
