//! A restart in the forward sweep.

use super::super::Forward;
use crate::motion::Restart;
use crate::node::{Projection, StepFailure};

/// Computes (q, p̄, s). Needs the factors of K(0) at the end of the step if Φ = 0 is to be restored.
pub(super) fn reset(restart: &Restart, of: Forward) -> Result<(), StepFailure> {
    let Forward { system, motion, node, linearisation, report, lengths, sigma_before, point: at, after, numbers } = of;
    let end = motion.at(node);
    at.q.copy_from_slice(end.q);
    if restart.projects {
        at.x.v.copy_from_slice(end.v);
        at.x.sigma.fill(0.0);
        let compliances = motion.compliance_of_projection(system, node);
        if linearisation.evaluation.compliance() != &*compliances {
            // Left-out equations are projected with the others.
            linearisation.evaluation.set_compliance(&compliances);
            linearisation.factor(system, 0.0, motion.node_blocks(node), report).map_err(StepFailure::Singular)?;
        }
        Projection { system, motion, linearisation, report, lengths, node }.apply(at)?;
        numbers.extend_from_slice(&at.x.sigma);
        numbers.extend_from_slice(&linearisation.evaluation.blocks);
    }
    at.x.v.copy_from_slice(end.v);
    let ends = sigma_before.iter().zip(end.sigma);
    at.x.sigma.iter_mut().zip(ends).for_each(|(s, (before, now))| *s = restart.begin(*before, *now));
    at.evaluate(system, motion, linearisation, node, report);
    numbers.extend_from_slice(&at.x.sigma);
    numbers.extend_from_slice(&linearisation.evaluation.blocks);
    after.q.copy_from_slice(&at.q);
    after.p_star.copy_from_slice(&at.left.v);
    after.sigma.copy_from_slice(&at.x.sigma);
    Ok(())
}
