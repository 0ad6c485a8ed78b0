//! Constraint equations that open or close at a node, and impacts.
//!
//! The state stays, and the node problem with h = 0 is solved for the equations that hold from then on (`motion/open.rs`),
//!
//! ```text
//!   q = q⁻,  p̄ = p*⁻,  σ̄ = σ⁻
//! ```
//!
//! An equation that closes makes the velocities jump, and the impulses are the changes of σ: with the same p* and q, M v⁺ + Φ_qᵀ σ⁺ = M v⁻ + Φ_qᵀ σ⁻.
//!
//! **Impacts** take two events (Poisson's hypothesis). At the end of the compression, equation j holds; for the restitution it opens again, with a
//! further e-th part of its impulse,
//!
//! ```text
//!   σ̄_j = σ_j⁻ + e (σ_j⁻ − σ_j₋)       σ₋: before the impact
//! ```
//!
//! and the node problem is linear, so that dΦ_j/dt = −e (dΦ_j/dt)₋.

use super::{Along, Backward, BackwardAlong, Forward, Lifted, OnNumbers, ResetMap};
use crate::Error;
use crate::linear::Breakdown;
use crate::motion::{Report, Restitution, Trajectory};
use crate::node::StepFailure;
use crate::number::Real;

impl ResetMap for Option<Restitution> {
    fn forward(&self, of: Forward) -> Result<(), StepFailure> {
        if let Some(Restitution { equation: j, coefficient, .. }) = *self {
            let e: f64 = coefficient.value(&of.motion.design);
            of.after.sigma[j] += e * (of.after.sigma[j] - of.sigma_before[j]);
            of.numbers.push(of.sigma_before[j]);
        }
        Ok(())
    }

    fn monitor(&self, _: usize, _: &mut Trajectory, _: &mut Report) {}

    fn backward(&self, of: &mut Backward) -> Result<(), Breakdown> {
        of.end.p_star.copy_from_slice(&of.after.p_star);
        of.end.sigma.copy_from_slice(&of.after.sigma);
        let Some(Restitution { equation: j, coefficient, before }) = *self else { return Ok(()) };
        let (e, by_sigma): (f64, f64) = (coefficient.value(&of.motion.design), of.after.sigma[j]);
        of.end.sigma[j] += e * by_sigma;
        of.earlier.node = Some(before);
        of.earlier.rows[j] -= e * by_sigma;
        if let Some((p, factor)) = coefficient.bound() {
            of.design[p] += factor * (of.happened.end.sigma[j] - of.happened.numbers[0]) * by_sigma;
        }
        Ok(())
    }

    fn along(&self, of: Along) -> Result<(), Breakdown> {
        let Some(Restitution { equation: j, coefficient, before }) = *self else { return Ok(()) };
        let design = &of.change.design;
        let e: f64 = coefficient.value(&of.motion.design);
        let e_dot = coefficient.bound().map_or(0.0, |(p, factor)| factor * design[p]);
        let (sigma, before) = (of.happened.end.sigma[j] - of.happened.numbers[0], of.change.trajectory.sigma[(j, before)]);
        let change = of.after.sigma[j] - before;
        of.numbers.clear();
        of.numbers.push(change);
        of.after.sigma[j] += e * change + e_dot * sigma;
        Ok(())
    }

    fn backward_along(&self, mut of: BackwardAlong) -> Result<(), Breakdown> {
        self.backward(&mut of.of)?;
        let Some(Restitution { equation: j, coefficient, .. }) = *self else { return Ok(()) };
        let Some((p, factor)) = coefficient.bound() else { return Ok(()) };
        let compliances = of.of.motion.trajectory.compliance_from(of.of.happened.node).iter();
        let by_sigma: f64 = compliances.filter(|(k, _)| *k == j).map(|(_, mu)| mu * of.first.e[j]).sum();
        let e_dot = factor * of.change.design[p];
        of.of.end.sigma[j] += e_dot * by_sigma;
        of.of.earlier.rows[j] -= e_dot * by_sigma;
        of.of.design[p] += factor * of.numbers[0] * by_sigma;
        Ok(())
    }
}

impl<R: Real> OnNumbers<R> for Option<Restitution> {
    fn reset(&self, of: Lifted<R>) -> Result<(), Error> {
        if let Some(Restitution { equation: j, coefficient, before }) = *self {
            let e: R = coefficient.value(of.end.design);
            let change = of.after.sigma[j] - of.trajectory.sigma[(j, before)];
            of.after.sigma[j] += e * change;
        }
        Ok(())
    }
}
