//! Events at nodes (`event/`) in products with the Hessian.

use super::changes::EventChange;
use super::forward::{StageEnd, stage_end};
use super::sources::OfStage;
use super::{First, SecondOrderSweep};
use crate::System;
use crate::adjoint::record::{OfEvent, Record};
use crate::event::{After, Along, BackwardAlong, Tools, reset_map};
use crate::linear::Breakdown;
use crate::motion::{Happened, Motion};
use crate::node::Linearisation;
use crate::number::add;
use crate::system::{CostRows, NodeView};

impl SecondOrderSweep {
    /// From the direction of the end of a step to that of the known part behind the event.
    pub(super) fn pass(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        happened: Happened,
    ) -> Result<(), Breakdown> {
        let end = self.change.at(happened.node);
        let mut of = self.unused_events.pop().unwrap_or_default();
        of.set_end(&end);
        self.known_q.copy_from_slice(end.q);
        self.known_p.copy_from_slice(end.p_star);
        self.sigma_before.copy_from_slice(end.sigma);
        reset_map(happened.event).along(Along {
            system,
            motion,
            happened,
            linearisation,
            report: &mut self.report,
            change: &self.change,
            after: After { q: &mut self.known_q, p_star: &mut self.known_p, sigma: &mut self.sigma_before },
            numbers: &mut of.numbers,
            tools: Tools {
                programs: &mut self.programs,
                phi: &mut self.phi,
                sums: &mut self.sums,
                rows: &mut self.first_rows,
                right: &mut self.right,
                left: &mut self.left,
                spare: &mut self.x_q,
                zeros: &self.zeros,
                no_controls: &self.no_controls,
            },
        })?;
        self.events.push(of);
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(happened.node));
        Ok(())
    }

    /// Passes an event backward, to the end of the step before it, whose sources are then in the sweep.
    pub(super) fn pass_back(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&mut Linearisation, &First),
        happened: Happened,
    ) -> Result<(), Breakdown> {
        let (Some(change), Some(of_first)) = (self.events.pop(), first.record.event(happened.node)) else { return Ok(()) };
        let OfEvent { after, own, .. } = of_first;
        let EventChange { q, v, sigma, p_star_dot, numbers } = &change;
        reset_map(happened.event).backward_along(BackwardAlong {
            of: self.sweep.begin_event(system, motion, linearisation, happened),
            first: after,
            first_own: own,
            change: &self.change,
            end: NodeView { q, v, sigma, p_star_dot, ..self.change.at(happened.node) },
            numbers,
            tools: Tools {
                programs: &mut self.programs,
                phi: &mut self.phi,
                sums: &mut self.sums,
                rows: &mut self.first_rows,
                right: &mut self.right,
                left: &mut self.left,
                spare: &mut self.x_q,
                zeros: &self.zeros,
                no_controls: &self.no_controls,
            },
        })?;
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_into(happened.node));
        self.sweep.carried.clear();
        self.add_end(system, motion, (linearisation, first.record), (happened, &change));
        self.ended = Some(change);
        Ok(())
    }

    /// Adds the sources at the end of the step.
    fn add_end(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, record): (&Linearisation, &Record),
        (happened, change): (Happened, &EventChange),
    ) {
        let (node, last) = (happened.node, motion.trajectory.last_stage());
        let stage = motion.block_column(node, last);
        let StageEnd { at, blocks, .. } = stage_end(motion, (node, last), Some(happened.end));
        let SecondOrderSweep { sweep, change: of_motion, programs, first_rows: rows, .. } = self;
        let along = NodeView { q: &change.q, v: &change.v, sigma: &change.sigma, ..of_motion.at(node) };
        let h_dot = of_motion.length(node) * motion.trajectory.scheme.a(last, last);
        let (with, step) = (record.covector(stage), record.of_step(stage));
        rows.clear();
        OfStage { at, along, blocks, with, step, h_dot }.add_sources(system, linearisation, programs, rows);
        let CostRows { q, v, sigma, p_star_dot, .. } = &mut sweep.cost;
        for (sum, own) in [(q, &rows.q), (v, &rows.v), (sigma, &rows.sigma), (p_star_dot, &rows.p_star_dot)] {
            add(sum, own);
        }
        sweep.add_inputs_of(rows);
    }
}
