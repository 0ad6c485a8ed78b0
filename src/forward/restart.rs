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

use super::circuits::Circuits;
use super::projection::Projection;
use super::{Motion, selection};
use crate::forward::ForwardSweep;
use crate::motion::{Report, column, column_mut};
use crate::node::{Newton, StepFailure};
use crate::number::{Real, larger, largest};
use crate::system::{NodeView, Pair};
use crate::{Error, Settings, System};

/// If |σ| exceeds this multiple of its largest range, σ is put in the middle of its range again.
const WANDERED: f64 = 2.0;
/// Above this value of 1/θ there are no restarts: ε/θ² = 2e-4.
pub(super) const UNDETERMINED: f64 = 1e6;

/// The nodes at which a motion was restarted, and the states before the restarts, stored one after another.
#[derive(Default)]
pub(crate) struct Restarts {
    pub(crate) nodes: Vec<usize>,
    /// For each restart, true if Φ = 0 was restored.
    projected: Vec<bool>,
    q: Vec<f64>,
    v: Vec<f64>,
    p_star_dot: Vec<f64>,
    sigma: Vec<f64>,
    nu: Vec<f64>,
    /// The nodes of σ₋.
    before: Vec<usize>,
    /// α and β in s = α σ⁻ + β σ₋, and s.
    weights: Vec<[f64; 2]>,
    begin: Vec<f64>,
    /// Second derivatives at the end of the step, at (q, v⁻, s) and at (q, w, ν).
    step_blocks: Vec<f64>,
    momentum_blocks: Vec<f64>,
    projection_blocks: Vec<f64>,
}

/// One restart.
#[derive(Clone, Copy)]
pub(crate) struct Restart<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) p_star_dot: &'a [f64],
    pub(crate) sigma: &'a [f64],
    /// The node of σ₋.
    pub(crate) before: usize,
    /// α and β in s = α σ⁻ + β σ₋, and s.
    pub(crate) weights: [f64; 2],
    pub(crate) begin: &'a [f64],
    pub(crate) step_blocks: &'a [f64],
    pub(crate) momentum_blocks: &'a [f64],
    /// ν and the second derivatives, if Φ = 0 was restored.
    pub(crate) projection: Option<(&'a [f64], &'a [f64])>,
}

impl Restarts {
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.projected.clear();
        self.before.clear();
        self.weights.clear();
        let lists = [&mut self.q, &mut self.v, &mut self.p_star_dot, &mut self.sigma, &mut self.begin, &mut self.nu];
        let blocks = [&mut self.step_blocks, &mut self.momentum_blocks, &mut self.projection_blocks];
        lists.into_iter().chain(blocks).for_each(Vec::clear);
    }

    /// True if both restart at the same nodes in the same way.
    pub(super) fn are_alike(&self, other: &Restarts) -> bool {
        self.nodes == other.nodes && self.projected == other.projected && self.weights == other.weights
    }

    /// The restart at a node.
    pub(crate) fn at(&self, node: usize) -> Option<Restart<'_>> {
        let which = self.nodes.binary_search(&node).ok()?;
        let count = self.nodes.len();
        let part = |list: &'_ Vec<f64>| {
            let len = list.len() / count;
            which * len..(which + 1) * len
        };
        let of = |list| &(list as &Vec<f64>)[part(list)];
        Some(Restart {
            q: of(&self.q),
            v: of(&self.v),
            p_star_dot: of(&self.p_star_dot),
            sigma: of(&self.sigma),
            before: self.before[which],
            weights: self.weights[which],
            begin: of(&self.begin),
            step_blocks: of(&self.step_blocks),
            momentum_blocks: of(&self.momentum_blocks),
            projection: self.projected[which].then(|| (of(&self.nu), of(&self.projection_blocks))),
        })
    }
}

impl Restart<'_> {
    /// The initial σ, from σ₋ and σ⁻.
    pub(crate) fn begin<R: Real>(&self, before: R, now: R) -> R {
        now * self.weights[0] + before * self.weights[1]
    }
}

/// σ₋: the multipliers at the last end of a macro step, after a restart there.
#[derive(Default)]
pub(crate) struct LastEnd {
    pub(crate) node: usize,
    pub(crate) sigma: Vec<f64>,
}

/// State of the restarts so far that the next one needs.
pub(crate) struct Restarting {
    /// The largest range of σ between two restarts, as estimated so far.
    pub(crate) most_range: f64,
    pub(crate) last_end: LastEnd,
    pub(super) point: Point,
    pub(super) circuits: Circuits,
}

impl Restarting {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Restarting {
            most_range: 0.0,
            last_end: LastEnd { node: 0, sigma: vec![0.0; m] },
            point: Point::new(n, m),
            circuits: Circuits::default(),
        }
    }
}

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

/// Factors K(0) at the end of a step and returns 1/θ, which shows whether p* determines v there to sufficient digits.
///
/// At a distance θ from a configuration at which branches of Φ = 0 cross, such as a flat parallelogram, rounding ε of Φ moves q by ε/θ, and turns the
/// admissible directions of motion by ε/θ². 1/θ is computed as the velocities that violations of dΦ/dt by one unit each cause, in units in which they
/// are about one at the start.
pub(super) fn closeness(forward: &mut ForwardSweep, system: &System, node: usize) -> f64 {
    let worst = forward.monitor.report.worst_pivot;
    let blocks = forward.motion.node_blocks(node);
    if let Err(breakdown) = forward.stepper.newton.factor(system, 0.0, blocks, &mut forward.monitor.report) {
        // Values that are not finite cause an error of the restart.
        return if breakdown.pivot.is_finite() { f64::INFINITY } else { 0.0 };
    }
    forward.warn_of_lost_digits(system, node, worst);
    closeness_here(&mut forward.stepper.newton, system, &mut forward.restarting.point.left)
}

/// Computes 1/θ with the current factors.
pub(super) fn closeness_here(newton: &mut Newton, system: &System, left: &mut Pair) -> f64 {
    left.v.fill(0.0);
    for (j, (violation, weight)) in left.sigma.iter_mut().zip(newton.weights.multipliers()).enumerate() {
        // An arbitrary combination of all equations.
        *violation = weight * (1.0 + 0.3 * (j as f64).sin());
    }
    newton.solve(system, left);
    newton.size_of(&left.v)
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
    stepper.newton.evaluation.phi_of_node(system, &motion.at(node), motion.node_blocks(node), &mut monitor.phi);
    largest(&monitor.phi)
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
        if stepper.newton.evaluation.compliance() != motion.shared {
            // Left-out equations are projected with the others.
            stepper.newton.evaluation.set_compliance(&motion.shared);
            let blocks = motion.node_blocks(node);
            stepper.newton.factor(system, 0.0, blocks, &mut monitor.report).map_err(StepFailure::Singular)?;
        }
        Projection { system, motion, newton: &mut stepper.newton, monitor, node }.apply(at)?;
    }
    record(forward, node, project, settings);
    let anew = forward.motion.trajectory.compliance_from(node);
    forward.stepper.newton.evaluation.set_compliance(anew);
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
    restarts.projection_blocks.extend_from_slice(&forward.stepper.newton.evaluation.blocks);
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
    at.evaluate(system, motion, &mut stepper.newton, node, &mut monitor.report);
    motion.restarts.momentum_blocks.extend_from_slice(&stepper.newton.evaluation.blocks);
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
    let weights = &forward.stepper.newton.weights;
    let range = weights.of_multipliers(now.iter().zip(before).map(|(now, before)| every * (now - before)));
    let size = weights.of_multipliers(now.iter().copied());
    forward.restarting.most_range = larger(forward.restarting.most_range, range);
    let is_first = forward.motion.trajectory.restarted.is_empty();
    let anew = every == 1.0 || is_first || size > WANDERED * forward.restarting.most_range;
    if anew { [-0.5 * every, 0.5 * every] } else { [-1.0, 0.0] }
}

/// A point (q, x), with 𝓛_v and Φ at this point.
pub(crate) struct Point {
    pub(crate) q: Vec<f64>,
    pub(crate) x: Pair,
    pub(crate) left: Pair,
}

impl Point {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Point { q: vec![0.0; n], x: Pair::new(n, m), left: Pair::new(n, m) }
    }

    /// Computes 𝓛_v of the point, at the time and with the controls of a node; the evaluation's blocks then belong to the point.
    pub(super) fn evaluate(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        node: usize,
        report: &mut Report,
    ) {
        let at = NodeView { q: &self.q, v: &self.x.v, sigma: &self.x.sigma, ..motion.at(node) };
        newton.l_v(system, &at, &mut self.left.v, report);
    }
}
