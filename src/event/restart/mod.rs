//! Restarts within a motion: the position constraints are satisfied again, and the multipliers begin anew.
//!
//! The paper's scheme satisfies dΦ/dt = 0 to rounding and lets Φ drift with O(Δt²). Moreover, |σ| grows like ∫λ dt, so that p* = M v + Φ_qᵀσ loses
//! digits in long motions. A restart replaces the state (q⁻, v⁻) at the end of a macro step (of any step, on grids that are not composed) by
//!
//! ```text
//!   projection   q = q⁻ + w  with  M(q) w + Φ_q(q)ᵀ ν = 0,  Φ(q, t) = 0        (only if Φ is to be satisfied, and then all of it)
//!   rebasing     p* = T_v(q, v⁻) + Φ_q(q)ᵀ s,   then v and σ from Eq. (1a) and (1c)
//! ```
//!
//! as for a start at node 0. A macro step of order k from any (q, p*) leaves Φ = O(Δt^(k+1)), and no projection moves it farther; a different p*
//! belongs to the same (q, v), from which the next macro step has the same order. The motion therefore keeps the order k of its
//! [`Composition`](crate::Composition), 2, 4 or 6, for any number of restarts. This would not hold between the stages of a macro step: their errors,
//! O(Δt³) each, cancel only without a restart in between.
//!
//! **Initial σ.** With s = 0, σ would run from 0 to its range R = ∫λ dt until the next restart, r macro steps later. If σ runs from −½ R to ½ R
//! instead, a motion is the same forward and backward in time, and its energy does not drift. The r macro steps S and the reversal ρ: (v, σ) → (−v,
//! −σ) satisfy ρ S ρ = S⁻¹; with F: σ → −σ, F S satisfies this equation with ρ F in place of ρ:
//!
//! ```text
//!   ρ S ρ = S⁻¹,  F F = 1,  ρ F = F ρ      ⟹      (ρF) (F S) (ρF) = S⁻¹ F = (F S)⁻¹
//! ```
//!
//! Hence s = −σ⁻ is reversible for any r and σ, once the first restart has put σ in the middle of its range:
//!
//! ```text
//!   s = −½ r (σ⁻ − σ₋)     for r = 1, at the first restart, and where |σ⁻| is twice all r |σ⁻ − σ₋| so far     (σ₋: a macro step before)
//!   s = −σ⁻                at all others
//! ```
//!
//! For r = 1 both are equal to O(Δt²), and the first does not depend on the past. The second does: forces that change at random make the middle of σ
//! drift in proportion to the square root of time, hence the bound on |σ⁻|. The projection is 𝓛_v(q, w, ν) = 0 for a kinetic energy that is quadratic
//! in v, so the same elements evaluate it. The adjoint equations of a restart, with Ĵ_q, π for dJ/dq and dJ/dp* of the restarted motion, are
//!
//! ```text
//!   Ĵ_q += 𝓛_vqᵀ π      dJ/dv⁻ = 𝓛_vvᵀ π      dJ/ds = Φ_q π      at (q, v⁻, s),   s = α σ⁻ + β σ₋
//!   (𝓛_vv + 𝓛_vq)ᵀ c + Φ_qᵀ e = −Ĵ_q,      Φ_q c = 0,      dJ/dq⁻ = −𝓛_vvᵀ c      at (q, w, ν)
//! ```

mod along;
mod backward;
mod forward;
mod lifted;

use super::{Along, Backward, BackwardAlong, Forward, ResetMap};
use crate::linear::Breakdown;
use crate::motion::{Happened, Motion, Report, Restart, Trajectory};
use crate::node::StepFailure;
use crate::number::Real;

impl ResetMap for Restart {
    fn forward(&self, of: Forward) -> Result<(), StepFailure> {
        forward::reset(self, of)
    }

    fn monitor(&self, node: usize, trajectory: &mut Trajectory, report: &mut Report) {
        trajectory.restarted.push(node);
        report.restarts += 1;
    }

    fn backward(&self, of: &mut Backward) -> Result<(), Breakdown> {
        backward::momentum(self, of);
        backward::projection(self, of, None)
    }

    fn along(&self, of: Along) -> Result<(), Breakdown> {
        along::reset(self, of)
    }

    fn backward_along(&self, of: BackwardAlong) -> Result<(), Breakdown> {
        along::backward(self, of)
    }
}

/// What the forward sweep stores of a restart.
struct Numbers<'a> {
    /// ν, and the second derivatives at (q, w, ν), if Φ = 0 was restored.
    projection: Option<OfPoint<'a>>,
    /// s, and the second derivatives at (q, v⁻, s).
    momentum: OfPoint<'a>,
}

/// Multipliers, and the second derivatives at a point.
#[derive(Clone, Copy)]
struct OfPoint<'a> {
    sigma: &'a [f64],
    blocks: &'a [f64],
}

impl Restart {
    /// s = α σ⁻ + β σ₋.
    fn begin<R: Real>(&self, before: R, now: R) -> R {
        now * self.weights[0] + before * self.weights[1]
    }

    fn numbers<'a>(&self, happened: &Happened<'a>) -> Numbers<'a> {
        let of_point = |numbers: &'a [f64]| {
            let (sigma, blocks) = numbers.split_at(happened.end.sigma.len());
            OfPoint { sigma, blocks }
        };
        let len = if self.projects { happened.numbers.len() / 2 } else { 0 };
        let (projection, momentum) = happened.numbers.split_at(len);
        Numbers { projection: self.projects.then(|| of_point(projection)), momentum: of_point(momentum) }
    }
}

/// w, the displacement of a node by a projection.
fn set_displacement(motion: &Motion, happened: &Happened, w: &mut [f64]) {
    let moved = motion.at(happened.node).q.iter().zip(happened.end.q);
    w.iter_mut().zip(moved).for_each(|(w, (q, before))| *w = q - before);
}

/// True if the corrections with 𝓛_vqᵀ (which decrease in proportion to the drift) consist of rounding errors and do not merely converge slowly.
fn is_rounding(correction: f64, last: f64, size: f64) -> bool {
    correction <= 1e-16 * size || correction >= 0.5 * last && correction <= 1e-13 * size
}
