//! The search for an acceptable point along a step, with second-order corrections.

use super::filter::{Accepted, Filter, Pair};
use super::method::Method;
use super::newton::{Newton, Step};
use super::problem::{Residuals, Values};
use super::run::Run;

/// Shortest step that is tried, relative to the longest one within the bounds.
const SHORTEST: f64 = 1e-6;
/// Largest number of second-order corrections of a step, and the least reduction of the violation by each.
const CORRECTIONS: usize = 4;
const REDUCED: f64 = 0.99;

/// A point on a step.
pub(super) struct Trial {
    pub step: Step,
    /// The fraction of the step.
    pub alpha: f64,
    pub y: Vec<f64>,
    pub values: Values,
    pub accepted: Accepted,
}

/// The point at a fraction of the longest step within the bounds; the step if the point has no values.
pub(super) fn trial(run: &mut Run<'_, '_>, method: &mut Method<'_>, step: Step, fraction: f64) -> Result<Trial, Step> {
    let zero = vec![0.0; step.y.len()];
    let alpha = fraction * method.barrier.most(method.share(), &method.y, &zero, &step.y);
    let y: Vec<f64> = method.y.iter().zip(&step.y).map(|(y, d)| y + alpha * d).collect();
    match method.problem.evaluate(&method.v(&y)) {
        Ok(values) => Ok(Trial { step, alpha, y, values, accepted: Accepted::Filtered }),
        Err(error) => {
            run.fail(error);
            Err(step)
        }
    }
}

/// The first acceptable point along the step for the residuals of the current point, or along its second-order corrections; the step if there is
/// none.
pub(super) fn search(
    run: &mut Run<'_, '_>,
    method: &mut Method<'_>,
    newton: &Newton<'_>,
    filter: &Filter,
    (before, residuals): (Pair, &Residuals),
) -> Result<Trial, Step> {
    let mut step = newton.step(method, residuals);
    let slope = method.slope(&step);
    let mut fraction = 1.0;
    while fraction > SHORTEST && !run.is_interrupted() {
        step = match trial(run, method, step, fraction) {
            Ok(found) => {
                let after = method.pair(&found.y, &found.values);
                let accepts = |after: Pair| filter.accepts(before, after, found.alpha, slope);
                if let Some(accepted) = accepts(after) {
                    return Ok(Trial { accepted, ..found });
                }
                if fraction == 1.0 && after.violation >= before.violation {
                    let corrected = corrected(run, method, newton, residuals, &found, &accepts);
                    if let Some(corrected) = corrected {
                        return Ok(corrected);
                    }
                }
                found.step
            }
            Err(step) => step,
        };
        fraction *= 0.5;
    }
    Err(step)
}

/// Second-order corrections: steps whose right-hand sides contain the residuals at the trial point.
fn corrected(
    run: &mut Run<'_, '_>,
    method: &mut Method<'_>,
    newton: &Newton<'_>,
    residuals: &Residuals,
    first: &Trial,
    accepts: &dyn Fn(Pair) -> Option<Accepted>,
) -> Option<Trial> {
    let mut sums = residuals.clone();
    sums.scale_and_add(first.alpha, &method.residuals(&first.y, &first.values));
    let mut last = method.pair(&first.y, &first.values).violation;
    for _ in 0..CORRECTIONS {
        let found = trial(run, method, newton.step(method, &sums), 1.0).ok()?;
        let after = method.pair(&found.y, &found.values);
        if let Some(accepted) = accepts(after) {
            return Some(Trial { accepted, ..found });
        }
        if after.violation > REDUCED * last {
            return None;
        }
        last = after.violation;
        sums.scale_and_add(found.alpha, &method.residuals(&found.y, &found.values));
    }
    None
}
