//! Constraints that depend on each other: a doubled hinge, a parallelogram with a third crank, a loop closed by a weld.
//!
//! In this case Φ_qᵀσ, which moves the mechanism, is determined, but σ is not: any z with Φ_qᵀz = 0 may be added. If z turns with q, the discrete
//! motion depends on the choice of σ at O(Δt²), so the choice must follow a smooth rule that the adjoint equations include. Here the rule is a
//! compliance of the equations that close loops,
//!
//! ```text
//!   E5:  dΦ/dt − μ (σ_i − σ_{i−1}) = 0,    σ_{−1} = 0,    K_σσ = −μ I,    μ_j = 1e-11 (Φ_q diag(M)⁻¹ Φ_qᵀ)_jj at the start
//! ```
//!
//! The adjoint row ∂σ becomes Φ_q c + (dΦ/dt)_q d + J_σ − μ (e − e₊) = 0. The μ are constants of a motion, so its gradient is exact for them. They
//! are at most 1e-10 of a joint's own flexibility and have no other visible effect as long as positions drift alike; otherwise see
//! `forward/selection.rs`. Scenes with independent constraints have no compliances.

use super::rank::{self, Scaled};
use super::{breaking, selection};
use crate::forward::ForwardSweep;
use crate::motion::Compliances;
use crate::node::Newton;
use crate::number::larger;
use crate::system::{Covector, ElementKind, Entry, NodeView, Pair, StateRows};
use crate::{Error, Settings, System, Warning};

/// μ in units of a joint's own Φ_q M⁻¹ Φ_qᵀ: far above the rounding of pivots, far below the accuracy required of a motion.
pub(super) const COMPLIANCE: f64 = 1e-11;
/// Constraints are dependent if their softest combination is about as soft as its compliance.
const SOFT: f64 = 0.1;
/// Largest gap of a compliance relative to the largest velocity; a larger one means that constraints contradict each other.
pub(super) const CONTRADICTION: f64 = 1e-6;
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
    let masses = apparent_masses(&forward.stepper.newton, system, at);
    let flexibility = flexibilities(system, at, &masses);
    let shared = of_loops(system, &flexibility);
    if shared.is_empty() {
        return false;
    }
    forward.stepper.newton.evaluation.set_compliance(&shared);
    let roots: Vec<f64> = flexibility.iter().map(|s| s.sqrt()).collect();
    let soft = forward.factor_start(system).ok().and_then(|()| softest(&mut forward.stepper.newton, system, &roots));
    let Some(shares) = soft else {
        forward.stepper.newton.evaluation.set_compliance(&[]);
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
        forward.stepper.newton.evaluation.set_compliance(&shared);
        let factored = forward.factor_start(system);
        factored.map(|()| breaking::designs(system, &mut forward.stepper.newton, at, (&z, &masses))).unwrap_or_default()
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

/// Results of `relax` at a start, for further motions from there: an optimiser only changes the controls.
pub(crate) struct Relaxed {
    q: Vec<f64>,
    design: Vec<f64>,
    time: f64,
    shared: Vec<(usize, f64)>,
    compliance: Vec<(usize, f64)>,
    warnings: Vec<Warning>,
}

/// Uses the results of `relax` at the same start, now or before; false if there are none.
pub(crate) fn relax_again(forward: &mut ForwardSweep, system: &System, q: &[f64]) -> bool {
    let time = forward.motion.trajectory.times[0];
    let design = &forward.motion.design;
    let is_same = |known: &Relaxed| known.q == q && known.design == *design && known.time == time;
    let Some(known) = forward.relaxed.take().filter(is_same) else { return false };
    forward.stepper.newton.evaluation.set_compliance(&known.compliance);
    let regular = forward.factor_start(system).is_ok();
    if regular {
        forward.motion.shared.clone_from(&known.shared);
        forward.motion.set_compliance(0, known.compliance.clone());
        known.warnings.iter().for_each(|warning| forward.monitor.report.warn(warning.clone()));
        forward.relaxed = Some(known);
    } else {
        forward.stepper.newton.evaluation.set_compliance(&[]);
    }
    regular
}

/// Computes the weights of unknowns and equations from K(0) at the start, with nothing left out.
pub(crate) fn weigh(forward: &mut ForwardSweep, system: &System) {
    if !forward.motion.leaves_out() {
        return forward.stepper.newton.weigh(system);
    }
    let chosen = forward.motion.trajectory.compliance_from(0).to_vec();
    forward.stepper.newton.evaluation.set_compliance(&forward.motion.shared);
    if forward.factor_start(system).is_ok() {
        forward.stepper.newton.weigh(system);
    }
    forward.stepper.newton.evaluation.set_compliance(&chosen);
}

fn of_loops(system: &System, flexibility: &[f64]) -> Vec<(usize, f64)> {
    system.loop_equations().iter().map(|&j| (j, COMPLIANCE * flexibility[j])).collect()
}

/// √(Φ_q M⁻¹ Φ_qᵀ)_jj of an equation with this compliance: the largest change of it by a velocity of size one in units of the masses.
pub(crate) fn root_flexibility(compliance: f64) -> f64 {
    (compliance / COMPLIANCE).sqrt()
}

/// The compliances of the equations that close loops, at the point of the last evaluation.
pub(super) fn compliances(newton: &Newton, system: &System, at: &NodeView<f64>) -> Vec<(usize, f64)> {
    of_loops(system, &flexibilities(system, at, &apparent_masses(newton, system, at)))
}

/// diag(M) at the point of the last evaluation.
pub(crate) fn masses(newton: &Newton, system: &System) -> Vec<f64> {
    let (n, m) = (system.n(), system.m());
    let evaluation = &newton.evaluation;
    let (mut unit, zeros, none, mut rows) = (vec![0.0; n], vec![0.0; n], vec![0.0; m], StateRows::new(n, m));
    let mut masses = vec![0.0; n];
    // M times the sum of unit vectors that M does not couple: the diagonal entries for all of them.
    for uncoupled in system.uncoupled_coordinates(&[ElementKind::Kinetic]) {
        uncoupled.iter().for_each(|&i| unit[i] = 1.0);
        evaluation.pull_back(system, &evaluation.blocks, &Covector { c: &unit, d: &zeros, e: &none }, &mut rows);
        uncoupled.iter().for_each(|&i| (masses[i], unit[i]) = (rows.v[i], 0.0));
    }
    masses
}

/// diag(M) at the last evaluation; for a coordinate without inertia, that of others through its constraints: Σ_j Φ_ji² / (Φ_q diag(M)⁻¹ Φ_qᵀ)_jj.
pub(crate) fn apparent_masses(newton: &Newton, system: &System, at: &NodeView<f64>) -> Vec<f64> {
    let masses = masses(newton, system);
    let mut apparent = masses.clone();
    if masses.contains(&0.0) {
        let flexibilities = flexibilities(system, at, &masses);
        let has_none = |entry: &&Entry| masses[entry.col] == 0.0 && flexibilities[entry.row] > 0.0;
        let entries = system.phi_q(at);
        entries.iter().filter(has_none).for_each(|e| apparent[e.col] += e.value * e.value / flexibilities[e.row]);
    }
    apparent
}

/// (Φ_q diag(M)⁻¹ Φ_qᵀ)_jj of all equations, with these masses.
pub(crate) fn flexibilities(system: &System, at: &NodeView<f64>, masses: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; system.m()];
    for entry in system.phi_q(at).iter().filter(|entry| masses[entry.col] > 0.0) {
        sums[entry.row] += entry.value * entry.value / masses[entry.col];
    }
    sums
}

/// Shares of equations in the softest combination of constraints, the largest being 1, by inverse iteration with the current factors of K(0); `None`
/// if this combination is not soft.
pub(super) fn softest(newton: &mut Newton, system: &System, roots: &[f64]) -> Option<Vec<f64>> {
    let mut x = Pair::new(system.n(), system.m());
    // An arbitrary combination of all constraints.
    let mut shares: Vec<f64> = (0..system.m()).map(|j| 1.0 + 0.3 * (j as f64).sin()).collect();
    let mut growth = 0.0;
    for _ in 0..3 {
        x.v.fill(0.0);
        x.sigma.iter_mut().zip(shares.iter().zip(roots)).for_each(|(r, (share, root))| *r = share * root);
        newton.solve(system, &mut x);
        shares.iter_mut().zip(x.sigma.iter().zip(roots)).for_each(|(share, (sigma, root))| *share = sigma * root);
        growth = shares.iter().fold(0.0f64, |largest, share| largest.max(share.abs()));
        shares.iter_mut().for_each(|share| *share /= growth);
    }
    (growth * COMPLIANCE > SOFT).then_some(shares)
}

/// Returns an error if dependent equations have gaps μ σ above the tolerance and a fraction of a size, so that they cannot be satisfied together.
pub(super) fn refuse_gaps(
    system: &System,
    at: &NodeView<f64>,
    (compliances, sigma): (&Compliances, impl Fn(usize) -> f64),
    (tolerance, size): (f64, f64),
) -> Result<(), Error> {
    // In the unit of the equation.
    let allowed = |mu: f64| tolerance + CONTRADICTION * size * root_flexibility(mu);
    let gap = |&(j, mu): &(usize, f64)| {
        let gap = (mu * sigma(j)).abs();
        (gap > allowed(mu)).then_some((j, gap))
    };
    let gaps: Vec<(usize, f64)> = compliances.iter().filter_map(gap).collect();
    if gaps.is_empty() {
        return Ok(());
    }
    // As in `rank::Scaled::contradiction`, for the combination σ whose largest share is 1.
    let most = gaps.iter().fold(0.0, |most: f64, (j, _)| most.max(sigma(*j).abs()));
    let violation = gaps.iter().map(|(j, gap)| gap * (sigma(*j) / most).abs()).sum();
    let names = || gaps.iter().map(|(j, _)| system.equation_name(*j).to_string()).collect();
    let equations = rank::dependent(system, at).unwrap_or_else(names);
    Err(Error::ContradictoryConstraints { equations, violation, time: at.t })
}

impl ForwardSweep {
    /// Returns an error if dependent constraints cannot be satisfied together, so that their compliances have gaps.
    pub(crate) fn check_compliant(&self, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
        if self.motion.trajectory.compliance.is_empty() { Ok(()) } else { self.compare_gaps(system, node, settings) }
    }

    #[cold]
    fn compare_gaps(&self, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
        let (at, newton) = (self.motion.at(node), &self.stepper.newton);
        let sigma = |j: usize| at.sigma[j] - self.stepper.start_sigma[j];
        let within = (settings.velocity_tolerance, newton.size_of(at.v));
        refuse_gaps(system, &at, (newton.evaluation.compliance(), sigma), within)
    }

    /// Measures the energy that compliances absorb, μ Δσ² in a stage, if positions have drifted so that dependent constraints block the motion.
    pub(super) fn watch_brake(&mut self, system: &System, node: usize) {
        let (motion, start) = (&self.motion, &self.stepper.start_sigma);
        if motion.trajectory.compliance.is_empty() {
            return;
        }
        let of_stage = |stage: usize| {
            let at = motion.at_stage(node, stage);
            let gaps =
                self.stepper.newton.evaluation.compliance().iter().map(|&(j, mu)| (mu * (at.sigma[j] - start[j]), mu));
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
