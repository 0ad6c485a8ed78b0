//! Events at nodes (`event/`) in the forward sweep.

use super::{ForwardSweep, restart};
use crate::event::{After, Forward, reset_map};
use crate::motion::{Event, StepEnd, column, column_mut};
use crate::node::StepFailure;
use crate::{Error, Settings, System};

impl ForwardSweep {
    /// Lets happen what is due at a node.
    pub(super) fn pass_events(&mut self, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
        #[cfg(test)]
        if let Some(impulse) = crate::event::impulse::impulse_at(node) {
            self.pass(system, (node, Event::Impulse(impulse)), settings)?;
            restart::keep_end(self, node);
            return Ok(());
        }
        restart::apply(self, system, node, settings)
    }

    /// Lets an event happen at a node, and solves the node anew.
    pub(super) fn pass(&mut self, system: &System, of: (usize, Event), settings: &Settings) -> Result<(), Error> {
        let node = of.0;
        let passed = self.reset(system, of).and_then(|()| self.solve_node(system, node, 0.0, settings));
        passed.map_err(|failure| self.explain(system, node, failure))?;
        self.check_compliant(system, node, settings)
    }

    /// Replaces the end of a step by the known part of the node problem after the event.
    fn reset(&mut self, system: &System, (node, event): (usize, Event)) -> Result<(), StepFailure> {
        let ForwardSweep { motion, stepper, monitor, restarting, .. } = self;
        let mut events = std::mem::take(&mut motion.events);
        let (k, y) = (node - motion.first, motion.at(node));
        stepper.set_start(y.q, y.p_star, y.sigma);
        let end = StepEnd {
            q: y.q,
            v: y.v,
            p_star_dot: y.p_star_dot,
            sigma: y.sigma,
            blocks: column(&motion.blocks, motion.block_column(k, motion.trajectory.last_stage())),
        };
        let pushed = events.push((node, event), end, |numbers| {
            reset_map(&event).forward(Forward {
                system,
                motion,
                node,
                linearisation: &mut stepper.newton.linearisation,
                report: &mut monitor.report,
                lengths: &mut monitor.lengths,
                sigma_before: &restarting.last_end.sigma,
                point: &mut restarting.point,
                after: After { q: &mut stepper.start_q, p_star: &mut stepper.start_p, sigma: &mut stepper.start_sigma },
                numbers,
            })
        });
        motion.events = events;
        pushed?;
        reset_map(&event).monitor(node, &mut motion.trajectory, &mut monitor.report);
        column_mut(&mut motion.trajectory.q, k).copy_from_slice(&stepper.start_q);
        column_mut(&mut motion.trajectory.sigma, k).copy_from_slice(&stepper.start_sigma);
        stepper.smooth_from = node;
        stepper.newton.linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(node));
        Ok(())
    }
}
