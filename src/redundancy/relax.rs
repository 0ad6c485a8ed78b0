//! The compliances of a motion with dependent constraints (`redundancy/compliances.rs`): their choice at the start, and the gaps and the loss of energy
//! that they cause.

use super::breaking::designs;
use super::compliances::{Relaxed, SUSPICIOUS, apparent_masses, flexibilities, of_loops, softest, sufficient};
use super::dependent::Dependent;
use super::rank::Scaled;
use super::selection::names;
use crate::Warning;
use crate::motion::{Compliances, OPEN, closed, open, with_open};
use crate::number::larger;
use crate::system::NodeView;

/// Violations of dΦ/dt = 0 smaller than this (m/s or rad/s) come from the load that dependent constraints share, not from drift, and are ignored.
const LOAD: f64 = 1e-9;
/// Loss of kinetic energy by compliances in all steps, relative to the largest one, above which equations are left out.
const BRAKE: f64 = 1e-9;
/// An equation takes part in a dependency if its share in the softest combination is above this.
const SHARE: f64 = 1e-5;

impl Dependent<'_> {
    /// Gives loops a compliance if this makes K(0) at the start regular, leaves out equations that would drift apart, and warns of dependent equations.
    ///
    /// The last evaluation must be at the start. Without success nothing is changed.
    pub(crate) fn relax(&mut self, at: &NodeView<f64>, scaled: Option<&Scaled>) -> bool {
        let system = self.system;
        let masses = apparent_masses(self.linearisation, system, at);
        let flexibility = flexibilities(system, at, &masses);
        let open: Vec<usize> = self.motion.open_from(0).collect();
        let all = with_open(&of_loops(system, &flexibility), &open);
        if all.is_empty() {
            return false;
        }
        let shared = sufficient(all, (system, at), |compliances| {
            self.report.worst_pivot = 1.0;
            self.linearisation.evaluation.set_compliance(compliances);
            self.factor_start().is_ok() && self.report.worst_pivot > SUSPICIOUS
        });
        self.linearisation.evaluation.set_compliance(&shared);
        let roots: Vec<f64> = flexibility.iter().map(|s| s.sqrt()).collect();
        let soft = self.factor_start().ok().and_then(|()| softest(self.linearisation, system, &roots));
        let Some(shares) = soft else {
            self.linearisation.evaluation.set_compliance(self.motion.trajectory.compliance_from(0));
            return false;
        };
        let takes_part = |j: &usize| shares[*j].abs() > SHARE;
        let dependent: Vec<usize> = (0..system.m()).filter(takes_part).collect();
        let names_of = |equations: &[usize]| equations.iter().map(|&j| system.equation_name(j).to_string()).collect();
        let mut warnings = vec![Warning::DependentConstraints { equations: names_of(&dependent), time: at.t }];
        let chosen = scaled.and_then(|scaled| self.select_at_start(at, (&shared, scaled)));
        if let Some(chosen) = &chosen {
            warnings.push(Warning::LeftOut { equations: names(system, chosen, &shared), step: 0, time: at.t });
        }
        let z: Vec<f64> = (0..system.m()).map(|j| if takes_part(&j) { shares[j] / roots[j] } else { 0.0 }).collect();
        let breaking = self.breaking_designs(at, &shared, (&z, &masses));
        if !breaking.is_empty() {
            let designs = breaking.into_iter().map(|b| system.design_name(b).to_string()).collect();
            warnings.push(Warning::BrokenDependence { designs, equations: names_of(&dependent), time: at.t });
        }
        let (costs, read) = system.costs_of_multipliers(&dependent);
        if chosen.is_none() && !costs.is_empty() {
            let costs = costs.into_iter().map(str::to_string).collect();
            warnings.push(Warning::SharedReaction { costs, equations: names_of(&read) });
        }
        let (q, design) = (at.q.to_vec(), at.design.to_vec());
        let compliance = chosen.unwrap_or_else(|| shared.clone());
        self.state.relaxed = Some(Relaxed { q, design, time: at.t, shared, compliance, warnings });
        self.relax_again(at.q)
    }

    /// The design variables whose changes alone make dependent constraints contradict each other.
    fn breaking_designs(&mut self, at: &NodeView<f64>, shared: &Compliances, of: (&[f64], &[f64])) -> Vec<usize> {
        if self.system.designs() == 0 {
            return Vec::new();
        }
        // Factor again, because the choice of left-out equations replaces the factors.
        self.linearisation.evaluation.set_compliance(shared);
        let factored = self.factor_start();
        factored.map(|()| designs(self.system, self.linearisation, at, of)).unwrap_or_default()
    }

    /// Uses the results of [`relax`](Self::relax) at the same start, now or before; false if there are none.
    pub(crate) fn relax_again(&mut self, q: &[f64]) -> bool {
        let time = self.motion.trajectory.times[0];
        let design = &self.motion.design;
        let is_same = |known: &Relaxed| {
            let is_open = self.motion.open_from(0).eq(open(&known.shared));
            known.q == q && known.design == *design && known.time == time && is_open
        };
        let Some(known) = self.state.relaxed.take().filter(is_same) else { return false };
        self.linearisation.evaluation.set_compliance(&known.compliance);
        let regular = self.factor_start().is_ok();
        if regular {
            self.motion.shared.clone_from(&known.shared);
            self.motion.set_compliance(0, known.compliance.clone());
            known.warnings.iter().for_each(|warning| self.report.warn(warning.clone()));
            self.state.relaxed = Some(known);
        } else {
            self.linearisation.evaluation.set_compliance(self.motion.trajectory.compliance_from(0));
        }
        regular
    }

    /// Computes the weights of unknowns and equations from K(0) at the start, with nothing left out or open.
    pub(crate) fn weigh(&mut self) {
        let open: Vec<usize> = self.motion.open_from(0).collect();
        if !self.motion.leaves_out() && open.is_empty() {
            return self.linearisation.weigh(self.system);
        }
        let chosen = self.motion.trajectory.compliance_from(0).to_vec();
        // With its own flexibility as a compliance, an open equation has a weight for when it has closed, and depends on no other.
        let at = NodeView { q: self.from.q, ..self.motion.at(0) };
        let flexibility = flexibilities(self.system, &at, &apparent_masses(self.linearisation, self.system, &at));
        let mut equations = with_open(&self.motion.shared, &open);
        let flexible = equations.iter_mut().filter(|(j, mu)| *mu >= OPEN && flexibility[*j] > 0.0);
        flexible.for_each(|(j, mu)| *mu = flexibility[*j]);
        self.linearisation.evaluation.set_compliance(&equations);
        if self.factor_start().is_ok() {
            self.linearisation.weigh(self.system);
        }
        self.linearisation.weights.set_open(|j| open.contains(&j));
        self.linearisation.evaluation.set_compliance(&chosen);
    }

    /// Measures the energy that compliances absorb, μ Δσ² in a stage, if positions have drifted so that dependent constraints block the motion.
    pub(super) fn watch_brake(&mut self, node: usize) {
        let (motion, start, linearisation) = (&self.motion, self.from.sigma, &self.linearisation);
        let of_stage = |stage: usize| {
            let at = motion.at_stage(node, stage);
            let compliance = closed(linearisation.evaluation.compliance());
            let gaps = compliance.map(|(j, mu)| (mu * (at.sigma[j] - start[j]), mu));
            gaps.filter(|(gap, _)| gap.abs() > LOAD).map(|(gap, mu)| gap * gap / mu).sum()
        };
        let taken = (1..=motion.trajectory.last_stage()).map(of_stage).fold(0.0, larger);
        let all = taken * (motion.nodes() - 1) as f64;
        let state = &mut self.state;
        if all <= BRAKE * state.losses.most_kinetic {
            return;
        }
        state.losses.most_kinetic = larger(state.losses.most_kinetic, self.system.energies(&motion.at(node))[0]);
        state.losses.brake = larger(state.losses.brake, all / state.losses.most_kinetic);
    }

    /// Warns of the energy that compliances absorbed up to a node, since nothing can be left out there.
    pub(super) fn warn_of_brake(&mut self, node: usize) {
        let share = std::mem::take(&mut self.state.losses.brake);
        if share > self.state.losses.most_braked {
            self.state.losses.most_braked = share;
            let (step, time) = (self.motion.step_of_whole(node), self.motion.time(node));
            self.report.replace(Warning::Braked { step, time, share });
        }
    }
}
