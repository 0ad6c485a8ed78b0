//! K(0) at a state, for accelerations and reactions.

use crate::assembly::factor_state;
use crate::motion::{Compliances, Report, closed, open};
use crate::node::Linearisation;
use crate::number::larger;
use crate::system::{Covector, NodeView, Pair, StateRows};
use crate::{Error, System, redundancy};

/// Number of corrections of solutions if K(0) has compliances; one correction …
const CORRECTIONS: usize = 3;
/// … is made if the pivot ratio is below this.
const DOUBTFUL: f64 = 1e-3;
/// A residual above this fraction of the right-hand side means that reactions are not determined.
const UNDETERMINED: f64 = 1e-6;
/// Such a fraction for equations that are left out, after positions have drifted.
const SHARED: f64 = 1e-3;

/// K(0) of a state, factored, and workspace for solutions.
pub(super) struct State {
    pub(super) linearisation: Linearisation,
    corrections: usize,
    pub(super) right: Pair,
    /// The residual of a corrected solution.
    left: Pair,
    rows: StateRows,
    pub(super) zeros: Pair,
}

impl State {
    pub(super) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        let pair = || Pair::new(n, m);
        let (linearisation, rows) = (Linearisation::new(system), StateRows::new(n, m));
        State { linearisation, corrections: 0, right: pair(), left: pair(), rows, zeros: pair() }
    }

    pub(super) fn factor(&mut self, system: &System, at: &NodeView<f64>, place: (usize, &Compliances)) -> Result<(), Error> {
        let at = without_sigma(at, &self.zeros);
        let pivot = factor_state(system, &mut self.linearisation, (&at, place), &mut Report::default())?;
        let is_compliant = closed(self.linearisation.evaluation.compliance()).next().is_some();
        self.corrections = if is_compliant { CORRECTIONS } else { usize::from(pivot < DOUBTFUL) };
        Ok(())
    }

    /// Solves K(0) x = r.
    pub(super) fn solve(&mut self, system: &System, x: &mut Pair) {
        let State { linearisation, right, left, rows, zeros, .. } = self;
        x.v.copy_from_slice(&right.v);
        x.sigma.copy_from_slice(&right.sigma);
        linearisation.solve(system, x);
        for _ in 0..self.corrections {
            let with = Covector { c: &x.v, d: &zeros.v, e: &x.sigma };
            linearisation.evaluation.pull_back(system, &linearisation.evaluation.blocks, &with, rows);
            left.v.copy_from_slice(&rows.v);
            left.sigma.copy_from_slice(&rows.sigma);
            left.subtract_from(right);
            let mut correction = left.clone();
            linearisation.solve(system, &mut correction);
            x.add(&correction);
        }
    }

    /// The equation of a requested reaction that other equations may take over: zᵀr_σ ≠ 0 for a z with Φ_qᵀz = 0.
    pub(super) fn find_undetermined(&mut self, system: &System, at: &NodeView<f64>) -> Option<usize> {
        closed(self.linearisation.evaluation.compliance()).next()?;
        let mut flexibilities = redundancy::flexibilities(system, at, &redundancy::masses(&self.linearisation, system));
        let asked = self.right.sigma.clone();
        let left_out: Vec<usize> = {
            let compliance = closed(self.linearisation.evaluation.compliance());
            compliance.filter(|&(j, mu)| mu > flexibilities[j]).map(|(j, _)| j).collect()
        };
        if let Some(found) = left_out.iter().find_map(|&j| self.find_shared(system, j, &asked, &flexibilities)) {
            return Some(found);
        }
        open(self.linearisation.evaluation.compliance()).for_each(|j| flexibilities[j] = 0.0);
        // Equations that are left out are satisfied only up to the drift of the positions.
        left_out.iter().for_each(|&j| flexibilities[j] = 0.0);
        let most =
            |x: &[f64]| (0..x.len()).max_by(|&a, &b| size(&flexibilities, x, a).total_cmp(&size(&flexibilities, x, b)));
        let (lost, most_asked) = (most(&self.left.sigma)?, most(&asked)?);
        let [left, right] = [(&self.left.sigma, lost), (&asked, most_asked)].map(|(x, j)| size(&flexibilities, x, j));
        (right > 0.0 && left > UNDETERMINED * right).then_some(most_asked)
    }

    /// The equation of a requested reaction that equation j may take over: zᵀr_σ ≠ 0 with z_j = 1, the others from K(0) (v, −z) = (Φ_qᵀ, 0)_j.
    fn find_shared(&mut self, system: &System, j: usize, asked: &[f64], flexibilities: &[f64]) -> Option<usize> {
        let State { linearisation, right, rows, zeros, .. } = self;
        if asked.iter().all(|x| *x == 0.0) {
            return None;
        }
        right.sigma.fill(0.0);
        right.sigma[j] = 1.0;
        let with = Covector { c: &zeros.v, d: &zeros.v, e: &right.sigma };
        linearisation.evaluation.pull_back(system, &linearisation.evaluation.blocks, &with, rows);
        let mut x = Pair { v: rows.v.clone(), sigma: zeros.sigma.clone() };
        linearisation.solve(system, &mut x);
        let z: Vec<f64> = x.sigma.iter().zip(&right.sigma).map(|(sigma, unit)| unit - sigma).collect();
        right.sigma.copy_from_slice(asked);
        let share = |j: usize| z[j].abs() * flexibilities[j].sqrt();
        let of_z = (0..z.len()).map(share).fold(0.0, larger);
        let of_asked = (0..z.len()).map(|j| size(flexibilities, asked, j)).fold(0.0, larger);
        let sum: f64 = z.iter().zip(asked).map(|(z, asked)| z * asked).sum();
        let most = (0..z.len()).max_by(|&a, &b| (z[a] * asked[a]).abs().total_cmp(&(z[b] * asked[b]).abs()));
        most.filter(|_| sum.abs() > SHARED * of_z * of_asked)
    }
}

/// An entry of the derivative with respect to the reaction of equation j, in units of the masses, so that equations are comparable.
fn size(flexibilities: &[f64], x: &[f64], j: usize) -> f64 {
    if flexibilities[j] > 0.0 { x[j].abs() / flexibilities[j].sqrt() } else { 0.0 }
}

pub(super) fn without_sigma<'a>(at: &NodeView<'a, f64>, zeros: &'a Pair) -> NodeView<'a, f64> {
    NodeView { sigma: &zeros.sigma, ..at.without_momenta() }
}
