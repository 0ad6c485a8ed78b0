//! An attempt in segments: from a guess of the states to a minimum of the problem as one motion.

use super::super::free::Quantity;
use super::super::problem::{Problem, largest_violation};
use super::super::stages::{Nearby, feasible, stages, stages_near};
use super::super::{MotionProblem, MultipleShooting, Options, Outcome, Reason, Violation, Watcher};
use super::apart::apart_from_bounds;
use super::corrected::corrected;
use super::division::most_segments;
use super::guess::{Guess, Line};
use crate::Error;
use crate::number::largest;

/// The search for a feasible motion ends after this many iterations, or with these errors.
const FEASIBLE: usize = 40;
const ROUGH: f64 = 1e-2;
const MET: f64 = 1e-4;
/// The largest numbers of iterations of a way, and of one in haste from a feasible motion.
const MOST: usize = 400;
const MOST_HASTY: usize = 120;
/// The tolerance of violations of joined segments relative to that asked for, and its smallest value, relative to the largest variable if it is above 1.
const EXACT: f64 = 1e-3;
const LEAST: f64 = 1e-13;
/// A result that violates its constraints by more than this as a single motion is not corrected.
const FAR: f64 = 1e-2;
/// The largest number of iterations of joined segments: near the minimum of a similar problem, and from segments that meet.
const MOST_NEAR: usize = 40;
const MOST_JOINED: usize = 100;

/// The reaction of an attempt to a failed search for a feasible motion near its start.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Haste {
    /// Minimise from the start.
    Patient,
    /// Give up.
    Brief,
}

/// Solves the problem in a number of segments, and then as one motion; `None` if it cannot be divided. The problem is left with the motion of the
/// result.
///
/// # Errors
/// A problem without Hessian products.
pub(super) fn in_segments(
    problem: &mut MotionProblem,
    (line, segments, haste): (&Line, usize, Haste),
    options: &Options,
    watch: &mut Watcher,
) -> Result<Option<Outcome>, Error> {
    let Ok(mut shooting) = divided(problem, &apart_from_bounds(problem, line), line, segments) else { return Ok(None) };
    let start = problem.start();
    // The first variables are those of the problem.
    let mut only = |iterate: &_, x: &[f64]| watch(iterate, &x[..start.len()]);
    let is_timed = problem.free().free().iter().any(|free| free.quantity == Quantity::Duration);
    let found = minimised(&mut shooting, (is_timed, haste), options, &mut only)?;
    if !found.reason.is_converged() {
        return Ok(Some(restated(problem, found, &start, options.violation)));
    }
    let found = if problem.solver.system().m() == 0 { found } else { joined(&mut shooting, found, options, &mut only)? };
    Ok(Some(as_stated(problem, found, options)))
}

/// Minimises J as one motion in joined segments, from the minimum of a similar problem; `None` if the motion cannot be divided or has no derivatives.
///
/// # Errors
/// A problem without Hessian products.
pub(super) fn near_optimum(
    problem: &mut MotionProblem,
    known: &Known,
    options: &Options,
    watch: &mut Watcher,
) -> Result<Option<Outcome>, Error> {
    let Ok(At { mut shooting, x, near }) = at_motion(problem, known) else { return Ok(None) };
    let start = problem.start();
    let mut only = |iterate: &_, x: &[f64]| watch(iterate, &x[..start.len()]);
    let found = stages_near(&mut shooting, (&x, &near), &exact(&x, options, MOST_NEAR), &mut only)?;
    if !found.reason.is_converged() {
        return Ok(Some(restated(problem, found, &start, options.violation)));
    }
    Ok(Some(as_stated(problem, found, options)))
}

/// A motion in joined segments, with its variables, and what is known of its minimum.
pub(super) struct At {
    pub(super) shooting: MultipleShooting,
    pub(super) x: Vec<f64>,
    pub(super) near: Nearby,
}

/// The minimum of a similar problem.
pub(super) struct Known {
    pub(super) line: Line,
    pub(super) near: Nearby,
    /// The number of segments, which begin at nodes of the line.
    pub(super) segments: usize,
}

impl Known {
    /// The current motion of a problem as a minimum, for multipliers of the outputs.
    ///
    /// # Errors
    /// A motion without derivatives.
    pub(super) fn of(problem: &mut MotionProblem, multipliers: &[f64]) -> Result<Self, Error> {
        let mut slopes = vec![0.0; problem.variables()];
        problem.gradient(1.0, multipliers, &mut slopes)?;
        let near = Nearby { slopes, multipliers: multipliers.to_vec() };
        Ok(Known { line: Line::of_motion(problem), near, segments: most_segments(problem) })
    }

    /// q and v at all nodes, as a guess.
    pub(super) fn guess(&self) -> Guess {
        Guess::States { q: self.line.q.clone(), v: self.line.v.clone() }
    }
}

/// A known minimum in joined segments.
///
/// # Errors
/// A problem that cannot be divided; a motion that cannot be computed.
pub(super) fn at_motion(problem: &MotionProblem, known: &Known) -> Result<At, Error> {
    let mut shooting = divided(problem, &problem.start(), &known.line, known.segments)?;
    let x = shooting.start();
    let mut constraints = vec![0.0; shooting.constraints().len()];
    shooting.evaluate(&x, &mut constraints)?;
    let x = shooting.join()?;
    let mut near = known.near.clone();
    near.slopes.resize(x.len(), 0.0);
    Ok(At { shooting, x, near })
}

/// The problem at a point in a number of segments that begin at a guess.
///
/// # Errors
/// A problem that cannot be divided; a guess that is not finite.
fn divided(problem: &MotionProblem, x: &[f64], line: &Line, segments: usize) -> Result<MultipleShooting, Error> {
    let mut shooting = MultipleShooting::of(problem, x, (&line.coordinates, segments))?;
    shooting.guess(|node, q, v| {
        q.copy_from(&line.q.column(node));
        v.copy_from(&line.v.column(node));
    })?;
    Ok(shooting)
}

/// The minimum of joined segments as that of the problem, corrected if it violates constraints by a little.
fn as_stated(problem: &mut MotionProblem, found: Outcome, options: &Options) -> Outcome {
    let start = problem.start();
    let one = restated(problem, found, &start, options.violation);
    if one.violation <= options.violation || one.violation > FAR || one.is_interrupted() {
        return one;
    }
    let x = match corrected(problem, &one.x, options.violation) {
        Ok(Some(x)) => x,
        Err(error) if is_interruption(&error) => {
            return Outcome { reason: Reason::Interrupted, first_failure: Some(error), ..one };
        }
        _ => one.x.clone(),
    };
    restated(problem, Outcome { x, ..one }, &start, options.violation)
}

/// Minimises J in segments. If the duration is free, a feasible motion with about the duration of the start is sought first, because a lower J
/// often lies at durations that are too short for any controls.
///
/// # Errors
/// A problem without Hessian products.
fn minimised(
    shooting: &mut MultipleShooting,
    (is_timed, haste): (bool, Haste),
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    let start = shooting.start();
    let few = |most: usize| Options { iterations: options.iterations.min(most), ..*options };
    if !is_timed {
        return stages(shooting, &start, &few(MOST), watch);
    }
    let rough = Options { stationarity: ROUGH, violation: MET, target: None, ..few(FEASIBLE) };
    let mut near = feasible(shooting, &start, &rough, watch)?;
    let is_found = near.violation <= MET;
    if near.is_interrupted() || haste == Haste::Brief && !is_found {
        near.x.iter_mut().zip(shooting.bounds()).for_each(|(x, of)| *x = of.nearest(*x));
        return Ok(near);
    }
    let x = if is_found { near.x.clone() } else { start };
    let asked = few(if haste == Haste::Brief { MOST_HASTY } else { MOST });
    Ok(sum(near, stages(shooting, &x, &asked, watch)?))
}

/// Makes a single motion of segments that meet in independent coordinates.
///
/// # Errors
/// A problem without Hessian products.
fn joined(
    shooting: &mut MultipleShooting,
    found: Outcome,
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    let Some(mut near) = nearby(shooting, &found) else { return Ok(found) };
    let x = match shooting.join() {
        Ok(x) => x,
        Err(error) => {
            let reason = if is_interruption(&error) { Reason::Interrupted } else { Reason::NoStart };
            return Ok(Outcome { reason, first_failure: Some(error), ..found });
        }
    };
    near.slopes.resize(x.len(), 0.0);
    let next = stages_near(shooting, (&x, &near), &exact(&x, options, MOST_JOINED), watch)?;
    Ok(sum(found, next))
}

/// Options with a smaller tolerance of violations, because unstable motions amplify what is left, but above the rounding error of states of the size of x,
/// and with at most so many iterations.
fn exact(x: &[f64], options: &Options, most: usize) -> Options {
    let violation = (EXACT * options.violation).max(LEAST * largest(x).max(1.0));
    Options { iterations: options.iterations.min(most), violation, ..*options }
}

/// The derivatives of the Lagrangian at a minimum; `None` if they cannot be computed.
fn nearby(shooting: &mut MultipleShooting, found: &Outcome) -> Option<Nearby> {
    let mut slopes = vec![0.0; shooting.variables()];
    shooting.gradient(1.0, &found.multipliers, &mut slopes).ok()?;
    Some(Nearby { slopes, multipliers: found.multipliers.clone() })
}

fn is_interruption(error: &Error) -> bool {
    matches!(error, Error::Interrupted { .. })
}

/// The outcome as that of the problem, which is left at its point.
fn restated(problem: &mut MotionProblem, found: Outcome, start: &[f64], allowed: f64) -> Outcome {
    let x = found.x[..start.len()].to_vec();
    let intervals = problem.constraints();
    let mut constraints = vec![f64::INFINITY; intervals.len()];
    let evaluated = problem.evaluate(&x, &mut constraints);
    let reason = if evaluated.as_ref().is_err_and(is_interruption) { Reason::Interrupted } else { found.reason };
    let value = evaluated.unwrap_or(f64::INFINITY);
    let violation = largest_violation(&intervals, &constraints);
    let multipliers = found.multipliers[..intervals.len()].to_vec();
    let (violated, warnings) = (Violation::all(problem, &constraints, reason.named_above(allowed)), problem.warnings());
    Outcome { x, value, constraints, violation, violated, multipliers, reason, warnings, ..found }
}

/// The later outcome, with the counts and the history of both.
pub(super) fn sum(mut first: Outcome, later: Outcome) -> Outcome {
    first.add(&later);
    later.with_counts_of(first)
}
