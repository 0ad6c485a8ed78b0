//! Rigid contacts along a motion: gaps that become negative without an event, and contacts that pull.

use super::ForwardSweep;
use crate::motion::column;
use crate::{Error, Settings, System, Warning};

/// A change of σ below this fraction of its size is rounding.
const ROUNDING: f64 = 1e-10;

impl ForwardSweep {
    /// Warns of an open contact whose gap is negative at a node, and of a closed one that has pulled in the step before it.
    pub(super) fn watch_contacts(&mut self, system: &System, node: usize, settings: &Settings) {
        let (k, length) = (node - self.motion.first, self.motion.length(node));
        if length == 0.0 {
            return;
        }
        for gap in system.gaps() {
            let is_open = self.motion.open_into(node).any(|open| open == gap.equation);
            let is_wrong = if is_open {
                system.event_value::<f64>(gap.event, &self.motion.at(node)) < -settings.position_tolerance
            } else {
                let [before, now] = [k - 1, k].map(|k| column(&self.motion.trajectory.sigma, k)[gap.equation]);
                (now - before) * length.signum() > ROUNDING * now.abs().max(before.abs())
            };
            if is_wrong {
                let (contact, time) = (system.event_name(gap.event).to_string(), self.motion.time(node));
                self.warn_once(match is_open {
                    true => Warning::Penetrated { contact, time },
                    false => Warning::Pulls { contact, time },
                });
            }
        }
    }

    /// Adds a warning of a contact unless there is one already, at an earlier time.
    #[cold]
    fn warn_once(&mut self, warning: Warning) {
        let of = |warning: &Warning| match warning {
            Warning::Penetrated { contact, .. } => Some((true, contact.clone())),
            Warning::Pulls { contact, .. } => Some((false, contact.clone())),
            _ => None,
        };
        if !self.monitor.report.warnings.iter().any(|known| of(known) == of(&warning)) {
            self.monitor.report.warn(warning);
        }
    }

    /// Returns an error if equations that close at a node are not satisfied there.
    pub(super) fn see_that_they_meet(
        &self,
        system: &System,
        node: usize,
        (event, closing): (usize, &[usize]),
        settings: &Settings,
    ) -> Result<(), Error> {
        let (at, mut phi) = (self.motion.at(node), vec![0.0; system.m()]);
        system.phi(&at, &mut phi);
        let is_apart = |phi: f64| phi.is_nan() || phi.abs() > settings.position_tolerance;
        if !closing.iter().any(|&j| is_apart(phi[j])) {
            return Ok(());
        }
        system.take_rounding(&at, at.q, &mut phi);
        let Some(&j) = closing.iter().find(|&&j| is_apart(phi[j])) else { return Ok(()) };
        Err(Error::ClosesApart {
            event: system.event_name(event).into(),
            equation: system.equation_name(j).into(),
            violation: phi[j],
            tolerance: settings.position_tolerance,
            time: at.t,
        })
    }
}
