//! Newton's method for an equilibrium: k δ = g in the free motions, with steps shortened until |g| decreases.
//!
//! |g|² = gᵀ g is twice the energy that the forces would give to accelerations, so it does not depend on the choice of coordinates. Motions without
//! stiffness are left out of the steps; whether they are neutral or unbalanced is decided at the end.

use nalgebra::{DVector, SVD};

use super::statics::{Balance, Statics};
use crate::Error;
use crate::error::quoted;
use crate::number::largest;

const MOST_STEPS: usize = 60;
const MOST_HALVINGS: i32 = 12;
/// Steps below this fraction of the largest coordinate are rounding.
const ROUNDING: f64 = 1e-14;
/// A step that stops shrinking is rounding below this fraction.
const STALLED: f64 = 1e-10;
/// Steps below this fraction are not shortened, because the decrease of |g| may be rounding.
const CLOSE: f64 = 1e-8;
/// Singular values of k below this fraction of the largest are zero.
pub(super) const NEUTRAL: f64 = 1e-12;
/// Forces on a motion below this fraction of the largest forces on coordinates that move are rounding, …
const BALANCED: f64 = 1e-9;
/// … and below this fraction of those that the largest coordinate would cause by the largest stiffness.
const SHIFTED: f64 = 1e-12;

impl Statics {
    /// The equilibrium to which Newton's method converges; `None` if it does not.
    pub(super) fn newton(&mut self, from: &Balance) -> Result<Option<Balance>, Error> {
        let (mut here, mut last) = (self.balance(&from.state)?, f64::INFINITY);
        for _ in 0..MOST_STEPS {
            let by = here.newton_step();
            let (of, size) = (by.amax(), here.size());
            if of <= ROUNDING * size || of >= 0.5 * last && of <= STALLED * size {
                return Ok(Some(here));
            }
            last = of;
            let shares = (0..MOST_HALVINGS).map(|k| 0.5f64.powi(k));
            let mut better = shares.filter_map(|share| {
                let next = self.moved(&here, &(share * &by)).ok()?;
                let is_accepted = next.force.norm() <= (1.0 - 1e-4 * share) * here.force.norm() || of <= CLOSE * size;
                is_accepted.then_some(next)
            });
            let Some(next) = better.next() else { return Ok(None) };
            here = next;
        }
        Ok(None)
    }
}

impl Balance {
    /// The largest coordinate, at least 1 m or rad.
    pub(super) fn size(&self) -> f64 {
        largest(self.state.q()).max(1.0)
    }

    /// The change of all coordinates in a step of Newton's method, without motions that have no stiffness.
    fn newton_step(&self) -> DVector<f64> {
        let still = DVector::zeros(self.forces.len());
        if self.force.is_empty() {
            return still;
        }
        let svd = self.decomposition();
        let most = svd.singular_values.amax();
        svd.solve(&self.force, NEUTRAL * most).map_or(still, |step| &self.free * step)
    }

    fn decomposition(&self) -> SVD<f64, nalgebra::Dyn, nalgebra::Dyn> {
        SVD::new(self.stiffness.clone(), true, true)
    }

    /// Returns an error if a solution of Newton's method is no isolated equilibrium: there are motions without stiffness, and a force on one of them
    /// remains, or none.
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.force.is_empty() {
            return Ok(());
        }
        let SVD { u: Some(left), singular_values, v_t: Some(right) } = self.decomposition() else { return Ok(()) };
        let most = singular_values.amax();
        let neutral: Vec<usize> = (0..singular_values.len()).filter(|&i| singular_values[i] <= NEUTRAL * most).collect();
        let motions: Vec<DVector<f64>> = neutral.iter().map(|&i| &self.free * right.row(i).transpose()).collect();
        let rounding = |motion: &DVector<f64>| {
            BALANCED * self.forces.amax() * motion.map(f64::abs).sum() + SHIFTED * most * self.size() / motion.amax()
        };
        let force = |i: usize| left.column(i).dot(&self.force).abs();
        if neutral.iter().zip(&motions).any(|(&i, motion)| force(i) > rounding(motion)) {
            return Err(self.unbalanced());
        }
        let name = |i: usize| quoted(self.state.system().coordinate_name(i));
        let moves = |i: &usize| motions.iter().any(|motion| motion[*i].abs() > 1e-6 * motion.amax());
        let coordinates: Vec<String> = (0..self.forces.len()).filter(moves).map(name).collect();
        if motions.is_empty() { Ok(()) } else { Err(Error::NeutralEquilibrium { coordinates }) }
    }

    /// The error that names the independent coordinate with the largest force.
    pub(super) fn unbalanced(&self) -> Error {
        let all = self.motions.tr_mul(&self.forces);
        let is_free = |&c: &usize| self.free.row(self.independent[c]).amax() > 0.0;
        let most = (0..all.len()).filter(is_free).max_by(|&a, &b| all[a].abs().total_cmp(&all[b].abs()));
        let (system, time) = (self.state.system(), self.state.t());
        let coordinate = most.map_or("", |c| system.coordinate_name(self.independent[c])).to_string();
        Error::NoEquilibrium { coordinate, force: most.map_or(0.0, |c| all[c]), time }
    }
}
