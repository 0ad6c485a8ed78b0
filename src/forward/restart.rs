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

use super::closeness::{UNDETERMINED, closeness};
use super::selection;
use crate::forward::ForwardSweep;
use crate::motion::{column, column_mut};
use crate::node::{Projection, StepFailure};
use crate::number::{larger, largest};
use crate::{Error, Settings, System};

/// If |σ| exceeds this multiple of its largest range, σ is put in the middle of its range again.
const WANDERED: f64 = 2.0;

impl Settings {
    /// True if a motion may be restarted at some node.
    pub(crate) fn may_restart(&self) -> bool {
        self.rebase_every > 0 || self.drift_bound < f64::INFINITY
    }
}

/// Restarts the motion at a node that ends a macro step, if it is due there.
pub(crate) fn apply(forward: &mut ForwardSweep, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
    if !settings.may_restart() && forward.motion.trajectory.compliance.is_empty() {
        return Ok(());
    }
    let Some(steps) = macro_steps(forward, node) else { return Ok(()) };
    let rebase = settings.rebase_every > 0 && steps.is_multiple_of(settings.rebase_every);
    // With a bound of 0.0 at every macro step, even if rounding happens to leave Φ = 0.
    let may_drift = settings.drift_bound < f64::INFINITY && system.m() > 0;
    let project = may_drift && drift(forward, system, node) >= settings.drift_bound;
    let may_leave_out = selection::is_due(forward, node, steps);
    if !(rebase || project || may_leave_out) {
        keep_end(forward, node);
        return Ok(());
    }
    let closeness = closeness(forward, system, node);
    let is_regular = closeness <= UNDETERMINED;
    let leaves_out = may_leave_out && selection::choose(forward, system, node, settings, closeness)?;
    if is_regular && (rebase || project || leaves_out) {
        let result = restart(forward, system, node, project || leaves_out, settings);
        result.map_err(|failure| forward.explain(system, node, failure))?;
        forward.check_compliant(system, node, settings)?;
    }
    keep_end(forward, node);
    Ok(())
}

/// The number of macro steps of the whole motion before a node; `None` if no macro step ends there.
fn macro_steps(forward: &ForwardSweep, node: usize) -> Option<usize> {
    let (inserted, grid) = (&forward.motion.trajectory.inserted, &forward.motion.inputs.grid);
    let before = inserted.partition_point(|&inserted| inserted < node);
    if inserted.get(before) == Some(&node) { None } else { grid.macro_steps(node - before) }
}

/// Stores σ at the end of a macro step for later restarts.
pub(crate) fn keep_end(forward: &mut ForwardSweep, node: usize) {
    forward.restarting.last_end.node = node;
    forward.restarting.last_end.sigma.copy_from_slice(column(&forward.motion.trajectory.sigma, node - forward.motion.first));
}

/// ‖Φ‖∞ at a node.
fn drift(forward: &mut ForwardSweep, system: &System, node: usize) -> f64 {
    let ForwardSweep { motion, stepper, monitor, .. } = forward;
    stepper.newton.linearisation.evaluation.phi_of_node(
        system,
        &motion.at(node),
        motion.node_blocks(node),
        &mut monitor.lengths.phi,
    );
    largest(&monitor.lengths.phi)
}

fn restart(
    forward: &mut ForwardSweep,
    system: &System,
    node: usize,
    project: bool,
    settings: &Settings,
) -> Result<(), StepFailure> {
    let ForwardSweep { motion, stepper, monitor, restarting, .. } = forward;
    let (at, y) = (&mut restarting.point, motion.at(node));
    at.q.copy_from_slice(y.q);
    at.x.v.copy_from_slice(y.v);
    at.x.sigma.fill(0.0);
    if project {
        if stepper.newton.linearisation.evaluation.compliance() != motion.shared {
            // Left-out equations are projected with the others.
            stepper.newton.linearisation.evaluation.set_compliance(&motion.shared);
            let blocks = motion.node_blocks(node);
            stepper.newton.linearisation.factor(system, 0.0, blocks, &mut monitor.report).map_err(StepFailure::Singular)?;
        }
        let (linearisation, lengths) = (&mut stepper.newton.linearisation, &mut monitor.lengths);
        Projection { system, motion, linearisation, report: &mut monitor.report, lengths, node }.apply(at)?;
    }
    record(forward, node, project, settings);
    let anew = forward.motion.trajectory.compliance_from(node);
    forward.stepper.newton.linearisation.evaluation.set_compliance(anew);
    begin_anew(forward, system, node, settings)
}

/// Records the end of the step, and (q, ν) with their blocks from the last evaluation.
fn record(forward: &mut ForwardSweep, node: usize, project: bool, settings: &Settings) {
    let k = node - forward.motion.first;
    let weights = weights(forward, k, settings);
    let at_end = forward.motion.block_column(k, forward.motion.trajectory.last_stage());
    let (restarts, y) = (&mut forward.motion.restarts, forward.motion.trajectory.columns(k));
    restarts.before.push(forward.restarting.last_end.node);
    restarts.weights.push(weights);
    restarts.nodes.push(node);
    restarts.projected.push(project);
    restarts.q.extend_from_slice(y.q);
    restarts.v.extend_from_slice(y.v);
    restarts.p_star_dot.extend_from_slice(y.p_star_dot);
    restarts.sigma.extend_from_slice(y.sigma);
    restarts.step_blocks.extend_from_slice(column(&forward.motion.blocks, at_end));
    // Recorded even without a projection, so that all lists have entries for all restarts.
    restarts.nu.extend_from_slice(&forward.restarting.point.x.sigma);
    restarts.projection_blocks.extend_from_slice(&forward.stepper.newton.linearisation.evaluation.blocks);
    let ends = y.sigma.iter().zip(&forward.restarting.last_end.sigma);
    restarts.begin.extend(ends.map(|(now, before)| weights[0] * now + weights[1] * before));
    forward.motion.trajectory.restarted.push(node);
    forward.monitor.report.restarts += 1;
}

/// Computes p* = T_v(q, v⁻) + Φ_q(q)ᵀ s, then v and σ from it.
fn begin_anew(forward: &mut ForwardSweep, system: &System, node: usize, settings: &Settings) -> Result<(), StepFailure> {
    let ForwardSweep { motion, stepper, monitor, restarting, .. } = forward;
    let (k, at) = (node - motion.first, &mut restarting.point);
    at.x.v.copy_from_slice(column(&motion.trajectory.v, k));
    let begin = motion.restarts.begin.len() - at.x.sigma.len();
    at.x.sigma.copy_from_slice(&motion.restarts.begin[begin..]);
    at.evaluate(system, motion, &mut stepper.newton.linearisation, node, &mut monitor.report);
    motion.restarts.momentum_blocks.extend_from_slice(&stepper.newton.linearisation.evaluation.blocks);
    stepper.set_start(&at.q, &at.left.v, &at.x.sigma);
    column_mut(&mut motion.trajectory.q, k).copy_from_slice(&at.q);
    column_mut(&mut motion.trajectory.sigma, k).copy_from_slice(&at.x.sigma);
    stepper.smooth_from = node;
    forward.solve_node(system, node, 0.0, settings)
}

/// α and β of the restart at column k.
fn weights(forward: &mut ForwardSweep, k: usize, settings: &Settings) -> [f64; 2] {
    if !settings.may_restart() {
        return [0.0, 0.0];
    }
    let every = settings.rebase_every.max(1) as f64;
    let [before, now] = [&forward.restarting.last_end.sigma, column(&forward.motion.trajectory.sigma, k)];
    let weights = &forward.stepper.newton.linearisation.weights;
    let range = weights.of_multipliers(now.iter().zip(before).map(|(now, before)| every * (now - before)));
    let size = weights.of_multipliers(now.iter().copied());
    forward.restarting.most_range = larger(forward.restarting.most_range, range);
    let is_first = forward.motion.trajectory.restarted.is_empty();
    let anew = every == 1.0 || is_first || size > WANDERED * forward.restarting.most_range;
    if anew { [-0.5 * every, 0.5 * every] } else { [-1.0, 0.0] }
}
