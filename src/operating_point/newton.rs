//! Newton's method for an equilibrium: k δ = g in the free motions, with steps shortened until |g| decreases.
//!
//! |g|² = gᵀ g is twice the energy that the forces would give to accelerations, so it does not depend on the choice of coordinates. Motions without
//! stiffness are left out of the steps; whether they are neutral or unbalanced is decided at the end.

use nalgebra::{DVector, SVD};

use super::statics::{Balance, Statics};
use crate::Error;
use crate::error::quoted;
use crate::number::largest;
use crate::redundancy::decomposition;

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
            let Some(by) = here.newton_step() else { return Ok(None) };
            let (of, size) = (by.amax(), here.size());
            if of <= ROUNDING * size || of >= 0.5 * last && of <= STALLED * size {
                return Ok((!here.is_pushed()).then_some(here));
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

    /// The largest entry of k, or the smallest positive number.
    pub(super) fn scale(&self) -> f64 {
        self.stiffness.iter().fold(0.0, |most: f64, x| most.max(x.abs())).max(f64::MIN_POSITIVE)
    }

    /// The change of all coordinates in a step of Newton's method, without motions that have no stiffness.
    fn newton_step(&self) -> Option<DVector<f64>> {
        if self.force.is_empty() {
            return Some(DVector::zeros(self.forces.len()));
        }
        let svd = decomposition(&self.stiffness / self.scale())?;
        let most = svd.singular_values.amax();
        svd.solve(&(&self.force / self.scale()), NEUTRAL * most).ok().map(|step| &self.free * step)
    }

    /// Changes of all coordinates in motions without stiffness, each with the force on it.
    fn neutral(&self) -> Vec<(DVector<f64>, f64)> {
        let Some(SVD { u: Some(left), singular_values, v_t: Some(right) }) = decomposition(&self.stiffness / self.scale())
        else {
            return Vec::new();
        };
        let most = singular_values.amax();
        let neutral = (0..singular_values.len()).filter(|&i| singular_values[i] <= NEUTRAL * most);
        neutral.map(|i| (&self.free * right.row(i).transpose(), left.column(i).dot(&self.force))).collect()
    }

    /// True if a force acts on a motion without stiffness.
    fn is_pushed(&self) -> bool {
        let shifted = SHIFTED * self.scale() * self.size();
        let rounding =
            |motion: &DVector<f64>| BALANCED * self.forces.amax() * motion.map(f64::abs).sum() + shifted / motion.amax();
        self.neutral().iter().any(|(motion, force)| force.abs() > rounding(motion))
    }

    /// Returns an error if an equilibrium is not isolated.
    pub(super) fn check(&self) -> Result<(), Error> {
        let motions = self.neutral();
        let name = |i: usize| quoted(self.state.system().coordinate_name(i));
        let moves = |i: &usize| motions.iter().any(|(motion, _)| motion[*i].abs() > 1e-6 * motion.amax());
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
