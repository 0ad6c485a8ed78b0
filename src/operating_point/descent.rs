//! The way to a stable equilibrium: steps along the forces, in every motion of the size that its stiffness allows.
//!
//! ```text
//!   δ = Σ (x_iᵀ g) x_i / (max(|κ_i|, ε) + μ)          κ_i, x_i: eigenvalues and eigenvectors of (k + kᵀ)/2
//! ```
//!
//! With |κ_i| the steps leave maxima and saddles, and ε keeps steps of soft motions short. μ grows until the work of the forces during the step is close to that of the linear forces. Near an
//! equilibrium at which all κ_i are positive, Newton's method takes over.

use nalgebra::{DVector, Dyn, SymmetricEigen};

use super::newton::NEUTRAL;
use super::statics::{Balance, Statics};
use crate::Error;
use crate::linear::eigen;

pub(super) const MOST_STEPS: usize = 500;
/// Longest step of one motion, relative to the largest coordinate.
const LONGEST: f64 = 0.5;
/// Newton's method takes over below this step, relative to the largest coordinate …
const CLOSE: f64 = 1e-4;
/// … and a maximum or saddle is left by a step of this size.
const ASIDE: f64 = 1e-2;
/// Smallest and largest μ, relative to the largest stiffness.
const LEAST: f64 = 1e-6;
const MOST: f64 = 1e12;

impl Statics {
    /// The stable equilibrium that is reached along the forces from a configuration, in at most so many steps.
    ///
    /// # Errors
    /// No such equilibrium.
    pub(super) fn descend(&mut self, from: &Balance, most_steps: usize) -> Result<Balance, Error> {
        let (mut here, mut shift) = (self.balance(&from.state)?, 0.0);
        for _ in 0..most_steps {
            let Some(modes) = here.modes() else { return self.newton(&here)?.ok_or_else(|| here.unbalanced()) };
            let soft = (&here.free * &here.force).amax() / (LONGEST * here.size());
            let (least, most) = (modes.eigenvalues.imin(), modes.eigenvalues.amax());
            let (by, predicted) = step(&here, &modes, soft, shift);
            if by.amax() <= CLOSE * here.size() {
                if modes.eigenvalues[least] >= -NEUTRAL * most {
                    if let Some(found) = self.newton(&here)?.filter(Balance::is_stiff) {
                        return Ok(found);
                    }
                } else {
                    let aside = &here.free * modes.eigenvectors.column(least);
                    let length = ASIDE * here.size() / aside.amax();
                    here = self.moved(&here, &(length * aside))?;
                    continue;
                }
            }
            let next = self.moved(&here, &by).ok().map(|next| (next.work_since(&here) / predicted, next));
            let most = most.max(soft);
            match next {
                Some((ratio, next)) if (0.1..10.0).contains(&ratio) => {
                    shift = if (0.5..2.0).contains(&ratio) { 0.1 * shift } else { shift };
                    shift = if shift < LEAST * most { 0.0 } else { shift };
                    here = next;
                }
                _ if shift > MOST * most => break,
                _ => shift = (10.0 * shift).max(1e-2 * most),
            }
        }
        Err(here.unbalanced())
    }
}

/// The step with these ε and μ, and the work of the linear forces during it.
fn step(here: &Balance, modes: &SymmetricEigen<f64, Dyn>, soft: f64, shift: f64) -> (DVector<f64>, f64) {
    let in_modes = modes.eigenvectors.tr_mul(&here.force);
    let stiffness = |kappa: f64| (kappa.abs().max(soft) + shift).max(f64::MIN_POSITIVE);
    let of_modes = in_modes.zip_map(&modes.eigenvalues, |force, kappa| force / stiffness(kappa));
    let of_mode = |i: usize| of_modes[i] * (in_modes[i] - 0.5 * modes.eigenvalues[i] * of_modes[i]);
    (&here.free * (&modes.eigenvectors * &of_modes), (0..in_modes.len()).map(of_mode).sum())
}

impl Balance {
    /// Eigenvalues and eigenvectors of the symmetric part of k; `None` without free motions.
    fn modes(&self) -> Option<SymmetricEigen<f64, Dyn>> {
        let scale = self.scale();
        let mut modes = eigen(0.5 * (&self.stiffness + self.stiffness.transpose()) / scale)?;
        modes.eigenvalues *= scale;
        Some(modes)
    }

    /// True if the symmetric part of k has no negative eigenvalue.
    fn is_stiff(&self) -> bool {
        self.modes().is_none_or(|modes| modes.eigenvalues.min() >= -NEUTRAL * modes.eigenvalues.amax())
    }

    /// The work of the forces on the way from another configuration, by the trapezoidal rule.
    fn work_since(&self, before: &Balance) -> f64 {
        let by = self.state.q().iter().zip(before.state.q()).map(|(q, before)| q - before);
        let forces = self.forces.iter().zip(before.forces.iter()).map(|(force, before)| 0.5 * (force + before));
        by.zip(forces).map(|(by, force)| by * force).sum()
    }
}
