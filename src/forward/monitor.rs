//! [`Monitor`]: what a run has to say of itself.

use super::Examiner;
use crate::Warning;
use crate::motion::Report;
use crate::system::Order;

/// The report of a run, and what its warnings are made of.
pub(crate) struct Monitor {
    pub(crate) report: Report,
    pub(crate) examiner: Examiner,
    /// The most that an angle turned in a step, if it is worth a warning.
    pub(crate) most_turn: f64,
    /// The most that the compliances of dependent constraints took of the kinetic energy, if it is worth a warning, and the largest one looked at.
    pub(crate) most_braked: f64,
    pub(crate) most_kinetic: f64,
    /// What they took since equations were chosen to be left out, if it is worth choosing anew.
    pub(crate) brake: f64,
    /// Whether what is left out is to be chosen anew, or positions projected, as soon as possible.
    pub(crate) is_urgent: bool,
    /// Φ of a node, and what its entries are compared with.
    pub(crate) phi: Vec<f64>,
    pub(crate) lengths: Vec<f64>,
    /// The largest |q_i| up to the last node; empty where no length asks for it.
    pub(crate) reach: Vec<f64>,
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
            phi: vec![0.0; m],
            lengths: vec![0.0; m],
            reach: Vec::with_capacity(n),
        }
    }

    /// Nothing is known of what compliances take.
    pub(crate) fn forget_brakes(&mut self) {
        (self.most_braked, self.most_kinetic, self.brake) = (Warning::BRAKED, 0.0, 0.0);
        self.is_urgent = false;
    }
}
