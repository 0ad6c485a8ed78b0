//! The compliances of a motion with dependent constraints (`redundancy/compliances.rs`): their choice at the start, and the gaps and the loss of energy
//! that they cause.

use super::selection;
use crate::forward::ForwardSweep;
use crate::number::larger;
use crate::redundancy::{Relaxed, Scaled, apparent_masses, designs, flexibilities, of_loops, refuse_gaps, softest};
use crate::system::NodeView;
use crate::{Error, Settings, System, Warning};

/// Violations of dΦ/dt = 0 smaller than this (m/s or rad/s) come from the load that dependent constraints share, not from drift, and are ignored.
const LOAD: f64 = 1e-9;
/// Loss of kinetic energy by compliances in all steps, relative to the largest one, above which equations are left out.
const BRAKE: f64 = 1e-9;
/// An equation takes part in a dependency if its share in the softest combination is above this.
const SHARE: f64 = 1e-5;

/// Gives loops a compliance if this makes K(0) at the start regular, leaves out equations that would drift apart, and warns of dependent equations.
///
/// The last evaluation must be at the start. Without success nothing is changed.
pub(crate) fn relax(forward: &mut ForwardSweep, system: &System, at: &NodeView<f64>, scaled: Option<&Scaled>) -> bool {
    let masses = apparent_masses(&forward.stepper.newton.linearisation, system, at);
    let flexibility = flexibilities(system, at, &masses);
    let shared = of_loops(system, &flexibility);
    if shared.is_empty() {
        return false;
    }
    forward.stepper.newton.linearisation.evaluation.set_compliance(&shared);
    let roots: Vec<f64> = flexibility.iter().map(|s| s.sqrt()).collect();
    let soft =
        forward.factor_start(system).ok().and_then(|()| softest(&mut forward.stepper.newton.linearisation, system, &roots));
    let Some(shares) = soft else {
        forward.stepper.newton.linearisation.evaluation.set_compliance(&[]);
        return false;
    };
    let takes_part = |j: &usize| shares[*j].abs() > SHARE;
    let dependent: Vec<usize> = (0..system.m()).filter(takes_part).collect();
    let names = |equations: &[usize]| equations.iter().map(|&j| system.equation_name(j).to_string()).collect();
    let mut warnings = vec![Warning::DependentConstraints { equations: names(&dependent), time: at.t }];
    let chosen = scaled.and_then(|scaled| selection::at_start(forward, system, at, (&shared, scaled)));
    if let Some(chosen) = &chosen {
        let equations = selection::names(system, chosen, &shared);
        warnings.push(Warning::LeftOut { equations, step: 0, time: at.t });
    }
    let z: Vec<f64> = (0..system.m()).map(|j| if takes_part(&j) { shares[j] / roots[j] } else { 0.0 }).collect();
    let breaking = if system.designs() > 0 {
        // Factor again, because the choice above replaces the factors.
        forward.stepper.newton.linearisation.evaluation.set_compliance(&shared);
        let factored = forward.factor_start(system);
        factored.map(|()| designs(system, &mut forward.stepper.newton.linearisation, at, (&z, &masses))).unwrap_or_default()
    } else {
        Vec::new()
    };
    if !breaking.is_empty() {
        let designs = breaking.into_iter().map(|b| system.design_name(b).to_string()).collect();
        warnings.push(Warning::BrokenDependence { designs, equations: names(&dependent), time: at.t });
    }
    let (costs, read) = system.costs_of_multipliers(&dependent);
    if chosen.is_none() && !costs.is_empty() {
        let costs = costs.into_iter().map(str::to_string).collect();
        warnings.push(Warning::SharedReaction { costs, equations: names(&read) });
    }
    let (q, design) = (at.q.to_vec(), at.design.to_vec());
    let compliance = chosen.unwrap_or_else(|| shared.clone());
    forward.relaxed = Some(Relaxed { q, design, time: at.t, shared, compliance, warnings });
    relax_again(forward, system, at.q)
}

/// Uses the results of `relax` at the same start, now or before; false if there are none.
pub(crate) fn relax_again(forward: &mut ForwardSweep, system: &System, q: &[f64]) -> bool {
    let time = forward.motion.trajectory.times[0];
    let design = &forward.motion.design;
    let is_same = |known: &Relaxed| known.q == q && known.design == *design && known.time == time;
    let Some(known) = forward.relaxed.take().filter(is_same) else { return false };
    forward.stepper.newton.linearisation.evaluation.set_compliance(&known.compliance);
    let regular = forward.factor_start(system).is_ok();
    if regular {
        forward.motion.shared.clone_from(&known.shared);
        forward.motion.set_compliance(0, known.compliance.clone());
        known.warnings.iter().for_each(|warning| forward.monitor.report.warn(warning.clone()));
        forward.relaxed = Some(known);
    } else {
        forward.stepper.newton.linearisation.evaluation.set_compliance(&[]);
    }
    regular
}

/// Computes the weights of unknowns and equations from K(0) at the start, with nothing left out.
pub(crate) fn weigh(forward: &mut ForwardSweep, system: &System) {
    if !forward.motion.leaves_out() {
        return forward.stepper.newton.linearisation.weigh(system);
    }
    let chosen = forward.motion.trajectory.compliance_from(0).to_vec();
    forward.stepper.newton.linearisation.evaluation.set_compliance(&forward.motion.shared);
    if forward.factor_start(system).is_ok() {
        forward.stepper.newton.linearisation.weigh(system);
    }
    forward.stepper.newton.linearisation.evaluation.set_compliance(&chosen);
}

impl ForwardSweep {
    /// Returns an error if dependent constraints cannot be satisfied together, so that their compliances have gaps.
    pub(crate) fn check_compliant(&self, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
        if self.motion.trajectory.compliance.is_empty() { Ok(()) } else { self.compare_gaps(system, node, settings) }
    }

    #[cold]
    fn compare_gaps(&self, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
        let (at, linearisation) = (self.motion.at(node), &self.stepper.newton.linearisation);
        let sigma = |j: usize| at.sigma[j] - self.stepper.start_sigma[j];
        let within = (settings.velocity_tolerance, linearisation.size_of(at.v));
        refuse_gaps(system, &at, (linearisation.evaluation.compliance(), sigma), within)
    }

    /// Measures the energy that compliances absorb, μ Δσ² in a stage, if positions have drifted so that dependent constraints block the motion.
    pub(super) fn watch_brake(&mut self, system: &System, node: usize) {
        let (motion, start) = (&self.motion, &self.stepper.start_sigma);
        if motion.trajectory.compliance.is_empty() {
            return;
        }
        let of_stage = |stage: usize| {
            let at = motion.at_stage(node, stage);
            let gaps = self
                .stepper
                .newton
                .linearisation
                .evaluation
                .compliance()
                .iter()
                .map(|&(j, mu)| (mu * (at.sigma[j] - start[j]), mu));
            gaps.filter(|(gap, _)| gap.abs() > LOAD).map(|(gap, mu)| gap * gap / mu).sum()
        };
        let taken = (1..=motion.trajectory.last_stage()).map(of_stage).fold(0.0, larger);
        let all = taken * (motion.nodes() - 1) as f64;
        if all <= BRAKE * self.monitor.most_kinetic {
            return;
        }
        self.monitor.most_kinetic = larger(self.monitor.most_kinetic, system.energies(&motion.at(node))[0]);
        self.monitor.brake = larger(self.monitor.brake, all / self.monitor.most_kinetic);
    }

    /// Warns of the energy that compliances absorbed up to a node, since nothing can be left out there.
    pub(super) fn warn_of_brake(&mut self, node: usize) {
        let share = std::mem::take(&mut self.monitor.brake);
        if share > self.monitor.most_braked {
            self.monitor.most_braked = share;
            let (step, time) = (self.motion.step_of_whole(node), self.motion.time(node));
            self.monitor.report.replace(Warning::Braked { step, time, share });
        }
    }
}
