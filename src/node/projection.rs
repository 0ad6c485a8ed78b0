//! The projection of a node onto Φ = 0: q = q⁻ + w with 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0, by corrections with K(0) at q⁻,
//!
//! ```text
//!   K(0) (δw, δν) = −(𝓛_v, Φ)      δw = −T 𝓛_v − S Φ
//! ```
//!
//! **Rounding.** Φ_j is known to ε t_j, with t_j the sum of the absolute values of its terms, and no correction is more accurate than S Δ for |Δ_j| ≤
//! ε t_j. T is M⁻¹ times a projector, so it is bounded. S is not: at a distance θ from a configuration at which Φ_q loses rank, such as a flat
//! parallelogram, it is as large as 1/θ. Corrections that have stopped shrinking are therefore rounding, for any size, if Φ contributes more to them
//! than 𝓛_v, and Φ itself is rounding. The positions then have an error u ≈ ε/θ along a motion that the constraints hardly resist there, and Φ = 0
//! holds to rounding. A projection that fails has a larger Φ, or 𝓛_v does not converge.
//!
//! **Dependent constraints.** With Φ_qᵀz = 0, rounding ε of zᵀΦ moves ν by ε/μ along z, 1e-5 N s, and 𝓛_v by this times (Φ_q(q) − Φ_q(q⁻))ᵀz if K(0)
//! is that at q⁻. Therefore K(0) is factored at q, where Φ_qᵀz = 0, as soon as q is known.

use super::lengths::Lengths;
use super::linearisation::Linearisation;
use super::step::StepFailure;
use crate::System;
use crate::motion::{Motion, OPEN, Report};
use crate::number::{larger, largest};
use crate::system::{NodeView, Pair};

/// A projection that has not converged after this number of corrections fails; corrections that shrink by a third have reached rounding by then. The
/// corrections of its derivatives shrink alike.
pub(crate) const MOST_CORRECTIONS_OF_PROJECTION: usize = 90;
/// If constraints depend on each other, K(0) is factored anew in these corrections: q is known to rounding before the last.
const REFACTORED: std::ops::RangeInclusive<usize> = 1..=2;
/// Momenta at rest below this fraction of those of the motion are rounding.
const LINEAR: f64 = 1e-12;
/// A correction below this fraction of the largest coordinate, both in units of their masses, is rounding …
const ROUNDING: f64 = 1e-15;
/// … and below this one if corrections have stopped shrinking, as everywhere but close to singular configurations.
const STALLED: f64 = 1e-13;
/// The rounding of Φ_j as a part of its terms.
const ROUNDING_OF_PHI: f64 = 8.0 * f64::EPSILON;

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
    pub(crate) fn evaluate(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        node: usize,
        report: &mut Report,
    ) {
        let at = NodeView { q: &self.q, v: &self.x.v, sigma: &self.x.sigma, ..motion.at(node) };
        linearisation.l_v(system, &at, &mut self.left.v, report);
    }
}

/// The projection of a node.
pub(crate) struct Projection<'a> {
    pub(crate) system: &'a System,
    pub(crate) motion: &'a Motion,
    /// Newton's method, with the factors of K(0) at q⁻ before the projection.
    pub(crate) linearisation: &'a mut Linearisation,
    pub(crate) report: &'a mut Report,
    pub(crate) lengths: &'a mut Lengths,
    pub(crate) node: usize,
}

impl Projection<'_> {
    /// Moves the point `at` from q⁻ of a node to its projection; its blocks are then in the evaluation. Needs the factors of K(0) at q⁻.
    pub(crate) fn apply(&mut self, at: &mut Point) -> Result<(), StepFailure> {
        self.l_v(at);
        let momentum = self.linearisation.weights.of_momenta(&at.left.v);
        at.x.v.fill(0.0);
        let (mut last, mut moved) = (f64::INFINITY, f64::INFINITY);
        for corrections in 0..MOST_CORRECTIONS_OF_PROJECTION {
            self.l_v(at);
            if corrections == 0 {
                self.check_quadratic(&at.left.v, momentum)?;
            }
            self.violation(at);
            if REFACTORED.contains(&corrections) && !self.linearisation.evaluation.compliance().is_empty() {
                let factored = self.linearisation.factor_here(self.system, 0.0, self.report);
                factored.map_err(StepFailure::Singular)?;
            }
            self.linearisation.solve(self.system, &mut at.left);
            let (correction, size) = (self.linearisation.size_of(&at.left.v), self.linearisation.size_of(&at.q));
            moved = largest(&at.left.v);
            if correction <= ROUNDING * size {
                return Ok(());
            }
            if corrections > 3 && correction >= 0.5 * last {
                if correction <= STALLED * size || self.is_rounding_of_phi(at, correction) {
                    return Ok(());
                }
                if correction >= last {
                    return Err(StepFailure::Projection { iterations: corrections, correction: moved });
                }
            }
            last = correction;
            let before = self.motion.at(self.node).q;
            for (i, w) in at.x.v.iter_mut().enumerate() {
                *w -= at.left.v[i];
                at.q[i] = before[i] + *w;
            }
            at.x.sigma.iter_mut().zip(&at.left.sigma).for_each(|(nu, delta)| *nu -= delta);
        }
        Err(StepFailure::Projection { iterations: MOST_CORRECTIONS_OF_PROJECTION, correction: moved })
    }

    /// Returns an error if T_v(q, 0) ≠ 0, because it would move q even if Φ = 0.
    fn check_quadratic(&self, at_rest: &[f64], momentum: f64) -> Result<(), StepFailure> {
        let weights = self.linearisation.weights.momenta();
        let size = |i: usize| weights[i] * at_rest[i].abs();
        let Some(most) = (0..at_rest.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))) else { return Ok(()) };
        if size(most) > LINEAR * momentum {
            Err(StepFailure::LinearEnergy { coordinate: most, momentum: at_rest[most] })
        } else {
            Ok(())
        }
    }

    /// Writes Φ or, with compliances, Φ − μ ν.
    fn violation(&mut self, at: &mut Point) {
        let point = NodeView { q: &at.q, ..self.motion.at(self.node) };
        self.linearisation.evaluation.phi(self.system, &point, &mut at.left.sigma);
        for &(j, mu) in self.linearisation.evaluation.compliance() {
            // Open equations do not count.
            at.left.sigma[j] = if mu < OPEN { at.left.sigma[j] - mu * at.x.sigma[j] } else { 0.0 };
        }
    }

    /// True if a correction that is as large as the previous one is the rounding error of Φ.
    #[cold]
    fn is_rounding_of_phi(&mut self, at: &mut Point, correction: f64) -> bool {
        self.l_v(at);
        at.left.sigma.fill(0.0);
        self.linearisation.solve(self.system, &mut at.left);
        let of_l_v = self.linearisation.size_of(&at.left.v);
        self.violation(at);
        let terms = self.terms(at);
        let is_rounding = |(phi, terms): (&f64, &f64)| phi.abs() <= ROUNDING_OF_PHI * terms;
        of_l_v <= 0.5 * correction && at.left.sigma.iter().zip(&terms).all(is_rounding)
    }

    /// t_j: the lengths in Φ_j and Σ |∂Φ_j/∂q_i| max(|q_i|, 1), because sin q and cos q are not small where an angle is. Terms of formulas with small
    /// derivatives are not known; they are assumed to be as large as in the other formulas.
    fn terms(&mut self, at: &Point) -> Vec<f64> {
        self.lengths.phi.copy_from_slice(&at.left.sigma);
        self.lengths.measure(self.system, self.motion, self.linearisation, self.node);
        let mut terms = self.lengths.of_equations.clone();
        let entries = self.system.phi_q(&NodeView { q: &at.q, ..self.motion.at(self.node) });
        entries.iter().for_each(|entry| terms[entry.row] += entry.value.abs() * larger(at.q[entry.col].abs(), 1.0));
        let waves = &self.linearisation.evaluation.constants.waves;
        let mut is_known = vec![false; terms.len()];
        waves.iter().for_each(|wave| is_known[wave.equation] = true);
        let others = || is_known.iter().enumerate().filter(|(_, known)| !**known).map(|(j, _)| j);
        let most = others().fold(0.0, |most, j| larger(most, terms[j]));
        others().for_each(|j| terms[j] = most);
        terms
    }

    fn l_v(&mut self, at: &mut Point) {
        at.evaluate(self.system, self.motion, self.linearisation, self.node, self.report);
    }
}
