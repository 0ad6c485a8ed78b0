//! Detection of constraints without multipliers: their gradients vanish, or become linearly dependent, where the constraints hold.

use nalgebra::{DMatrix, DVector};

use super::counted::Counted;
use super::norm::norm;
use super::projection::Projection;
use super::trust_region::Linearised;
use crate::Error;
use crate::number::largest;

/// Multipliers do not exist if a Newton step towards the constraints leaves more than the fraction `LEFT` of the violation and increases a multiplier
/// by at least the factor `GROWTH`. If a constraint is a power c = hᵐ, the step leaves (1 − 1/m)ᵐ ≥ ¼ and increases w by (1 − 1/m)¹⁻ᵐ ≥ 2.
const LEFT: f64 = 0.1;
const GROWTH: f64 = 1.5;
/// Instead of a Newton step shorter than this, relative to the variables, whose result is rounding error, a step of this length along the forces of the
/// constraints is tried: multipliers that it changes by the factor `GROWTH` are not determined.
const SHORTEST: f64 = 1e-8;
/// Singular values below this fraction of the largest are zero.
const SINGULAR: f64 = 1e-15;
/// A multiplier matters if it contributes more than this fraction of the gradient of f.
const MATTERS: f64 = 1e-3;

/// True if multipliers grow without bound as violations decrease from those at x, where constraints hold within the tolerance. A gradient of f up to
/// `small` needs no multipliers. The problem may be left at another point.
///
/// # Errors
/// Derivatives that cannot be computed.
pub(super) fn multipliers_diverge(
    problem: &mut Counted,
    (x, multipliers): (&[f64], &[f64]),
    small: f64,
) -> Result<bool, Error> {
    if !problem.ensure(x) {
        return Ok(false);
    }
    let most = largest(multipliers);
    let rows: Vec<usize> =
        problem.asked().filter(|&j| problem.intervals[j].is_equality() || multipliers[j].abs() > MATTERS * most).collect();
    if rows.is_empty() || x.is_empty() {
        return Ok(false);
    }
    let scales = scales(problem, x);
    let (here, excess) = (Linear::at(problem, &rows, &scales)?, excess(problem, &rows));
    let size = if largest(x) > 0.0 { largest(x) } else { 1.0 };
    let most = small.max(MATTERS * here.gradient.amax());
    let matters: Vec<bool> = here.forces().iter().map(|force| *force > most).collect();
    if !matters.contains(&true) {
        return Ok(false);
    }
    let (of_x, shortest) = (DVector::from_column_slice(&scales), SHORTEST * size);
    let newton = here.constraints.least_change(&excess).component_mul(&of_x);
    let is_newton = newton.amax() > shortest;
    let along = here.constraints.times_transposed(&here.multipliers).component_mul(&of_x);
    let step = if is_newton { newton } else { &along * (shortest / along.amax()) };
    let mut to: Vec<f64> = x.iter().zip(&step).map(|(x, d)| x + d).collect();
    problem.project(&mut to);
    if !problem.evaluate(&to).is_finite() {
        return Ok(false);
    }
    if is_newton && norm(self::excess(problem, &rows).as_slice()) <= LEFT * norm(excess.as_slice()) {
        return Ok(false);
    }
    let there = Linear::at(problem, &rows, &scales)?;
    let mut pairs = here.multipliers.iter().zip(&there.multipliers).zip(matters).filter(|(_, matters)| *matters);
    Ok(pairs.any(|((before, after), _)| {
        let (before, after) = (before.abs(), after.abs());
        after >= GROWTH * before || !is_newton && before >= GROWTH * after
    }))
}

/// The gradient of f, some constraints and their multipliers in scaled variables.
struct Linear {
    gradient: DVector<f64>,
    constraints: Projection,
    multipliers: DVector<f64>,
}

impl Linear {
    /// At the last evaluated point.
    fn at(problem: &mut Counted, rows: &[usize], scales: &[f64]) -> Result<Self, Error> {
        let mut gradient = DVector::zeros(scales.len());
        problem.gradient(1.0, &vec![0.0; problem.c.len()], gradient.as_mut_slice())?;
        gradient.component_mul_assign(&DVector::from_column_slice(scales));
        let constraints = Projection::new(&problem.jacobian(rows)?, scales);
        let multipliers = smallest_multipliers(&constraints.a, &gradient);
        Ok(Linear { gradient, constraints, multipliers })
    }

    /// The largest entry of each multiplier times the gradient of its constraint.
    fn forces(&self) -> Vec<f64> {
        self.constraints.a.row_iter().zip(&self.multipliers).map(|(row, w)| (row * *w).amax()).collect()
    }
}

/// The smallest w that minimises ‖g + Aᵀw‖: of constraints that say the same, one with a vanishing gradient has none.
fn smallest_multipliers(a: &DMatrix<f64>, gradient: &DVector<f64>) -> DVector<f64> {
    let factors = a.transpose().qr();
    let svd = factors.r().svd(true, true);
    let right = -(factors.q().tr_mul(gradient));
    // Fails only without singular vectors.
    svd.solve(&right, SINGULAR * svd.singular_values.amax()).unwrap_or_else(|_| DVector::zeros(a.nrows()))
}

/// The violations of some constraints at the last evaluated point.
fn excess(problem: &Counted, rows: &[usize]) -> DVector<f64> {
    let all = problem.excess();
    DVector::from_iterator(rows.len(), rows.iter().map(|&j| all[j]))
}

/// The distance of each variable from its nearest bound, at most the size of the largest variable, as a fraction of this size; 0 for fixed ones.
fn scales(problem: &Counted, x: &[f64]) -> Vec<f64> {
    let size = if largest(x) > 0.0 { largest(x) } else { 1.0 };
    let pairs = problem.bounds.iter().zip(x);
    pairs
        .map(|(of, x)| if of.is_equality() { 0.0 } else { (x - of.least).min(of.most - x).clamp(0.0, size) / size })
        .collect()
}
