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

use super::circuits::{Circuits, left_out};
use super::closeness::{UNDETERMINED, closeness_here};
use super::compliances::{CONTRADICTION, refuse_gaps, root_flexibility, softest};
use super::dependent::Dependent;
use super::rank::Scaled;
use crate::motion::{Compliances, Motion, Report, closed, open};
use crate::node::{Linearisation, Projection, StepFailure};
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

impl Motion {
    /// True if equations are left out at the current end of the motion.
    pub(crate) fn leaves_out(&self) -> bool {
        self.trajectory.compliance.last().is_some_and(|part| {
            let is_closed = |(j, _): &(usize, f64)| open(&part.equations).all(|open| open != *j);
            !closed(&part.equations).eq(closed(&self.shared).filter(is_closed))
        })
    }
}

impl Dependent<'_> {
    /// True if equations are to be chosen at a node after `steps` macro steps, or were chosen when the motion reached it before.
    pub(crate) fn is_due(&self, node: usize, steps: usize) -> bool {
        let motion = &self.motion;
        if motion.has_been_at(node) {
            return motion.trajectory.compliance.binary_search_by_key(&node, |part| part.from).is_ok();
        }
        if node + 1 == motion.nodes() && !motion.is_growing {
            return false;
        }
        let is_composed = motion.inputs.grid.stages > 1;
        let is_watched = motion.leaves_out() && (is_composed || steps.is_multiple_of(EVERY));
        self.state.losses.brake > 0.0 || self.state.losses.is_urgent || is_watched
    }

    /// Checks dependent constraints in the step that ends at a node, with the factors and the evaluation at its end: the energy that compliances absorb,
    /// and whether left-out equations have lost their share in the dependency.
    pub(crate) fn watch(&mut self, node: usize) {
        self.watch_brake(node);
        let Dependent { system, motion, linearisation, point, state, .. } = self;
        if !motion.leaves_out() || motion.has_been_at(node) {
            return;
        }
        let is_close = closeness_here(linearisation, system, &mut point.left) > NEARLY_SINGULAR;
        let shared = motion.compliance_of_projection(system, node);
        let chosen = (&shared[..], motion.trajectory.compliance_into(node));
        let are_good = state.circuits.are_good(linearisation, system, chosen);
        state.losses.is_urgent = is_close || !are_good;
    }

    /// Chooses the equations that are left out from a node on, with 1/θ = `closeness`; false if the motion is to continue unchanged.
    ///
    /// Restores the factors of K(0) at the node.
    #[cold]
    pub(crate) fn choose(&mut self, node: usize, settings: &Settings, closeness: f64) -> Result<bool, Error> {
        if self.motion.has_been_at(node) {
            return Ok(true);
        }
        // Before anything is left out, large values are caused by the dependencies.
        let most = if self.motion.leaves_out() { SINGULAR } else { UNDETERMINED };
        let Some(chosen) = (if closeness <= most { self.look(node, settings)? } else { None }) else {
            self.warn_of_brake(node);
            return Ok(false);
        };
        (self.state.losses.brake, self.state.losses.is_urgent) = (0.0, false);
        if !self.motion.leaves_out() {
            let (step, time) = (self.motion.step_of_whole(node), self.motion.time(node));
            let equations = names(self.system, &chosen, &self.motion.compliance_of_projection(self.system, node));
            self.report.warn(Warning::LeftOut { equations, step, time });
        }
        self.motion.set_compliance(node, chosen);
        Ok(true)
    }

    /// Returns an error if equations have begun to contradict each other since the last choice, at the end of a motion.
    pub(crate) fn look_at_end(&mut self, settings: &Settings) -> Result<(), Error> {
        let last = self.motion.nodes() - 1;
        if !self.motion.leaves_out() || self.motion.has_been_at(last) || self.closeness(last) > SINGULAR {
            return Ok(());
        }
        self.look(last, settings).map(|_| ())
    }

    /// The equations that are left out from the start on, if dependencies do not persist along a straight motion that leaves the constraints. Parallel
    /// cranks remain parallel and drift alike, and so do doubled hinges.
    pub(super) fn select_at_start(
        &mut self,
        at: &NodeView<f64>,
        (shared, scaled): (&Compliances, &Scaled),
    ) -> Option<Vec<(usize, f64)>> {
        let q = scaled.aside(at, STRAIGHT_ON);
        let Dependent { system, linearisation, state, .. } = self;
        let mut select_at = |q: &[f64]| {
            let from = KnownPart { h: 0.0, q, p_star: &[], sigma: at.sigma };
            linearisation.evaluation.set_compliance(shared);
            linearisation.factor_at(system, &from, Given::from(*at), (at.v, at.sigma), &mut Report::default()).ok()?;
            select(linearisation, system, &mut state.circuits, (shared, shared), &mut Report::default())
        };
        let (aside, here) = (select_at(q.as_slice())?, select_at(at.q)?);
        (left_out(&aside, shared).count() < left_out(&here, shared).count()).then_some(here)
    }

    /// The best choice of left-out equations from a node on; `None` if there is none.
    fn look(&mut self, node: usize, settings: &Settings) -> Result<Option<Vec<(usize, f64)>>, Error> {
        let now = self.motion.trajectory.compliance_into(node).to_vec();
        let is_projected = self.project(node, settings)?;
        let Dependent { system, motion, linearisation, report, state, .. } = self;
        let shared = motion.compliance_of_projection(system, node);
        let of = (&shared[..], &now[..]);
        let chosen = is_projected.then(|| select(linearisation, system, &mut state.circuits, of, report)).flatten();
        linearisation.evaluation.set_compliance(&now);
        let restored = linearisation.factor(system, 0.0, motion.node_blocks(node), report);
        Ok(chosen.filter(|chosen| restored.is_ok() && *chosen != *shared))
    }

    /// Evaluates all terms at the projection of a node onto all equations; an error if equations contradict each other there, false if it fails.
    fn project(&mut self, node: usize, settings: &Settings) -> Result<bool, Error> {
        let Dependent { system, motion, linearisation, report, lengths, point: at, .. } = self;
        let y = motion.at(node);
        let shared = motion.compliance_of_projection(system, node);
        linearisation.evaluation.set_compliance(&shared);
        if linearisation.factor(system, 0.0, motion.node_blocks(node), report).is_err() {
            return Ok(false);
        }
        at.q.copy_from_slice(y.q);
        at.x.v.copy_from_slice(y.v);
        at.x.sigma.fill(0.0);
        let projected = Projection { system, motion, linearisation, report, lengths, node }.apply(at);
        let size = linearisation.size_of(&at.q);
        // If equations contradict each other, ν is so large that its rounding moves q slightly.
        let is_close = match projected {
            Ok(()) => true,
            Err(StepFailure::Projection { .. }) => linearisation.size_of(&at.left.v) <= CONTRADICTION * size,
            Err(_) => false,
        };
        if is_close {
            let nu = (&shared[..], |j: usize| at.x.sigma[j]);
            refuse_gaps(system, &NodeView { q: &at.q, ..motion.at(node) }, nu, (settings.position_tolerance, size))?;
        }
        if projected.is_err() || linearisation.factor_here(system, 0.0, report).is_err() {
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
        refuse_gaps(system, &here, (&shared, |j| at.left.sigma[j]), within)?;
        Ok(true)
    }
}

/// The names of the left-out equations.
pub(super) fn names(system: &System, chosen: &Compliances, shared: &Compliances) -> Vec<String> {
    left_out(chosen, shared).map(|k| system.equation_name(shared[k].0).to_string()).collect()
}

/// Leaves out one equation for each dependency at the point of the last evaluation: the one left out before if it still has its share, otherwise the
/// one with the largest share.
fn select(
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
    use crate::forward::ForwardSweep;
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
