//! What is small, in any units: gradients beside those of f, and μ and distances from bounds by what f changes by.

use nalgebra::DVector;

use super::super::super::counted::Counted;
use super::super::super::outcome::largest_change;
use super::super::step::product;
use super::Method;
use crate::Error;
use crate::number::largest;

/// μ is small where it is this share of what f changes by where gradients are small.
const GAP: f64 = 0.1;
/// Variables that go farther than so many units may go on without end, and nothing is small beside where they are.
const FARTHEST: f64 = 1e3;
/// The share of the terms of a gradient that may be rounding.
const ROUNDED: f64 = 1e-13;

impl Method {
    /// Entries of variables, 0 for what is fixed.
    pub(super) fn moving(&self, of: &[f64]) -> Vec<f64> {
        let entries = self.barrier.bounds.iter().zip(of).take(self.start.len());
        entries.map(|(bound, x)| if bound.is_equality() { 0.0 } else { *x }).collect()
    }

    /// What the gradient of the Lagrangian is small against: f's own by what is not fixed. Multipliers may be of any size where constraints leave no room.
    pub(in super::super) fn scale(&self) -> f64 {
        largest(&self.moving(self.gradient.as_slice()))
    }

    /// What f changes by as a variable goes from zero or from the start to where it is, or fell by at the start.
    fn change(&self) -> f64 {
        let sizes = self.y.iter().zip(&self.start).map(|(x, start)| x.abs().max((x - start).abs()));
        let changes = self.moving(self.gradient.as_slice()).into_iter().zip(sizes).map(|(g, size)| g.abs() * size);
        changes.fold(self.fall, f64::max)
    }

    /// The length by which a gradient changes f.
    pub(super) fn length(&self) -> f64 {
        let length = self.change() / self.scale().max(self.first_slope);
        if length > 0.0 { length.min(FARTHEST * self.barrier.unit) } else { self.barrier.unit }
    }

    /// The μ that is small where such a gradient is: f may be above its least by μ for each bound that holds something.
    pub(in super::super) fn small_mu(&self, gradient: f64) -> f64 {
        GAP * gradient * self.length()
    }

    /// Whether a gradient of the Lagrangian is as small as was asked for, and the barrier's part of it, too.
    pub(in super::super) fn is_small(&self, stationarity: f64, asked: f64) -> bool {
        stationarity <= asked && self.barrier.mu <= self.small_mu(asked)
    }

    /// Whether x is so far from the start that such a length there is rounding.
    pub(in super::super) fn is_far(&self, length: f64) -> bool {
        // Where it begins at a minimum, but for rounding, the unit is rounding, too.
        let size = largest(&self.start);
        let length = length.max(if size > 0.0 { size } else { 1.0 });
        f64::EPSILON * largest_change(self.x().as_slice(), &self.start) > length
    }

    /// Whether a gradient of the Lagrangian, in units of the scales, is as small as rounding of its terms lets it be seen; slopes must be those of
    /// differences, since beside a fold they are of any size.
    pub(in super::super) fn is_rounding(&self, problem: &mut Counted, stationarity: f64) -> Result<bool, Error> {
        Ok(stationarity <= self.rounding(problem)? && self.confirms(problem))
    }

    /// What rounding of its terms, and of the variables, which moves it by H y, may leave of the gradient of the Lagrangian, in units of the scales.
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

    /// Whether differences confirm the slopes of what the Lagrangian changes by most.
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
