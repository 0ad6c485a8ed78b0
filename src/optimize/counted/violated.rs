//! What the violation of constraints at a point is: rounding, the least there is nearby, or neither.

use nalgebra::DVector;

use super::Counted;
use crate::Error;
use crate::number::largest;

/// The share of the terms of a constraint that may be rounding.
const ROUNDED: f64 = 1e-13;
/// The cosine of violations and of what a variable changes in them, above which that variable would make them less: not at their least, but at a wall.
const LEADS_ON: f64 = 0.1;
/// A variable that as far as its bound would change them by no more than this share does not lead on.
const NO_ROOM: f64 = 1e-4;
/// Where variables change by this share of them, f or a constraint changes by at least the other share of what slopes foresee, if they are right.
const SHARE: f64 = 1e-8;
const AGREES: f64 = 0.5;

impl Counted<'_> {
    /// Whether rounding of their terms, and of steps of such a reach, may leave all that constraints are violated by, at the point x that was evaluated last.
    ///
    /// # Errors
    /// Those of a Jacobian.
    pub(in super::super) fn holds_to_rounding(&mut self, x: &[f64], reach: f64) -> Result<bool, Error> {
        let violated: Vec<usize> = (0..self.c.len()).filter(|&j| self.intervals[j].violation(self.c[j]) > 0.0).collect();
        let jacobian = self.jacobian(&violated)?;
        Ok(violated.iter().zip(jacobian.row_iter()).all(|(&j, row)| {
            let terms = row.iter().zip(x).map(|(slope, x)| (slope * x).abs()).sum::<f64>() + self.c[j].abs();
            self.intervals[j].violation(self.c[j]) <= ROUNDED * (terms + row.norm() * reach)
        }))
    }

    /// Whether what rounding may leave at the point x that was evaluated last is so: beside a fold slopes are of any size, and make anything rounding. Of the
    /// constraint that is violated most they must be those of differences, unless it is rounding without them.
    ///
    /// # Errors
    /// Those of a Jacobian.
    pub(in super::super) fn is_rounding(&mut self, x: &[f64]) -> Result<bool, Error> {
        let violations = self.intervals.iter().zip(&self.c).map(|(of, c)| of.violation(*c));
        let most = violations.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((j, _)) = most.filter(|&(j, violation)| violation > ROUNDED * self.c[j].abs()) else { return Ok(true) };
        let slopes = self.jacobian(&[j])?;
        Ok(self.confirms(x, Some(j), slopes.as_slice()))
    }

    /// Whether differences confirm that slopes of a constraint, or of f, are as large at the point x, which is evaluated again behind them.
    pub(in super::super) fn confirms(&mut self, x: &[f64], constraint: Option<usize>, slopes: &[f64]) -> bool {
        let value = |of: &mut Self, x: &[f64]| {
            let f = of.evaluate(x);
            constraint.filter(|_| f.is_finite()).map_or(f, |j| of.c[j])
        };
        let here = value(self, x);
        // Where there is no value, nothing is told.
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

    /// Whether violations end, at the point x that was evaluated last, where their squares are least, and not beside points without a value,
    /// or a jump that a change within such a reach would have to pass: a step may have several solutions.
    ///
    /// # Errors
    /// Those of a Jacobian.
    pub(in super::super) fn is_least_violated(&mut self, x: &[f64], reach: f64) -> Result<bool, Error> {
        let far = if self.failures + self.halved == 0 { reach.max(largest(x)) } else { f64::INFINITY };
        Ok(!self.leads_on(x, far)?)
    }

    /// Whether some variable that its bounds let go, no farther than such a reach, would make violations less, at the point x that was evaluated last: the sum
    /// of their squares.
    ///
    /// # Errors
    /// Those of a Jacobian.
    fn leads_on(&mut self, x: &[f64], reach: f64) -> Result<bool, Error> {
        let excess = self.excess();
        let violated: Vec<usize> = (0..excess.len()).filter(|&j| excess[j] != 0.0).collect();
        let jacobian = self.jacobian(&violated)?;
        let excess = DVector::from_iterator(violated.len(), violated.iter().map(|&j| excess[j]));
        let leads_on = |i: usize| {
            let (slope, column) = (jacobian.column(i).dot(&excess), jacobian.column(i).norm());
            // A method that keeps inside of bounds never is at one.
            let room = if slope > 0.0 { x[i] - self.bounds[i].least } else { self.bounds[i].most - x[i] };
            slope.abs() * room.min(reach) > NO_ROOM * excess.norm_squared()
                && slope.abs() > LEADS_ON * column * excess.norm()
        };
        Ok((0..x.len()).any(leads_on))
    }
}
