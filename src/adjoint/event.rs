//! Events at nodes (`event/`) in the backward sweep.

use super::AdjointSweep;
use crate::System;
use crate::event::{Backward, reset_map};
use crate::linear::Breakdown;
use crate::motion::{Happened, Motion};
use crate::node::Linearisation;
use crate::scheme::StageAdjoint;

impl AdjointSweep {
    /// From the adjoint variables of a node after an event to a cost at the end of the step before it.
    pub(super) fn pass(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        happened: Happened,
    ) -> Result<(), Breakdown> {
        if let Some(record) = &mut self.record {
            record.begin_event(happened.node, &self.step[self.stage]);
        }
        let mut of = self.begin_event(system, motion, linearisation, happened);
        reset_map(happened.event).backward(&mut of)?;
        self.carried.clear();
        if let Some(record) = &mut self.record {
            record.end_event(&self.own);
        }
        Ok(())
    }

    /// The event, with dJ/dq = −a, dJ/dp̄ = −b and dJ/dσ̄ = μ e after it, from the adjoint variables of its node.
    pub(super) fn begin_event<'a>(
        &'a mut self,
        system: &'a System,
        motion: &'a Motion,
        linearisation: &'a mut Linearisation,
        happened: Happened<'a>,
    ) -> Backward<'a> {
        let StageAdjoint { a, b, e, d, .. } = &mut self.step[self.stage];
        self.cost.clear();
        self.cost_is_zero = false;
        self.cost.q.iter_mut().zip(&*a).for_each(|(q, a)| *q = -a);
        self.after.p_star.iter_mut().zip(&*b).for_each(|(p_star, b)| *p_star = -b);
        self.after.sigma.fill(0.0);
        for &(j, mu) in motion.trajectory.compliance_from(happened.node) {
            self.after.sigma[j] = mu * e[j];
        }
        self.own.v.fill(0.0);
        self.own.sigma.fill(0.0);
        Backward {
            system,
            motion,
            happened,
            linearisation,
            report: &mut self.report,
            after: &self.after,
            end: &mut self.cost,
            earlier: &mut self.earlier,
            u: &mut self.u,
            design: &mut self.design,
            time: &mut self.time,
            own: &mut self.own,
            zeros: &self.zeros,
            rows: &mut self.rows,
            right: &mut self.right,
            spare: d,
        }
    }
}
