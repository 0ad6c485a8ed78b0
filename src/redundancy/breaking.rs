//! Design variables b that break a dependence of constraints, zᵀ Φ_q = 0.
//!
//! ```text
//!   positions:     Φ(q + δq, b + δb) = 0               for some δq only if zᵀ ∂Φ/∂b δb = 0
//!   velocities:    dΦ/dt(q + δq, v + δv, b + δb) = 0   for some δv only if (zᵀ ∂(dΦ/dt)/∂b − yᵀ ∂Φ/∂b) δb = 0,   Φ_qᵀ y = (dΦ/dt)_qᵀ z
//! ```
//!
//! Two motors at one angle agree at the start but not in speed, two rails through one point not in direction: only velocities show both.

use crate::System;
use crate::motion::Report;
use crate::node::Linearisation;
use crate::number::largest;
use crate::system::{Covector, InputRows, NodeView, Pair, StateRows};

/// Sums below this fraction of their terms are rounding, including the rounding of z.
const ROUNDING: f64 = 1e-4;
/// Sums are also rounding below this fraction of their size with equal shares of all equations, because then all terms may be rounding.
const NOTHING: f64 = 1e-8;

/// A combination of equations: zᵀ ∂Φ/∂b or, with y, that of velocities.
struct Combination {
    z: Vec<f64>,
    y: Option<Vec<f64>>,
}

/// The design variables that break the dependence z. `linearisation` has factors of K(0) with the compliances of all loops; `masses` is the diagonal of M.
pub(crate) fn designs(
    system: &System,
    linearisation: &mut Linearisation,
    at: &NodeView<f64>,
    (z, masses): (&[f64], &[f64]),
) -> Vec<usize> {
    let [of_positions, terms] = [z.to_vec(), weighted(z)].map(|z| Combination { z, y: None });
    let mut breaks = of_positions.breaking(system, linearisation, at, &terms);
    if let Some((v, [y, y_of_terms])) = moving(system, linearisation, at, (z, masses)) {
        let of_velocities = Combination { z: z.to_vec(), y: Some(y) };
        let terms = Combination { z: weighted(z), y: Some(y_of_terms) };
        let by_velocities = of_velocities.breaking(system, linearisation, &NodeView { v: &v, ..*at }, &terms);
        breaks.iter_mut().zip(by_velocities).for_each(|(breaks, by_velocity)| *breaks |= by_velocity);
    }
    (0..breaks.len()).filter(|&b| breaks[b]).collect()
}

/// Admissible velocities v in which all motions take part, y, and y without cancelling terms; `None` if v itself ends the dependence.
fn moving(
    system: &System,
    linearisation: &mut Linearisation,
    at: &NodeView<f64>,
    (z, masses): (&[f64], &[f64]),
) -> Option<(Vec<f64>, [Vec<f64>; 2])> {
    let (n, m) = (system.n(), system.m());
    let (at_rest, none) = (vec![0.0; n], vec![0.0; m]);
    let mut pair = Pair::new(n, m);
    let still = NodeView { v: &at_rest, sigma: &none, ..*at };
    linearisation.l_v_and_phi_dot(system, &still, &mut pair, &mut Report::default());
    pair.sigma.iter_mut().for_each(|phi_t| *phi_t = -*phi_t);
    pair.v.iter_mut().enumerate().for_each(|(i, p)| *p = masses[i] * (1.0 + 0.3 * (i as f64).sin()));
    linearisation.solve(system, &mut pair);
    let v = pair.v.clone();
    let moved = NodeView { v: &v, ..still };
    linearisation.l_v_and_phi_dot(system, &moved, &mut pair, &mut Report::default());
    let mut rows = StateRows::new(n, m);
    let mut by_q = |z: &[f64]| {
        let evaluation = &linearisation.evaluation;
        evaluation.pull_back(system, &evaluation.blocks, &Covector { c: &at_rest, d: &at_rest, e: z }, &mut rows);
        rows.q.clone()
    };
    let (right, terms) = (by_q(z), by_q(&weighted(z)));
    let mobility = |i: usize, x: f64| if masses[i] > 0.0 { x / masses[i] } else { 0.0 };
    let most = (0..n).fold(0.0f64, |most, i| most.max(mobility(i, right[i]).abs()).max(mobility(i, terms[i]).abs()));
    let [y, y_of_terms] = [right, terms].map(|right| {
        let mut y = Pair { v: right, sigma: none.clone() };
        linearisation.solve(system, &mut y);
        y
    });
    (largest(&y.v) <= ROUNDING * most).then_some((v, [y.sigma, y_of_terms.sigma]))
}

impl Combination {
    /// For each design variable, true if its sum is not zero compared with the same terms with other weights.
    fn breaking(
        &self,
        system: &System,
        linearisation: &mut Linearisation,
        at: &NodeView<f64>,
        terms: &Combination,
    ) -> Vec<bool> {
        // At another point terms do not cancel, whether they belong to several equations or to one.
        let aside = |x: &[f64]| Vec::from_iter(x.iter().enumerate().map(|(i, x)| x + 0.5 + 0.3 * (i as f64).sin()));
        let [q, v] = [at.q, at.v].map(aside);
        let sums = self.sums(system, linearisation, at);
        let elsewhere = NodeView { q: &q, v: &v, ..*at };
        let most =
            Combination { z: evenly(&self.z), y: terms.y.as_deref().map(evenly) }.sums(system, linearisation, &elsewhere);
        let terms = [*at, elsewhere].map(|at| terms.sums(system, linearisation, &at));
        // The terms may be NaN at the other point; `max` ignores NaN.
        let size = |b: usize| (ROUNDING * terms[0][b].abs().max(terms[1][b].abs())).max(NOTHING * most[b].abs());
        (0..sums.len()).map(|b| sums[b].abs() > size(b)).collect()
    }

    /// The sums for all design variables.
    fn sums(&self, system: &System, linearisation: &mut Linearisation, at: &NodeView<f64>) -> Vec<f64> {
        let (mut time, mut evaluations) = (0.0, 0);
        let (mut u, mut by_parameters) = (vec![0.0; system.k()], vec![0.0; system.parameters().len()]);
        let rows = &mut InputRows { u: &mut u, design: &mut by_parameters, time: &mut time, evaluations: &mut evaluations };
        match &self.y {
            None => system.placed().for_each(|item| item.pull_back_phi(at, &self.z, rows)),
            Some(y) => {
                let (none, minus): (Vec<f64>, Vec<f64>) = (vec![0.0; system.n()], y.iter().map(|y| -y).collect());
                linearisation.evaluation.pull_back_inputs(system, at, &Covector { c: &none, d: &none, e: &self.z }, rows);
                system.placed().for_each(|item| item.pull_back_phi(at, &minus, rows));
            }
        }
        let mut by_designs = vec![0.0; system.designs()];
        system.parameters().pull_back(&at.design[..system.designs()], &by_parameters, &mut by_designs);
        by_designs
    }
}

/// z with other weights, so that terms do not cancel.
fn weighted(z: &[f64]) -> Vec<f64> {
    z.iter().enumerate().map(|(j, z)| z * (1.0 + 0.9 * (j as f64 + 0.5).sin())).collect()
}

/// The largest z for all equations, with other weights.
fn evenly(z: &[f64]) -> Vec<f64> {
    weighted(&vec![largest(z); z.len()])
}
