//! Scale-independent criteria for small gradients (relative to those of f), and for small μ and small distances from bounds (by changes of f).

use nalgebra::DVector;

use super::super::super::counted::Counted;
use super::super::super::outcome::largest_change;
use super::{Method, product, slope};
use crate::Error;
use crate::number::largest;

/// μ is small if it is this fraction of the change of f that corresponds to a small gradient.
const GAP: f64 = 0.1;
/// Largest length, in units: variables beyond it may grow without bound, and every length is small relative to them.
const FARTHEST: f64 = 1e3;
/// The smallest reference for small gradients, relative to the gradient at the start or to 1, whichever is less: at a minimum where ∇f and ∇²f vanish,
/// they give no scale.
const SMALLEST: f64 = 1e-3;
/// Rounding error of a gradient, relative to its terms.
const ROUNDED: f64 = 1e-13;

impl Method {
    /// The entries of variables; 0 for fixed variables.
    pub(super) fn moving(&self, of: &[f64]) -> Vec<f64> {
        let entries = self.barrier.bounds.iter().zip(of).take(self.start.len());
        entries.map(|(bound, x)| if bound.is_equality() { 0.0 } else { *x }).collect()
    }

    /// Reference for small gradients of the Lagrangian: ∇f without fixed variables. If constraints leave no room, multipliers are arbitrary.
    pub(in super::super) fn scale(&self) -> f64 {
        largest(&self.moving(self.gradient.as_slice()))
    }

    /// Reference for the tolerance of stationarity: the largest entry of ∇f here; or of its terms ∇²f x, but not more than the largest gradient at the
    /// start, which may be far away, and steep.
    ///
    /// # Errors
    /// Derivatives that cannot be computed.
    pub(in super::super) fn reference(&self, problem: &mut Counted, at_start: f64) -> Result<f64, Error> {
        let scale = self.scale();
        if at_start <= scale {
            return Ok(scale);
        }
        let (x, mut terms) = (self.moving(self.x().as_slice()), vec![0.0; self.start.len()]);
        problem.ensure(self.x().as_slice());
        slope(problem)?;
        problem.product(&x, &mut terms)?;
        let terms = largest(&self.moving(&terms)).max(SMALLEST * at_start.min(1.0));
        Ok(scale.max(terms.min(at_start)))
    }

    /// The change of f as a variable moves from zero, or from the start, to its current value; at least the decrease at the start.
    fn change(&self) -> f64 {
        let sizes = self.y.iter().zip(&self.start).map(|(x, start)| x.abs().max((x - start).abs()));
        let changes = self.moving(self.gradient.as_slice()).into_iter().zip(sizes).map(|(g, size)| g.abs() * size);
        changes.fold(self.fall, f64::max)
    }

    /// The length scale on which f changes: a change of f divided by its gradient.
    pub(super) fn length(&self) -> f64 {
        let length = self.change() / self.scale().max(self.first_slope);
        if length > 0.0 { length.min(FARTHEST * self.barrier.unit) } else { self.barrier.unit }
    }

    /// The μ that corresponds to a small gradient: f may exceed its minimum by μ for each active bound.
    pub(in super::super) fn small_mu(&self, gradient: f64) -> f64 {
        GAP * gradient * self.length()
    }

    /// True if the gradient of the Lagrangian, and the contribution of the barrier to it, are within the tolerance.
    pub(in super::super) fn is_small(&self, stationarity: f64, asked: f64) -> bool {
        stationarity <= asked && self.barrier.mu <= self.small_mu(asked)
    }

    /// True if x is so far from the start that `length` is below its rounding error.
    pub(in super::super) fn is_far(&self, length: f64) -> bool {
        // If the start is a minimum up to rounding, the unit is rounding error, too.
        let size = largest(&self.start);
        let length = length.max(if size > 0.0 { size } else { 1.0 });
        f64::EPSILON * largest_change(self.x().as_slice(), &self.start) > length
    }

    /// True if the gradient of the Lagrangian, in scaled units, is below the rounding error of its terms. Finite differences must confirm its slopes,
    /// which are arbitrarily large near a fold.
    pub(in super::super) fn is_rounding(&self, problem: &mut Counted, stationarity: f64) -> Result<bool, Error> {
        Ok(stationarity <= self.rounding(problem)? && self.confirms(problem))
    }

    /// Rounding error of the gradient of the Lagrangian, in scaled units: that of its terms, and that of the variables, which change it by H y.
    fn rounding(&self, problem: &mut Counted) -> Result<f64, Error> {
        problem.ensure(self.x().as_slice());
        self.prepare_products(problem)?;
        let ones = DVector::from_element(self.y.len(), 1.0);
        let moved = product(problem, &self.y, &ones, &vec![0.0; self.y.len()])?;
        let terms = self.gradient.abs() + self.jacobian.abs().tr_mul(&self.multipliers.abs()) + moved.abs();
        let length = self.length();
        let shares = self.barrier.scales(self.y.as_slice(), length).into_iter().zip(&self.scales);
        let shares = shares.map(|(share, scale)| if *scale > 0.0 { share / length } else { 0.0 });
        Ok(ROUNDED * terms.iter().zip(shares).fold(0.0, |most: f64, (x, share)| most.max(x * share)))
    }

    /// True if finite differences confirm the slopes of the term by which the Lagrangian changes most.
    fn confirms(&self, problem: &mut Counted) -> bool {
        let (x, n) = (self.x(), self.x().len());
        let size = |slopes: &[f64], weight: f64| -> f64 {
            slopes.iter().zip(&x).map(|(slope, x)| (weight * slope * x).abs()).sum()
        };
        let of_f = self.gradient.rows(0, n).as_slice().to_vec();
        let of_rows = self.jacobian.row_iter().zip(&self.multipliers).zip(&self.rows);
        let of_rows = of_rows.map(|((row, w), &j)| (Vec::from_iter(row.columns(0, n).iter().copied()), *w, Some(j)));
        let sizes = of_rows.map(|(slopes, w, constraint)| (size(&slopes, w), constraint, slopes));
        let first = (size(&of_f, 1.0), None, of_f);
        let (_, constraint, slopes) = sizes.fold(first, |most, next| if next.0 > most.0 { next } else { most });
        problem.confirms(x.as_slice(), constraint, &slopes)
    }
}
