//! When a motion is restarted (`event/restart/`), and with which multipliers.

use crate::forward::ForwardSweep;
use crate::motion::{Event, Restart, column};
use crate::number::{larger, largest};
use crate::redundancy::UNDETERMINED;
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
    if !settings.may_restart() && !forward.motion.trajectory.has_dependent() {
        return Ok(());
    }
    let Some(steps) = forward.motion.macro_steps(node) else { return Ok(()) };
    let rebase = settings.rebase_every > 0 && steps.is_multiple_of(settings.rebase_every);
    // With a bound of 0.0 at every macro step, even if rounding happens to leave Φ = 0.
    let may_drift = settings.drift_bound < f64::INFINITY && system.m() > 0;
    let project = may_drift && drift(forward, system, node) >= settings.drift_bound;
    let may_leave_out = forward.dependent(system).is_due(node, steps);
    if !(rebase || project || may_leave_out) {
        keep_end(forward, node);
        return Ok(());
    }
    let mut dependent = forward.dependent(system);
    let closeness = dependent.closeness(node);
    let is_regular = closeness <= UNDETERMINED;
    let leaves_out = may_leave_out && dependent.choose(node, settings, closeness)?;
    if is_regular && (rebase || project || leaves_out) {
        let weights = weights(forward, node - forward.motion.first, settings);
        let restart = Restart { projects: project || leaves_out, before: forward.restarting.last_end.node, weights };
        forward.pass(system, (node, Event::Restart(restart)), settings)?;
    }
    keep_end(forward, node);
    Ok(())
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
    motion.open_from(node).chain(system.held()).for_each(|j| monitor.lengths.phi[j] = 0.0);
    largest(&monitor.lengths.phi)
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
