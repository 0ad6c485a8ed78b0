//! The least change of variables with which a motion satisfies its constraints again.
//!
//! The error of a state grows along an unstable motion: a motion differs from the joined segments with the same inputs, although these meet to
//! rounding error. Newton's method removes the difference if it is small.

use nalgebra::{DMatrix, DVector};

use super::super::MotionProblem;
use super::super::problem::{Interval, Problem, largest_violation};
use super::super::projection::Projection;
use super::super::trust_region::Linearised;
use crate::Error;

/// Largest number of Newton steps, each of which must reduce the largest violation to this fraction.
const NEWTON: usize = 10;
const REDUCED: f64 = 0.5;
/// Values are at a bound if they are closer to it than this fraction of its size, or of 1 if it is smaller.
const BESIDE: f64 = 1e-6;
/// The largest change of a variable, relative to its size or to 1: a minimum remains one to first order.
const MOST: f64 = 1e-4;

/// The point near x at which all constraints hold within a tolerance; `None` if Newton's method finds none. Variables at their bounds stay there. The
/// problem is left at the last point that was tried.
///
/// # Errors
/// A motion that cannot be computed.
pub(super) fn corrected(problem: &mut MotionProblem, x: &[f64], allowed: f64) -> Result<Option<Vec<f64>>, Error> {
    let (bounds, intervals) = (problem.bounds(), problem.constraints());
    let (mut to, mut c, mut last) = (x.to_vec(), vec![0.0; intervals.len()], f64::INFINITY);
    for _ in 0..=NEWTON {
        problem.evaluate(&to, &mut c)?;
        let violation = largest_violation(&intervals, &c);
        if violation <= allowed {
            return Ok(Some(to));
        }
        // False for NaN.
        let is_reduced = violation <= REDUCED * last;
        if !is_reduced {
            return Ok(None);
        }
        last = violation;
        let step = step(problem, &to, (&bounds, &intervals), &c)?;
        to.iter_mut().zip(&step).zip(&bounds).for_each(|((to, d), of)| *to = of.nearest(*to + d));
        let is_near = to.iter().zip(x).all(|(to, x)| (to - x).abs() <= MOST * size(*x));
        if !is_near {
            return Ok(None);
        }
    }
    Ok(None)
}

/// The Newton step for the constraints that are violated or at a bound.
fn step(
    problem: &mut MotionProblem,
    x: &[f64],
    (bounds, intervals): (&[Interval], &[Interval]),
    c: &[f64],
) -> Result<DVector<f64>, Error> {
    let rows: Vec<usize> = (0..c.len()).filter(|&j| is_at_bound(&intervals[j], c[j])).collect();
    let excess = DVector::from_iterator(rows.len(), rows.iter().map(|&j| c[j] - intervals[j].nearest(c[j])));
    let mut jacobian = DMatrix::zeros(rows.len(), x.len());
    problem.jacobian(&rows, &mut jacobian)?;
    let scale = |(x, of): (&f64, &Interval)| if is_at_bound(of, *x) { 0.0 } else { size(*x) };
    let scales = DVector::from_iterator(x.len(), x.iter().zip(bounds).map(scale));
    Ok(Projection::new(&jacobian, scales.as_slice()).least_change(&excess).component_mul(&scales))
}

fn size(x: f64) -> f64 {
    x.abs().max(1.0)
}

/// True if a value is at a bound of its interval, or outside.
fn is_at_bound(of: &Interval, x: f64) -> bool {
    let is_beside = |bound: f64| bound.is_finite() && (x - bound).abs() <= BESIDE * size(bound);
    of.violation(x) > 0.0 || is_beside(of.least) || is_beside(of.most)
}

#[cfg(test)]
mod tests {
    use super::super::super::{Free, Guess, Options, Variables, silent, solve};
    use super::*;
    use crate::{Grid, Inputs, Settings, scenes::CartPendulum};

    /// The largest force, N; it is reached.
    const FORCE: f64 = 1.25;

    fn problem() -> MotionProblem {
        let mut cart = CartPendulum::with_links(1).mechanism();
        cart.scene.effort("effort", cart.force, 1e-4);
        let end = cart.scene.end_state(cart.cart.coordinates[0]);
        let system = cart.scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
        let free = vec![Free::control(cart.force).within(-FORCE, FORCE)];
        let variables = Variables::new(&system, &inputs, free).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
        problem.constrain(end.position, Interval::equal(0.15));
        problem.constrain(end.rate, Interval::ZERO);
        problem
    }

    #[test]
    fn a_small_violation_is_removed_and_a_large_one_is_not() {
        let mut problem = problem();
        let options = Options::default();
        let best = solve(&mut problem, Guess::Straight, &options, &mut silent).expect("fits").outcome;
        assert!(best.reason.is_converged(), "{best}");
        assert!(best.x.iter().any(|u| FORCE - u.abs() <= 1e-3), "{:?}", best.x);
        let off = |by: f64| best.x.iter().map(|u| if FORCE - u.abs() > 1e-2 { u + by } else { *u }).collect::<Vec<f64>>();
        let x = corrected(&mut problem, &off(1e-5), options.violation).expect("motions").expect("a point");
        let mut c = vec![0.0; problem.constraints().len()];
        let value = problem.evaluate(&x, &mut c).expect("a motion");
        assert!(largest_violation(&problem.constraints(), &c) <= options.violation, "{c:?}");
        assert!((value - best.value).abs() <= 1e-6 * best.value, "{value} {}", best.value);
        assert!(x.iter().all(|u| u.abs() <= FORCE), "{x:?}");
        assert_eq!(corrected(&mut problem, &off(0.1), options.violation).expect("motions"), None);
    }
}
