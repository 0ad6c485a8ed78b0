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
//! `redundancy/selection.rs`. Scenes with independent constraints have no compliances.

use crate::model::space::Motion;
use crate::motion::{Compliances, OPEN, closed};
use crate::node::Linearisation;
use crate::number::larger;
use crate::redundancy::rank;
use crate::system::{Covector, Entry, NodeView, Pair, StateRows};
use crate::{Error, System, Warning};

/// μ in units of a joint's own Φ_q M⁻¹ Φ_qᵀ: far above the rounding of pivots, far below the accuracy required of a motion.
pub(crate) const COMPLIANCE: f64 = 1e-11;
/// If the ratio of a pivot to its terms is below this, constraints may depend on each other.
pub(crate) const SUSPICIOUS: f64 = 1e-10;
/// Constraints are dependent if their softest combination is about as soft as its compliance.
const SOFT: f64 = 0.1;
/// Largest gap of a compliance relative to the largest velocity; a larger one means that constraints contradict each other.
pub(crate) const CONTRADICTION: f64 = 1e-6;

/// Results of `relax` at a start, for further motions from there: an optimiser only changes the controls.
pub(crate) struct Relaxed {
    pub(crate) q: Vec<f64>,
    pub(crate) design: Vec<f64>,
    pub(crate) time: f64,
    pub(crate) shared: Vec<(usize, f64)>,
    pub(crate) compliance: Vec<(usize, f64)>,
    pub(crate) warnings: Vec<Warning>,
}

pub(crate) fn of_loops(system: &System, flexibility: &[f64]) -> Vec<(usize, f64)> {
    system.loop_equations().iter().map(|&j| (j, COMPLIANCE * flexibility[j])).collect()
}

/// The compliances of the equations whose row of Φ_q is zero if K(0) `is_regular` with them, otherwise all.
pub(crate) fn sufficient(
    all: Vec<(usize, f64)>,
    (system, at): (&System, &NodeView<f64>),
    mut is_regular: impl FnMut(&Compliances) -> bool,
) -> Vec<(usize, f64)> {
    let mut is_still = vec![true; system.m()];
    system.phi_q(at).iter().for_each(|e| is_still[e.row] &= e.value == 0.0);
    let few: Vec<(usize, f64)> = all.iter().copied().filter(|&(j, mu)| mu >= OPEN || is_still[j]).collect();
    if closed(&few).next().is_some() && is_regular(&few) { few } else { all }
}

/// √(Φ_q M⁻¹ Φ_qᵀ)_jj of an equation with this compliance: the largest change of it by a velocity of size one in units of the masses.
pub(crate) fn root_flexibility(compliance: f64) -> f64 {
    (compliance / COMPLIANCE).sqrt()
}

/// The compliances of the equations that close loops, at the point of the last evaluation.
pub(crate) fn compliances(linearisation: &Linearisation, system: &System, at: &NodeView<f64>) -> Vec<(usize, f64)> {
    of_loops(system, &flexibilities(system, at, &apparent_masses(linearisation, system, at)))
}

/// diag(M) at the point of the last evaluation; for the four Euler parameters of a rotation, which have no inertia along themselves, their mean.
pub(crate) fn masses(linearisation: &Linearisation, system: &System) -> Vec<f64> {
    let (n, m) = (system.n(), system.m());
    let evaluation = &linearisation.evaluation;
    let (mut unit, zeros, none, mut rows) = (vec![0.0; n], vec![0.0; n], vec![0.0; m], StateRows::new(n, m));
    let mut masses = vec![0.0; n];
    // M times the sum of unit vectors that M does not couple: the diagonal entries for all of them.
    for uncoupled in system.uncoupled_by_energies() {
        uncoupled.iter().for_each(|&i| unit[i] = 1.0);
        evaluation.pull_back(system, &evaluation.blocks, &Covector { c: &unit, d: &zeros, e: &none }, &mut rows);
        uncoupled.iter().for_each(|&i| (masses[i], unit[i]) = (rows.v[i], 0.0));
    }
    for frame in &system.sketch().space.frames {
        if let Motion::Ball(e) = &frame.motion {
            let all = e.each_ref().map(|e| e.coordinate.index());
            let mean = 0.25 * all.iter().map(|i| masses[*i]).sum::<f64>();
            all.into_iter().for_each(|i| masses[i] = mean);
        }
    }
    masses
}

/// diag(M) at the last evaluation; for a coordinate without inertia, that of others through its constraints: Σ_j Φ_ji² / (Φ_q diag(M)⁻¹ Φ_qᵀ)_jj.
pub(crate) fn apparent_masses(linearisation: &Linearisation, system: &System, at: &NodeView<f64>) -> Vec<f64> {
    let masses = masses(linearisation, system);
    let mut apparent = masses.clone();
    if masses.contains(&0.0) {
        let flexibilities = flexibilities(system, at, &masses);
        let has_none = |entry: &&Entry| masses[entry.col] == 0.0 && flexibilities[entry.row] > 0.0;
        let entries = system.phi_q(at);
        entries.iter().filter(has_none).for_each(|e| apparent[e.col] += e.value * e.value / flexibilities[e.row]);
    }
    apparent
}

/// (Φ_q diag(M)⁻¹ Φ_qᵀ)_jj of all equations, with these masses. An equation whose row is zero has the largest of the others, or else 1 over the smallest
/// mass, so that its compliance is far above its rounding.
pub(crate) fn flexibilities(system: &System, at: &NodeView<f64>, masses: &[f64]) -> Vec<f64> {
    let (mut sums, mut is_still) = (vec![0.0; system.m()], vec![true; system.m()]);
    for entry in system.phi_q(at).iter().filter(|entry| entry.value != 0.0) {
        is_still[entry.row] = false;
        if masses[entry.col] > 0.0 {
            sums[entry.row] += entry.value * entry.value / masses[entry.col];
        }
    }
    let by_masses = || masses.iter().filter(|mass| **mass > 0.0).map(|mass| mass.recip()).fold(0.0, larger);
    let most = sums.iter().copied().fold(0.0, larger);
    let most = if most > 0.0 { most } else { by_masses() };
    sums.iter_mut().zip(is_still).filter(|(_, is_still)| *is_still).for_each(|(sum, _)| *sum = most);
    sums
}

/// Shares of equations in the softest combination of constraints, the largest being 1, by inverse iteration with the current factors of K(0); `None`
/// if this combination is not soft.
pub(crate) fn softest(linearisation: &mut Linearisation, system: &System, roots: &[f64]) -> Option<Vec<f64>> {
    let mut x = Pair::new(system.n(), system.m());
    // An arbitrary combination of all constraints.
    let mut shares: Vec<f64> = (0..system.m()).map(|j| 1.0 + 0.3 * (j as f64).sin()).collect();
    let mut growth = 0.0;
    for _ in 0..3 {
        x.v.fill(0.0);
        x.sigma.iter_mut().zip(shares.iter().zip(roots)).for_each(|(r, (share, root))| *r = share * root);
        linearisation.solve(system, &mut x);
        shares.iter_mut().zip(x.sigma.iter().zip(roots)).for_each(|(share, (sigma, root))| *share = sigma * root);
        growth = shares.iter().fold(0.0f64, |largest, share| largest.max(share.abs()));
        shares.iter_mut().for_each(|share| *share /= growth);
    }
    (growth * COMPLIANCE > SOFT).then_some(shares)
}

/// Returns an error if dependent equations have gaps μ σ above the tolerance and a fraction of a size, so that they cannot be satisfied together.
pub(crate) fn refuse_gaps(
    system: &System,
    at: &NodeView<f64>,
    (compliances, sigma): (&Compliances, impl Fn(usize) -> f64),
    (tolerance, size): (f64, f64),
) -> Result<(), Error> {
    // In the unit of the equation.
    let allowed = |mu: f64| tolerance + CONTRADICTION * size * root_flexibility(mu);
    let gap = |(j, mu): (usize, f64)| {
        let gap = (mu * sigma(j)).abs();
        (gap > allowed(mu)).then_some((j, gap))
    };
    let gaps: Vec<(usize, f64)> = closed(compliances).filter_map(gap).collect();
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
