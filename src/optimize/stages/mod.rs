//! A primal-dual interior-point method for problems in stages, with a factorisation of the KKT matrix stage by stage: steps along lines with a filter
//! (Wächter and Biegler 2006) and, where these fail, within a trust region (Byrd, Hribar and Nocedal 1999).

mod filter;
mod layout;
mod method;
mod near;
mod newton;
mod problem;
mod riccati;
mod run;
mod search;
mod sensitivity;
mod shooting;
mod tangent_plane;
mod trust_region;

use super::multiple_shooting::MultipleShooting;
use super::problem::{Problem, largest_violation};
use super::{Iterate, Options, Outcome, Reason, Violation, Watcher};
use crate::Error;
pub(super) use layout::owners;
use method::{Method, Start};
use nalgebra::DVector;
use near::Near;
use problem::{Counts, Multipliers, Staged};
use run::{FIRST_MU, NEAR_MU, Run, least_mu};
pub(super) use sensitivity::{Change, derivatives};
use shooting::Segments;

/// Minimises f(x) of multiple shooting by a primal-dual interior-point method with a filter, whose Newton steps are computed segment by segment.
///
/// Work and memory of an iteration grow linearly with the number of segments: a segment needs one right-hand side of a backward sweep for each of
/// its states and constrained outputs, and for its Hessian one forward sweep for each of its controls and states, and one product for each of
/// its other variables. An output of which several segments are parts is a further state of all segments. `Options::stationarity` is absolute, for
/// variables as scaled by [`Free::scaled`](super::Free::scaled) and for f multiplied by a factor with which the largest entry of its gradient at the
/// start is between 0.01 and 1.
///
/// With the feature `rayon`, segments are computed on all cores; the outcome is the same, but reports of progress do not come in order.
///
/// If steps along lines fail far from feasible points, the method restarts within a trust region from the start, and returns to lines when violations have
/// decreased; if they fail otherwise, it continues within a trust region. The history contains all of them. A run ends as [`Reason::Infeasible`] only if
/// the sum of squares of all violations, including those of continuity, is stationary.
///
/// Sources: A. Wächter and L. T. Biegler, Mathematical Programming 106 (2006), 25–57, for the filter and the barrier parameter; R. H. Byrd,
/// M. E. Hribar and J. Nocedal, SIAM Journal on Optimization 9 (1999), 877–900, for the trust region.
///
/// # Errors
/// Invalid sizes, bounds or options, or a problem without Hessian products.
pub fn stages(
    problem: &mut MultipleShooting,
    start: &[f64],
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    run(problem, (start, None), Cost::Stated, options, watch)
}

/// Seeks a point that satisfies all constraints near a start, with almost the same duration and design variables.
///
/// # Errors
/// As [`stages`].
pub(super) fn feasible(
    problem: &mut MultipleShooting,
    start: &[f64],
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    run(problem, (start, None), Cost::Distance, options, watch)
}

/// The function that the method minimises.
#[derive(Clone, Copy)]
enum Cost {
    /// The cost of the problem.
    Stated,
    /// The distance from the start.
    Distance,
}

/// A minimum of a similar problem.
#[derive(Clone)]
pub(super) struct Nearby {
    /// The derivatives of its Lagrangian by the variables.
    pub slopes: Vec<f64>,
    /// The multipliers of its outputs.
    pub multipliers: Vec<f64>,
}

/// As [`stages`], from a start near the minimum of a similar problem.
///
/// # Errors
/// As `stages`.
pub(super) fn stages_near(
    problem: &mut MultipleShooting,
    (start, near): (&[f64], &Nearby),
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    run(problem, (start, Some(near)), Cost::Stated, options, watch)
}

fn run(
    problem: &mut MultipleShooting,
    (start, near): (&[f64], Option<&Nearby>),
    cost: Cost,
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    options.fit(problem, start)?;
    let mut segments = Segments::new(problem);
    let mut run = Run::new(options, watch);
    let (mut v, mut reason) = (segments.point(start), Reason::NoStart);
    let mut multipliers = Multipliers::zeros(segments.shape());
    let begin = segments.begin(near, options);
    let mut distance;
    let begun = match (segments.with_sums(&mut v), cost) {
        (Err(error), _) => Err(error),
        (Ok(()), Cost::Stated) => Method::new(&mut segments, &v, &begin),
        (Ok(()), Cost::Distance) => {
            distance = Near::new(&mut segments, &v);
            Method::new(&mut distance, &v, &begin)
        }
    };
    match begun {
        Err(error @ Error::NoSecondDerivatives { .. }) => return Err(error),
        Err(error) => {
            run.fail(error);
            if run.is_interrupted() {
                reason = Reason::Interrupted;
            }
        }
        Ok(mut method) => {
            let end = solved(&mut run, &mut method, (&v, &begin))?;
            (v, multipliers, reason) = (end.v, end.multipliers, end.reason);
        }
    }
    let (x, multipliers) = (segments.x(&v), segments.multipliers(&multipliers));
    let Counts { evaluations, gradients, products } = segments.counts();
    let intervals = problem.constraints();
    let mut constraints = vec![f64::INFINITY; intervals.len()];
    // The problem is left with the motion of the solution.
    let value = problem.evaluate(&x, &mut constraints).unwrap_or(f64::INFINITY);
    let violation = largest_violation(&intervals, &constraints);
    let Run { history, failures, first_failure, halved, .. } = run;
    let violated = Violation::all(problem, &constraints, options.violation);
    Ok(Outcome {
        x,
        value,
        constraints,
        violated,
        violation,
        multipliers,
        reason,
        iterations: history.len().saturating_sub(1),
        evaluations,
        gradients,
        products,
        history,
        warnings: problem.warnings(),
        halved,
        failures,
        first_failure,
    })
}

impl Segments<'_> {
    /// The beginning of the method, near a minimum of a similar problem if there is one.
    fn begin(&self, near: Option<&Nearby>, options: &Options) -> Start {
        match near {
            None => Start::Far(FIRST_MU),
            Some(near) => Start::Near(self.slopes(&near.slopes, &near.multipliers), [least_mu(options), NEAR_MU]),
        }
    }
}

/// The end of a run.
struct End {
    v: Vec<DVector<f64>>,
    multipliers: Multipliers,
    reason: Reason,
    at: Option<Iterate>,
}

impl End {
    fn of(run: &Run<'_, '_>, method: &Method<'_>, reason: Reason) -> Self {
        let mut multipliers = method.multipliers.clone();
        multipliers.scale(1.0 / method.scale);
        End { v: method.v(&method.y), multipliers, reason, at: run.history.last().copied() }
    }

    /// This end if it is converged, or better than another: feasible with a lower value, or with a smaller violation; else the other one, with this reason.
    fn or(self, other: End, allowed: f64) -> End {
        let key = |end: &End| end.at.map_or([f64::INFINITY; 2], |at| [(at.violation - allowed).max(0.0), at.value]);
        let is_better = self.reason.is_converged() || self.reason == Reason::Interrupted || key(&self) <= key(&other);
        if is_better { self } else { End { reason: self.reason, ..other } }
    }
}

/// Solves by steps along lines and, if these fail far from feasible points, within a trust region from the start, and along lines again from where they may lead
/// on; if they fail otherwise, within a trust region from the last point.
///
/// # Errors
/// A problem without second derivatives.
fn solved(run: &mut Run<'_, '_>, method: &mut Method<'_>, (start, begin): (&[DVector<f64>], &Start)) -> Result<End, Error> {
    let begins_near = matches!(begin, Start::Near(..));
    let mut reason = run.along_lines(method, begins_near)?;
    let mut best = End::of(run, method, reason);
    if !run.falls_back(reason) {
        return Ok(best);
    }
    if !run.is_near() {
        if let Err(error) = method.restart(start, begin) {
            return Ok(failed(run, error, best));
        }
        let found = run.within_region(method, true)?;
        best = End::of(run, method, found.unwrap_or(reason)).or(best, run.allowed());
        if found.is_some() {
            return Ok(best);
        }
        reason = run.along_lines(method, begins_near)?;
        best = End::of(run, method, reason).or(best, run.allowed());
        if !run.falls_back(reason) {
            return Ok(best);
        }
    }
    let last = best.v.clone();
    if let Err(error) = method.restart(&last, begin) {
        return Ok(failed(run, error, best));
    }
    let reason = run.within_region(method, false)?.unwrap_or(reason);
    Ok(End::of(run, method, reason).or(best, run.allowed()))
}

/// The end of a run that cannot restart.
fn failed(run: &mut Run<'_, '_>, error: Error, end: End) -> End {
    run.fail(error);
    let reason = if run.is_interrupted() { Reason::Interrupted } else { end.reason };
    End { reason, ..end }
}
