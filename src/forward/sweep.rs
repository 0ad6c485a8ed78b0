//! [`ForwardSweep`]: the state of a forward sweep.

use super::Stepper;
use super::monitor::Monitor;
use super::restarting::Restarting;
use crate::motion::{Motion, Watch};
use crate::node::SolvedMotion;
use crate::redundancy::Relaxed;
use crate::{Scheme, System};

/// The forward sweep: the motion so far, the solver of its steps, and the checks along it.
pub(crate) struct ForwardSweep {
    pub(crate) motion: Motion,
    pub(crate) stepper: Stepper,
    pub(crate) monitor: Monitor,
    pub(crate) restarting: Restarting,
    pub(crate) watch: Watch,
    /// The dependent constraints of the last start that has any.
    pub(crate) relaxed: Option<Relaxed>,
}

impl ForwardSweep {
    pub(crate) fn new(system: &System, scheme: Scheme) -> Self {
        let (n, m) = (system.n(), system.m());
        ForwardSweep {
            motion: Motion::new(system, scheme),
            stepper: Stepper::new(system, scheme),
            monitor: Monitor::new(n, m),
            restarting: Restarting::new(n, m),
            watch: Watch::default(),
            relaxed: None,
        }
    }

    /// The computed motion, for sweeps that differentiate it.
    pub(crate) fn solved(&mut self) -> SolvedMotion<'_> {
        let ForwardSweep { motion, stepper, monitor, watch, .. } = self;
        SolvedMotion { motion, linearisation: &mut stepper.newton.linearisation, report: &monitor.report, watch }
    }
}
