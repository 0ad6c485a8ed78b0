//! [`escape`]: from a stationary point of the violations that is not a minimum to a point with smaller ones.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::super::{Interval, Problem};
use crate::Error;
use crate::number::Random;

/// Largest number of products with the Hessian.
const PRODUCTS: usize = 25;
/// Curvatures below this fraction of the largest one are rounding errors.
const ROUNDING: f64 = 1e-6;
/// Steps of 2^k units for these k are tried, the longest first; one is taken if it reduces f by this fraction.
const LENGTHS: [i32; 2] = [-12, 8];
const LESS: f64 = 1e-3;
/// Variables closer to a bound than this fraction of the interval, or of 1 if that is shorter, are not moved.
const BESIDE: f64 = 1e-3;

/// A point with a smaller f, for a problem without constraints at a stationary point x, along the direction of the smallest curvature; `None` if that is
/// not negative.
///
/// By symmetry, violations may be stationary at a maximum: those of a hanging pendulum whose tip should be above the pivot are. The direction is found by
/// Lanczos' method from a random one.
///
/// # Errors
/// A point without derivatives.
pub(super) fn escape(problem: &mut dyn Problem, x: &[f64]) -> Result<Option<Vec<f64>>, Error> {
    let (bounds, constraints) = (problem.bounds(), &mut vec![0.0; problem.constraints().len()]);
    let f = problem.evaluate(x, constraints)?;
    problem.gradient(1.0, constraints, &mut vec![0.0; x.len()])?;
    let Some(direction) = most_concave(problem, &bounds, x)? else { return Ok(None) };
    let unit = x.iter().fold(1.0f64, |most, x| most.max(x.abs())) / direction.amax();
    for k in (LENGTHS[0]..=LENGTHS[1]).rev() {
        for side in [1.0, -1.0] {
            let step = side * unit * 2f64.powi(k);
            let moved = x.iter().zip(&direction).zip(&bounds).map(|((x, d), of)| of.nearest(x + step * d));
            let moved: Vec<f64> = moved.collect();
            // Points without a value are not lower.
            if problem.evaluate(&moved, constraints).is_ok_and(|found| found < (1.0 - LESS) * f) {
                return Ok(Some(moved));
            }
        }
    }
    Ok(None)
}

/// The direction of the smallest curvature of the function differentiated last, if it is negative.
fn most_concave(problem: &mut dyn Problem, bounds: &[Interval], x: &[f64]) -> Result<Option<DVector<f64>>, Error> {
    let is_free = |(x, of): (&f64, &Interval)| (x - of.least).min(of.most - x) > BESIDE * (of.most - of.least).min(1.0);
    let free = DVector::from_iterator(x.len(), x.iter().zip(bounds).map(|both| f64::from(u8::from(is_free(both)))));
    let mut random = Random::new(0);
    let mut next = free.map(|free| free * random.uniform(-1.0, 1.0));
    let (mut basis, mut diagonal, mut beside): (Vec<DVector<f64>>, Vec<f64>, Vec<f64>) = Default::default();
    let mut product = DVector::zeros(x.len());
    while basis.len() < PRODUCTS {
        let length = next.norm();
        if basis.is_empty() && length == 0.0 || !basis.is_empty() && length <= ROUNDING * diagonal[0].abs() {
            break;
        }
        if !basis.is_empty() {
            beside.push(length);
        }
        let v = next / length;
        problem.product(v.as_slice(), product.as_mut_slice())?;
        product.component_mul_assign(&free);
        diagonal.push(v.dot(&product));
        basis.push(v);
        next = product.clone();
        // Twice, because once loses orthogonality to rounding.
        (0..2).for_each(|_| basis.iter().for_each(|of| next.axpy(-of.dot(&next), of, 1.0)));
    }
    let size = basis.len();
    let at = |i: usize, j: usize| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    };
    if size == 0 {
        return Ok(None);
    }
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(DMatrix::from_fn(size, size, at));
    let least = eigenvalues.imin();
    let is_concave = eigenvalues[least] < -ROUNDING * eigenvalues.amax();
    let sum = |sum, (j, v): (usize, &DVector<f64>)| sum + v * eigenvectors[(j, least)];
    Ok(is_concave.then(|| basis.iter().enumerate().fold(DVector::zeros(x.len()), sum)))
}
