//! Events at nodes (`event/`) in complex or dual numbers.

use super::{Lifted, Near};
use crate::motion::{Happened, column};
use crate::number::Real;
use crate::{Error, event};

impl<R: Real> Lifted<R> {
    /// Lets an event of the real motion happen, and solves its node anew.
    pub(super) fn pass(&mut self, near: &mut Near, happened: Happened) -> Result<(), Error> {
        let (node, motion) = (happened.node, near.motion);
        let Lifted { inputs, design, trajectory, sums, start_q, start_p, start_sigma, part, unit, rounding, .. } = self;
        start_q.copy_from_slice(column(&trajectory.q, node));
        start_p.copy_from_slice(column(&trajectory.p_star, node));
        start_sigma.copy_from_slice(column(&trajectory.sigma, node));
        let of = event::Lifted {
            system: near.system,
            motion,
            happened,
            linearisation: near.linearisation,
            report: near.report,
            trajectory,
            end: trajectory.at((inputs, design), node),
            after: event::After { q: start_q, p_star: start_p, sigma: start_sigma },
            sums,
            part,
            unit,
            rounding,
        };
        event::lift(happened.event, of)?;
        near.linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(node));
        self.solve_node(near, node)
    }
}
