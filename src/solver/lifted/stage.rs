//! A stage in numbers of type R: r = 0 by corrections with the real tangent matrix, starting from the real solution.

use super::{Lifted, Near};
use crate::Error;
use crate::motion::{Motion, StepEnd, column};
use crate::node::{SETTLED, SMALL, Shrinking, Size, add_correction, diverged, overflow};
use crate::number::Real;

/// Residual relative to the parts of its terms below which the iteration stops as well: the rest is rounding error.
const ROUNDING: f64 = 1e-13;
/// Velocities below this fraction of the largest velocity of the motion are rounding error.
const AT_REST: f64 = 1e-14;
/// Largest number of corrections. With an exact tangent matrix two suffice; slow convergence indicates wrong blocks.
const MOST_CORRECTIONS_OF_STAGE: usize = 30;

impl Near<'_> {
    /// Factors K(h) with the blocks of a stage of the step into a node.
    pub(super) fn factor(&mut self, i: usize, h: f64, blocks: &[f64]) -> Result<(), Error> {
        let factored = self.linearisation.factor(self.system, h, blocks, self.report);
        factored.map(|_| ()).map_err(|breakdown| self.system.singular_step(&breakdown, i, self.motion.trajectory.times[i]))
    }
}

impl<R: Real> Lifted<R> {
    pub(super) fn solve_node(&mut self, near: &mut Near, i: usize) -> Result<(), Error> {
        self.solve_stage(near, (i, self.trajectory.last_stage()), R::zero(), None)
    }

    /// Solves a stage, or the end of the step into a node with an event, starting from the real solution.
    pub(super) fn solve_stage(
        &mut self,
        near: &mut Near,
        (i, s): (usize, usize),
        h: R,
        end: Option<StepEnd>,
    ) -> Result<(), Error> {
        let motion = near.motion;
        self.start_from_real(motion, (i, s), end);
        let at = motion.block_column(i, s);
        let blocks = end.map_or_else(|| column(&motion.blocks, at), |end| end.blocks);
        near.factor(i, h.part(0), blocks)?;
        let mut sizes = Shrinking::new();
        for correction in 0..MOST_CORRECTIONS_OF_STAGE {
            self.evaluate(near, (i, s), h);
            let (size, is_rounding) = self
                .correct(near, (i, s), h)
                .ok_or_else(|| overflow(near.motion, i, "the complex or dual part of the motion"))?;
            let is_stalled = sizes.is_stalled(size);
            if correction > 0 && (size.of_part <= SETTLED || is_rounding || is_stalled) {
                self.rounding = self.rounding.max(size.of_all);
                self.evaluate(near, (i, s), h);
                self.store((i, s), h);
                return Ok(());
            }
        }
        Err(diverged(near.motion, i, (MOST_CORRECTIONS_OF_STAGE, sizes.last), "the complex or dual part of the step"))
    }

    fn start_from_real(&mut self, motion: &Motion, (i, s): (usize, usize), end: Option<StepEnd>) {
        let real = motion.trajectory.stage(i, s);
        let (v, sigma) = end.map_or((real.v, real.sigma), |end| (end.v, end.sigma));
        let lift = |to: &mut [R], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, &from)| *to = from.into());
        let now = self.trajectory.stage_mut(i, s);
        lift(now.v, v);
        lift(now.sigma, sigma);
    }

    /// Computes q = q̄ + h v and the sums of all elements there.
    fn evaluate(&mut self, near: &Near, (i, s): (usize, usize), h: R) {
        let now = self.trajectory.stage_mut(i, s);
        for ((q, &start), &v) in now.q.iter_mut().zip(&self.start_q).zip(now.v.iter()) {
            *q = start + h * v;
        }
        let now = self.trajectory.stage(i, s);
        let sigma = now.sigma;
        let u = if s == self.trajectory.last_stage() { self.inputs.controls_at(i) } else { now.u };
        near.system.plain_sums(&now.with_inputs((u, &self.design)), &mut self.sums);
        for &(j, mu) in near.linearisation.evaluation.compliance() {
            self.sums.parts_mut()[2][j] -= (sigma[j] - self.start_sigma[j]) * mu;
        }
    }

    /// Corrects every part by K⁻¹. Returns the size of the largest correction, and true if the residual before it was only rounding error;
    /// `None` if a part is not finite.
    fn correct(&mut self, near: &mut Near, (i, s): (usize, usize), h: R) -> Option<(Size, bool)> {
        let (mut largest, mut is_rounding) = (Size::default(), true);
        for part in 0..R::PARTS {
            let (mut residual, mut scale) = (0.0f64, 0.0f64);
            for (k, r) in self.part.v.iter_mut().enumerate() {
                let terms = [self.start_p[k], h * self.sums.force()[k], self.sums.l_v()[k]];
                *r = (terms[0] + terms[1] - terms[2]).part(part);
                residual = residual.max(r.abs());
                // A term whose part is zero except for rounding counts with its real part times the size of the perturbation.
                for term in terms {
                    scale = scale.max(term.part(part).abs()).max(term.part(0).abs() * self.unit[part]);
                }
            }
            is_rounding &= residual <= ROUNDING * scale;
            self.part.sigma.iter_mut().zip(self.sums.phi_dot()).for_each(|(r, phi_dot)| *r = -phi_dot.part(part));
            near.linearisation.solve(near.system, &mut self.part);
            let unit = self.unit[part];
            // In a motion at rest except for rounding, derivatives that vanish are rounding error as well.
            let speed = largest_real(self.trajectory.stage(i, s).v);
            let floor = if speed <= AT_REST * self.speed { SMALL * self.speed * unit } else { 0.0 };
            largest = largest.max(add_correction(self.trajectory.stage_mut(i, s).v, part, &self.part.v, (floor, unit))?);
            // If the motion starts from rest, σ is a difference of momenta and has their rounding error.
            let sigma =
                add_correction(self.trajectory.stage_mut(i, s).sigma, part, &self.part.sigma, (SMALL * scale, unit))?;
            // For dependent constraints, the component of σ that causes no motion is known to a few digits only.
            largest = if !self.trajectory.has_dependent() { largest.max(sigma) } else { largest };
        }
        Some((largest, is_rounding))
    }

    /// Stores p* = p̄ + h ṗ* and ṗ* = 𝓛_q + Q.
    fn store(&mut self, (i, s): (usize, usize), h: R) {
        let now = self.trajectory.stage_mut(i, s);
        for ((p, &start), &force) in now.p_star.iter_mut().zip(&self.start_p).zip(self.sums.force()) {
            *p = start + h * force;
        }
        now.p_star_dot.copy_from_slice(self.sums.force());
    }
}

fn largest_real<R: Real>(x: &[R]) -> f64 {
    x.iter().fold(0.0, |largest, x| largest.max(x.part(0).abs()))
}
