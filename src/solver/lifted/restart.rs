//! A restart in numbers of type R, near the real one (`forward/restart.rs`); its adjoint is in `adjoint/restart.rs`.

use super::stage::CONVERGED;
use super::{Lifted, Near, overflow};
use crate::Error;
use crate::motion::{MOST_CORRECTIONS_OF_PROJECTION, Restart, column, column_mut};
use crate::node::{Shrinking, Size, add_correction};
use crate::number::Real;
use crate::system::NodeView;

/// A correction larger than this fraction of the previous one no longer shrinks: those of slow projections that converge shrink by a third.
const SHRINKING: f64 = 0.75;

impl<R: Real> Lifted<R> {
    /// Restarts at a node: Φ = 0 and T_v as in `forward/restart.rs`, then v and σ as at node 0.
    pub(super) fn restart(&mut self, near: &mut Near, i: usize, restart: &Restart) -> Result<(), Error> {
        let v = column(&self.trajectory.v, i).to_vec();
        if let Some((nu, _)) = restart.projection {
            self.project(near, i, nu)?;
        }
        self.start_q.copy_from_slice(column(&self.trajectory.q, i));
        let (before, now) = (column(&self.trajectory.sigma, restart.before), column(&self.trajectory.sigma, i));
        let s: Vec<R> = before.iter().zip(now).map(|(&before, &now)| restart.begin(before, now)).collect();
        let at = NodeView { v: &v, sigma: &s, ..self.trajectory.at((&self.inputs, &self.design), i) };
        near.system.plain_sums(&at, &mut self.sums);
        self.start_p.copy_from_slice(self.sums.l_v());
        self.start_sigma.copy_from_slice(&s);
        near.linearisation.evaluation.set_compliance(near.motion.trajectory.compliance_from(i));
        self.solve_node(near, i)
    }

    /// 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0 for q = q⁻ + w, starting from the real solution, by corrections with K(0).
    fn project(&mut self, near: &mut Near, i: usize, nu: &[f64]) -> Result<(), Error> {
        let (system, motion) = (near.system, near.motion);
        let before = column(&self.trajectory.q, i).to_vec();
        let real: Vec<R> = column(&motion.trajectory.q, i).iter().map(|&q| q.into()).collect();
        column_mut(&mut self.trajectory.q, i).copy_from_slice(&real);
        let mut nu: Vec<R> = nu.iter().map(|&nu| nu.into()).collect();
        let mut w: Vec<R> = real.iter().zip(&before).map(|(&q, &before)| q - before).collect();
        let mut phi = vec![R::zero(); nu.len()];
        near.linearisation.evaluation.set_compliance(&motion.shared);
        near.factor(i, 0.0, motion.node_blocks(i))?;
        let mut sizes = vec![Shrinking::new(); R::PARTS];
        for correction in 0..MOST_CORRECTIONS_OF_PROJECTION {
            let at = NodeView { v: &w, sigma: &nu, ..self.trajectory.at((&self.inputs, &self.design), i) };
            system.plain_sums(&at, &mut self.sums);
            system.phi_on(&at, &mut phi);
            for &(j, mu) in near.linearisation.evaluation.compliance() {
                phi[j] -= nu[j] * mu;
            }
            let mut done = true;
            for (part, sizes) in sizes.iter_mut().enumerate() {
                self.part.v.iter_mut().zip(self.sums.l_v()).for_each(|(r, l_v)| *r = -l_v.part(part));
                self.part.sigma.iter_mut().zip(&phi).for_each(|(r, phi)| *r = -phi.part(part));
                near.linearisation.solve(near.system, &mut self.part);
                let size = add_correction(column_mut(&mut self.trajectory.q, i), part, &self.part.v, (0.0, self.unit[part]));
                let size =
                    size.ok_or_else(|| overflow(near, i, "the complex or dual part of the projection onto Φ = 0"))?.of_all;
                w.iter_mut().zip(&self.part.v).for_each(|(w, &delta)| w.add_to_part(part, delta));
                nu.iter_mut().zip(&self.part.sigma).for_each(|(nu, &delta)| nu.add_to_part(part, delta));
                // An input in much larger units may determine the perturbation; corrections that still shrink by a third are not rounding error.
                let shrinks = size < SHRINKING * sizes.last && correction + 1 < MOST_CORRECTIONS_OF_PROJECTION;
                let is_stalled = sizes.is_stalled(Size { of_part: size, of_all: f64::INFINITY });
                done &= correction > 0 && (size <= CONVERGED && !shrinks || is_stalled);
            }
            if done {
                self.rounding = sizes.iter().fold(self.rounding, |rounding, sizes| rounding.max(sizes.last));
                return Ok(());
            }
        }
        Err(self.diverged(
            near,
            i,
            (MOST_CORRECTIONS_OF_PROJECTION, sizes.iter().fold(0.0, |most, sizes| sizes.last.max(most))),
            "the complex or dual part of the projection onto Φ = 0",
        ))
    }
}
