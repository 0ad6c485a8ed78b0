//! Classification of the violations at a point: rounding error, a local minimum, or neither.

use nalgebra::DVector;

use super::Counted;
use crate::Error;
use crate::number::largest;

/// Rounding error of a constraint, relative to its terms.
const ROUNDED: f64 = 1e-13;
/// A variable can reduce violations if the cosine between them and its effect on them exceeds this: they are at a wall, not minimal.
const LEADS_ON: f64 = 0.1;
/// A variable that changes the violations by no more than this fraction up to its bound cannot reduce them.
const NO_ROOM: f64 = 1e-4;
/// Slopes are confirmed if a relative change of the variables by `SHARE` changes f or a constraint by at least `AGREES` times the prediction.
const SHARE: f64 = 1e-8;
const AGREES: f64 = 0.5;

impl Counted<'_> {
    /// True if the violations at the last evaluated point x may be rounding error of their terms, or of steps of length `reach`.
    ///
    /// # Errors
    /// A Jacobian that cannot be computed.
    pub(in super::super) fn holds_to_rounding(&mut self, x: &[f64], reach: f64) -> Result<bool, Error> {
        let violated: Vec<usize> = (0..self.c.len()).filter(|&j| self.intervals[j].violation(self.c[j]) > 0.0).collect();
        let jacobian = self.jacobian(&violated)?;
        Ok(violated.iter().zip(jacobian.row_iter()).all(|(&j, row)| {
            let terms = row.iter().zip(x).map(|(slope, x)| (slope * x).abs()).sum::<f64>() + self.c[j].abs();
            self.intervals[j].violation(self.c[j]) <= ROUNDED * (terms + row.norm() * reach)
        }))
    }

    /// True if violations that may be rounding error at the last evaluated point x are so indeed. Near a fold, slopes are arbitrarily large and would
    /// explain any violation; so finite differences must confirm those of the most violated constraint, unless it is rounding error without them.
    ///
    /// # Errors
    /// A Jacobian that cannot be computed.
    pub(in super::super) fn is_rounding(&mut self, x: &[f64]) -> Result<bool, Error> {
        let violations = self.intervals.iter().zip(&self.c).map(|(of, c)| of.violation(*c));
        let most = violations.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((j, _)) = most.filter(|&(j, violation)| violation > ROUNDED * self.c[j].abs()) else { return Ok(true) };
        let slopes = self.jacobian(&[j])?;
        Ok(self.confirms(x, Some(j), slopes.as_slice()))
    }

    /// True if finite differences confirm the slopes of a constraint, or of f, at the point x, which is evaluated again afterwards.
    pub(in super::super) fn confirms(&mut self, x: &[f64], constraint: Option<usize>, slopes: &[f64]) -> bool {
        let value = |of: &mut Self, x: &[f64]| {
            let f = of.evaluate(x);
            constraint.filter(|_| f.is_finite()).map_or(f, |j| of.c[j])
        };
        let here = value(self, x);
        // Points without a value do not contradict the slopes.
        let is_confirmed = [1.0, -1.0].into_iter().all(|sign| {
            let mut to: Vec<f64> =
                x.iter().zip(slopes).map(|(x, slope)| x + sign * SHARE * x.abs() * slope.signum()).collect();
            self.project(&mut to);
            let foreseen: f64 = to.iter().zip(x).zip(slopes).map(|((to, x), slope)| (to - x) * slope).sum();
            (value(self, &to) - here).abs() >= AGREES * foreseen.abs() - ROUNDED * here.abs()
        });
        self.evaluate(x);
        is_confirmed
    }

    /// True if the sum of squared violations is minimal at the last evaluated point x; false next to points without a value, or next to a jump that a
    /// change within `reach` would have to pass, since a step may have several solutions.
    ///
    /// # Errors
    /// A Jacobian that cannot be computed.
    pub(in super::super) fn is_least_violated(&mut self, x: &[f64], reach: f64) -> Result<bool, Error> {
        let far = if self.failures + self.halved == 0 { reach.max(largest(x)) } else { f64::INFINITY };
        Ok(!self.leads_on(x, far)?)
    }

    /// True if a change of some variable, within its bounds and by at most `reach`, would reduce the sum of squared violations at the last evaluated
    /// point x.
    ///
    /// # Errors
    /// A Jacobian that cannot be computed.
    fn leads_on(&mut self, x: &[f64], reach: f64) -> Result<bool, Error> {
        let excess = self.excess();
        let violated: Vec<usize> = (0..excess.len()).filter(|&j| excess[j] != 0.0).collect();
        let jacobian = self.jacobian(&violated)?;
        let excess = DVector::from_iterator(violated.len(), violated.iter().map(|&j| excess[j]));
        let leads_on = |i: usize| {
            let (slope, column) = (jacobian.column(i).dot(&excess), jacobian.column(i).norm());
            // A method that stays inside the bounds never reaches one.
            let room = if slope > 0.0 { x[i] - self.bounds[i].least } else { self.bounds[i].most - x[i] };
            slope.abs() * room.min(reach) > NO_ROOM * excess.norm_squared()
                && slope.abs() > LEADS_ON * column * excess.norm()
        };
        Ok((0..x.len()).any(leads_on))
    }
}
