//! [`ForwardSweep`]: the state of a forward sweep.

use super::Stepper;
use super::monitor::Monitor;
use super::restarting::Restarting;
use crate::motion::{Motion, Watch};
use crate::node::SolvedMotion;
use crate::redundancy::{Dependence, Dependent};
use crate::system::KnownPart;
use crate::{Error, Scheme, Settings, System};

/// The forward sweep: the motion so far, the solver of its steps, and the checks along it.
pub(crate) struct ForwardSweep {
    pub(crate) motion: Motion,
    pub(crate) stepper: Stepper,
    pub(crate) monitor: Monitor,
    pub(crate) restarting: Restarting,
    pub(crate) watch: Watch,
    pub(crate) dependence: Dependence,
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
            dependence: Dependence::new(),
        }
    }

    /// The computed motion, for sweeps that differentiate it.
    pub(crate) fn solved(&mut self) -> SolvedMotion<'_> {
        let ForwardSweep { motion, stepper, monitor, watch, .. } = self;
        SolvedMotion { motion, linearisation: &mut stepper.newton.linearisation, report: &monitor.report, watch }
    }

    /// The dependent constraints of the motion.
    pub(crate) fn dependent<'a>(&'a mut self, system: &'a System) -> Dependent<'a> {
        let ForwardSweep { motion, stepper, monitor, restarting, dependence, .. } = self;
        let (q, p_star, sigma) = (&stepper.start_q[..], &stepper.start_p[..], &stepper.start_sigma[..]);
        Dependent {
            system,
            motion,
            linearisation: &mut stepper.newton.linearisation,
            report: &mut monitor.report,
            lengths: &mut monitor.lengths,
            point: &mut restarting.point,
            from: KnownPart { h: 0.0, q, p_star, sigma },
            state: dependence,
        }
    }

    /// Returns an error if dependent constraints cannot be satisfied together at a node.
    pub(super) fn check_compliant(&mut self, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
        if !self.motion.trajectory.has_dependent() {
            return Ok(());
        }
        self.dependent(system).compare_gaps(node, settings)
    }

    /// Checks dependent constraints in the step that ends at a node.
    pub(super) fn watch_dependent(&mut self, system: &System, node: usize) {
        if self.motion.trajectory.has_dependent() {
            self.dependent(system).watch(node);
        }
    }
}
