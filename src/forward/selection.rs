//! Selection of the dependent constraints that are left out after their positions have drifted apart.
//!
//! The compliances of `redundancy/compliances.rs` distribute a reaction among dependent constraints. However, once a drift δ of Φ has made the rows of
//! Φ_q independent, the compliances brake the motion: each step reduces its velocity by the fraction δ²/μ. The remedy is to leave out as many
//! equations as follow from the others. They are chosen at the projection of a node onto Φ = 0, where Φ_qᵀz = 0 holds to rounding for each dependency
//! z, one after the other:
//!
//! ```text
//!   leave out the j with the largest share |z_j| √(Φ_q M⁻¹ Φ_qᵀ)_jj:     μ_j = 1e6 (Φ_q diag(M)⁻¹ Φ_qᵀ)_jj
//! ```
//!
//! As the mechanism turns, a left-out equation loses its share in z, and the others become dependent on each other, as an abscissa does at some angle
//! of a bar. Equations are chosen anew before this happens. Each choice is a restart (`event/restart/`), so the gradient through it is exact.
//!
//! Between choices positions are projected at intervals, because left-out equations would drift farther than the others. This also detects equations
//! that begin to contradict the others: the projection violates Φ = 0, or dΦ/dt = 0 there, by μ ν.

use super::ForwardSweep;
use super::closeness::{UNDETERMINED, closeness, closeness_here};
use crate::motion::{Compliances, Motion, Report};
use crate::node::{Linearisation, Projection, StepFailure};
use crate::redundancy::{CONTRADICTION, Circuits, Scaled, left_out, refuse_gaps, root_flexibility, softest};
use crate::system::{Given, KnownPart, NodeView, Sums};
use crate::{Error, Settings, System, Warning};

/// μ of a left-out equation, relative to its previous value.
const LEFT_OUT: f64 = 1e17;
/// If 1/θ is above this, the other equations nearly lose rank too, and positions are projected after every step.
const NEARLY_SINGULAR: f64 = 10.0;
/// If 1/θ is above this, no equations are chosen: the drift, divided by θ, would be worse for v than the drift itself.
const SINGULAR: f64 = 1e3;
/// Distance relative to the largest coordinate: some dependencies are broken only by its third power.
const STRAIGHT_ON: f64 = 0.3;
/// While equations are left out, positions are projected once in this number of steps, or after every macro step: Φ drifts by O(Δt³) in between.
const EVERY: usize = 8;

/// True if equations are to be chosen at a node after `steps` macro steps, or were chosen when the motion reached it before.
pub(super) fn is_due(forward: &ForwardSweep, node: usize, steps: usize) -> bool {
    let motion = &forward.motion;
    if motion.has_been_at(node) {
        return motion.trajectory.compliance.binary_search_by_key(&node, |part| part.from).is_ok();
    }
    if node + 1 == motion.nodes() && !motion.is_growing {
        return false;
    }
    let is_composed = motion.inputs.grid.stages > 1;
    let is_watched = motion.leaves_out() && (is_composed || steps.is_multiple_of(EVERY));
    forward.monitor.brake > 0.0 || forward.monitor.is_urgent || is_watched
}

impl Motion {
    /// True if equations are left out at the current end of the motion.
    pub(crate) fn leaves_out(&self) -> bool {
        self.trajectory.compliance.last().is_some_and(|part| part.equations != self.shared)
    }
}

/// Checks whether left-out equations have lost their share in the dependency, after a step, with the factors and the evaluation at its end.
pub(super) fn watch(forward: &mut ForwardSweep, system: &System, node: usize) {
    let ForwardSweep { motion, stepper, monitor, restarting, .. } = forward;
    if !motion.leaves_out() || motion.has_been_at(node) {
        return;
    }
    let linearisation = &mut stepper.newton.linearisation;
    let is_close = closeness_here(linearisation, system, &mut restarting.point.left) > NEARLY_SINGULAR;
    let chosen = (&motion.shared[..], motion.trajectory.compliance_into(node));
    let are_good = restarting.circuits.are_good(linearisation, system, chosen);
    monitor.is_urgent = is_close || !are_good;
}

/// Chooses the equations that are left out from a node on, with 1/θ = `closeness`; false if the motion is to continue unchanged.
///
/// Restores the factors of K(0) at the node.
#[cold]
pub(super) fn choose(
    forward: &mut ForwardSweep,
    system: &System,
    node: usize,
    settings: &Settings,
    closeness: f64,
) -> Result<bool, Error> {
    if forward.motion.has_been_at(node) {
        return Ok(true);
    }
    // Before anything is left out, large values are caused by the dependencies.
    let most = if forward.motion.leaves_out() { SINGULAR } else { UNDETERMINED };
    let Some(chosen) = (if closeness <= most { look(forward, system, node, settings)? } else { None }) else {
        forward.warn_of_brake(node);
        return Ok(false);
    };
    (forward.monitor.brake, forward.monitor.is_urgent) = (0.0, false);
    if !forward.motion.leaves_out() {
        let (step, time) = (forward.motion.step_of_whole(node), forward.motion.time(node));
        let equations = names(system, &chosen, &forward.motion.shared);
        forward.monitor.report.warn(Warning::LeftOut { equations, step, time });
    }
    forward.motion.set_compliance(node, chosen);
    Ok(true)
}

/// Returns an error if equations have begun to contradict each other since the last choice, at the end of a motion.
pub(super) fn look_at_end(forward: &mut ForwardSweep, system: &System, settings: &Settings) -> Result<(), Error> {
    let last = forward.motion.nodes() - 1;
    if !forward.motion.leaves_out() || forward.motion.has_been_at(last) || closeness(forward, system, last) > SINGULAR {
        return Ok(());
    }
    look(forward, system, last, settings).map(|_| ())
}

/// The equations that are left out from the start on, if dependencies do not persist along a straight motion that leaves the constraints. Parallel
/// cranks remain parallel and drift alike, and so do doubled hinges.
pub(super) fn at_start(
    forward: &mut ForwardSweep,
    system: &System,
    at: &NodeView<f64>,
    (shared, scaled): (&Compliances, &Scaled),
) -> Option<Vec<(usize, f64)>> {
    let q = scaled.aside(at, STRAIGHT_ON);
    let (linearisation, circuits) = (&mut forward.stepper.newton.linearisation, &mut forward.restarting.circuits);
    let mut select_at = |q: &[f64]| {
        let from = KnownPart { h: 0.0, q, p_star: &[], sigma: at.sigma };
        linearisation.evaluation.set_compliance(shared);
        linearisation.factor_at(system, &from, Given::from(*at), (at.v, at.sigma), &mut Report::default()).ok()?;
        select(linearisation, system, circuits, (shared, shared), &mut Report::default())
    };
    let (aside, here) = (select_at(q.as_slice())?, select_at(at.q)?);
    (left_out(&aside, shared).count() < left_out(&here, shared).count()).then_some(here)
}

/// The names of the left-out equations.
pub(super) fn names(system: &System, chosen: &Compliances, shared: &Compliances) -> Vec<String> {
    left_out(chosen, shared).map(|k| system.equation_name(shared[k].0).to_string()).collect()
}

/// The best choice of left-out equations from a node on; `None` if there is none.
fn look(
    forward: &mut ForwardSweep,
    system: &System,
    node: usize,
    settings: &Settings,
) -> Result<Option<Vec<(usize, f64)>>, Error> {
    let now = forward.motion.trajectory.compliance_into(node).to_vec();
    let is_projected = project(forward, system, node, settings)?;
    let ForwardSweep { motion, stepper, monitor, restarting, .. } = &mut *forward;
    let of = (&motion.shared[..], &now[..]);
    let select = || select(&mut stepper.newton.linearisation, system, &mut restarting.circuits, of, &mut monitor.report);
    let chosen = is_projected.then(select).flatten();
    let (linearisation, blocks) = (&mut forward.stepper.newton.linearisation, forward.motion.node_blocks(node));
    linearisation.evaluation.set_compliance(&now);
    let restored = linearisation.factor(system, 0.0, blocks, &mut forward.monitor.report);
    Ok(chosen.filter(|chosen| restored.is_ok() && *chosen != forward.motion.shared))
}

/// Evaluates all terms at the projection of a node onto all equations; an error if equations contradict each other there, false if it fails.
fn project(forward: &mut ForwardSweep, system: &System, node: usize, settings: &Settings) -> Result<bool, Error> {
    let ForwardSweep { motion, stepper, monitor, restarting, .. } = forward;
    let (linearisation, at, y) = (&mut stepper.newton.linearisation, &mut restarting.point, motion.at(node));
    linearisation.evaluation.set_compliance(&motion.shared);
    if linearisation.factor(system, 0.0, motion.node_blocks(node), &mut monitor.report).is_err() {
        return Ok(false);
    }
    at.q.copy_from_slice(y.q);
    at.x.v.copy_from_slice(y.v);
    at.x.sigma.fill(0.0);
    let (report, lengths) = (&mut monitor.report, &mut monitor.lengths);
    let projected = Projection { system, motion, linearisation, report, lengths, node }.apply(at);
    let size = linearisation.size_of(&at.q);
    // If equations contradict each other, ν is so large that its rounding moves q slightly.
    let is_close = match projected {
        Ok(()) => true,
        Err(StepFailure::Projection { .. }) => linearisation.size_of(&at.left.v) <= CONTRADICTION * size,
        Err(_) => false,
    };
    if is_close {
        let nu = (&motion.shared[..], |j: usize| at.x.sigma[j]);
        refuse_gaps(system, &NodeView { q: &at.q, ..motion.at(node) }, nu, (settings.position_tolerance, size))?;
    }
    if projected.is_err() || linearisation.factor_here(system, 0.0, &mut monitor.report).is_err() {
        return Ok(false);
    }
    // The part of dΦ/dt that no velocities can satisfy: dΦ/dt = μ σ with the smallest correction of v.
    let here = NodeView { q: &at.q, ..motion.at(node) };
    let mut sums = Sums::new(system.n(), system.m());
    system.plain_sums(&here, &mut sums);
    at.left.v.fill(0.0);
    at.left.sigma.iter_mut().zip(sums.phi_dot()).for_each(|(left, phi_dot)| *left = -phi_dot);
    linearisation.solve(system, &mut at.left);
    let within = (settings.velocity_tolerance, linearisation.size_of(here.v));
    refuse_gaps(system, &here, (&motion.shared, |j| at.left.sigma[j]), within)?;
    Ok(true)
}

/// Leaves out one equation for each dependency at the point of the last evaluation: the one left out before if it still has its share, otherwise the
/// one with the largest share.
pub(super) fn select(
    linearisation: &mut Linearisation,
    system: &System,
    circuits: &mut Circuits,
    (shared, now): (&Compliances, &Compliances),
    report: &mut Report,
) -> Option<Vec<(usize, f64)>> {
    let mut chosen = now.to_vec();
    linearisation.evaluation.set_compliance(&chosen);
    let is_regular = linearisation.factor_here(system, 0.0, report).is_ok();
    let are_good = is_regular && circuits.are_good(linearisation, system, (shared, now));
    if !is_regular || !circuits.are_dependent() {
        chosen.copy_from_slice(shared);
    } else if !are_good {
        circuits.exchange(shared, &mut chosen, LEFT_OUT);
    }
    if chosen != now {
        linearisation.evaluation.set_compliance(&chosen);
        linearisation.factor_here(system, 0.0, report).ok()?;
    }
    let mut roots = vec![0.0; system.m()];
    shared.iter().for_each(|&(j, mu)| roots[j] = root_flexibility(mu));
    while let Some(shares) = softest(linearisation, system, &roots) {
        let share = |k: usize| if chosen[k] == shared[k] { shares[shared[k].0].abs() } else { 0.0 };
        let most = (0..shared.len()).max_by(|&a, &b| share(a).total_cmp(&share(b)))?;
        if share(most) == 0.0 {
            return None;
        }
        chosen[most].1 *= LEFT_OUT;
        linearisation.evaluation.set_compliance(&chosen);
        linearisation.factor_here(system, 0.0, report).ok()?;
    }
    Some(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::Body;
    use crate::redundancy::compliances;
    use crate::{Grid, Inputs, Scene};

    /// Two cranks of a parallelogram at 1 rad and their coupler, which a third crank at its middle makes dependent.
    fn parallelogram(cranks: usize) -> System {
        let mut scene = Scene::new();
        let (x, y) = (1.0f64.cos(), 1.0f64.sin());
        let coupler = scene.body("coupler", 1.0, 0.1, [x + 1.0, y, 0.0]);
        for (k, along) in [0.0, 2.0, 1.0].into_iter().enumerate().take(cranks) {
            let crank = scene.body(&format!("crank {k}"), 1.0, 0.1, [along + 0.5 * x, 0.5 * y, 1.0]);
            scene.revolute(&format!("foot {k}"), Body::GROUND.at(along, 0.0), crank.at(-0.5, 0.0));
            scene.revolute(&format!("head {k}"), crank.at(0.5, 0.0), coupler.at(along - 1.0, 0.0));
        }
        scene.compile().expect("a scene")
    }

    #[test]
    fn what_does_not_depend_on_others_any_more_is_put_back() {
        for (cranks, dependencies) in [(2, 0), (3, 1)] {
            let system = parallelogram(cranks);
            let mut forward = ForwardSweep::new(&system, crate::Scheme::TRAPEZOIDAL);
            forward.run(&system, &Inputs::at_rest(&system, Grid::uniform(1, 0.01)), &Settings::default()).expect("a step");
            let ForwardSweep { motion, stepper, monitor, .. } = &mut forward;
            let (linearisation, at) = (&mut stepper.newton.linearisation, motion.at(0));
            let shared = compliances(linearisation, &system, &at);
            // Leaves out each equation of the loops in turn, though at most one of them follows from the others.
            for k in 0..shared.len() {
                let mut now = shared.clone();
                now[k].1 *= LEFT_OUT;
                let from = KnownPart { h: 0.0, q: at.q, p_star: &[], sigma: at.sigma };
                linearisation
                    .factor_at(&system, &from, Given::from(at), (at.v, at.sigma), &mut monitor.report)
                    .expect("K(0)");
                let of = (&shared[..], &now[..]);
                let chosen =
                    select(linearisation, &system, &mut Circuits::default(), of, &mut monitor.report).expect("a choice");
                let count = left_out(&chosen, &shared).count();
                assert_eq!(count, dependencies, "{} left out: {:?}", system.equation_name(shared[k].0), chosen);
            }
            assert!(!shared.is_empty() && shared.iter().all(|(_, mu)| root_flexibility(*mu) > 0.0));
        }
    }
}
