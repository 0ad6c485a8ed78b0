//! Events at nodes (`event/`) in the forward sweep.

use super::{ForwardSweep, restart};
use crate::event::{After, Forward, reset_map};
use crate::model::{Action, Switch};
use crate::motion::{Due, Event, Restitution, StepEnd, column, column_mut, open, with_open};
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
        if !self.motion.inputs.events.is_empty()
            && let Some(due) = self.motion.switch_at(system, node)
        {
            return self.switch(system, node, due, settings);
        }
        restart::apply(self, system, node, settings)
    }

    /// Opens and closes constraint equations at a node.
    #[cold]
    fn switch(&mut self, system: &System, node: usize, due: Due, settings: &Settings) -> Result<(), Error> {
        let mut open: Vec<usize> = open(self.motion.trajectory.compliance_into(node)).collect();
        let (mut restitution, mut closing) = (None, Vec::new());
        for Switch { equation, action, .. } in system.switches_of(due.event) {
            match (action, due.is_second) {
                (Action::Open, false) => open.push(equation),
                (Action::Hold, false) => open.retain(|&j| j != equation),
                (Action::Close | Action::Impact(_), false) => closing.push(equation),
                (Action::Impact(coefficient), true) => {
                    open.push(equation);
                    restitution = Some(Restitution { equation, coefficient, before: self.restarting.last_end.node });
                }
                (_, true) => {}
            }
        }
        self.see_that_they_meet(system, node, (due.event, &closing), settings)?;
        open.retain(|j| !closing.contains(j));
        let compliances = with_open(self.motion.trajectory.compliance_into(node), &open);
        self.motion.set_compliance(node, compliances);
        self.stepper.newton.linearisation.weights.set_open(|j| open.contains(&j));
        self.pass(system, (node, Event::Switch(restitution)), settings)?;
        // The restitution needs σ before the impact.
        if due.is_last {
            restart::keep_end(self, node);
        }
        Ok(())
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
