//! The ways from one start to a minimum: near a known one, in segments, and as one motion.

use super::super::problem::Problem;
use super::super::{MotionProblem, Options, Outcome, Reason, Watcher, interior_point};
use super::attempt::{Haste, Known, in_segments, near_optimum};
use super::division::counts;
use super::guess::{Guess, Line};
use super::reach::Reach;
use super::saturated::saturated;
use super::solved::{Attempt, Solved};
use crate::Error;

/// Number of ways that are tried from starts after the first one.
const FEW: usize = 2;
/// The largest number of iterations if no state at the end has the values asked for.
const MOST_IMPOSSIBLE: usize = 100;

/// True for a minimum of the problem as stated; false also for segments that meet but violate the constraints as a single motion.
pub(super) fn is_solved(outcome: &Outcome, options: &Options) -> bool {
    outcome.reason.is_converged() && outcome.violation <= options.violation
}

/// Solves near a known minimum and adds the attempt; `None`, and the problem at its start, if other ways have to be tried.
///
/// # Errors
/// A problem without Hessian products.
pub(super) fn from_known(
    problem: &mut MotionProblem,
    (known, what): (&Known, &str),
    (options, attempts): (&Options, &mut Vec<Attempt>),
    watch: &mut Watcher,
) -> Result<Option<Outcome>, Error> {
    let start = problem.start();
    let Some(outcome) = near_optimum(problem, known, options, watch)? else { return Ok(None) };
    attempts.push(Attempt::of(what.into(), &outcome, options));
    if is_solved(&outcome, options) || outcome.is_interrupted() {
        return Ok(Some(outcome));
    }
    problem.settle_at(&start);
    Ok(None)
}

/// Solves from the inputs of the problem, beginning with one of the numbers of segments.
///
/// # Errors
/// As [`solve`].
pub(super) fn from_start(
    problem: &mut MotionProblem,
    guess: &Guess,
    (options, first): (&Options, usize),
    watch: &mut Watcher,
) -> Result<Solved, Error> {
    let mut attempts = Vec::new();
    let haste = if first == 0 { Haste::Patient } else { Haste::Brief };
    let line = match guess {
        Guess::Inputs => None,
        Guess::Optimum { x, multipliers } if first == 0 && settles_at(problem, x).is_ok() => {
            let known = Known::of(problem, multipliers).ok();
            if let Some(known) = &known
                && let Some(outcome) = from_known(problem, (known, "near the optimum"), (options, &mut attempts), watch)?
            {
                return Ok(Solved { outcome, attempts });
            }
            known.map(|known| known.line)
        }
        _ => Line::new(problem, guess, first),
    };
    let start = problem.start();
    let mut best: Option<Outcome> = None;
    // Targets out of reach: segments would fail, too, but would not say so.
    let reach = line.as_ref().map_or(Reach::Found, |line| line.reach);
    if reach != Reach::Found {
        let outcome = as_one_motion(problem, (&start, reach), (options, &mut attempts), watch)?;
        if is_final(&outcome, options) || outcome.reason == Reason::Infeasible {
            return Ok(Solved { outcome, attempts });
        }
        best = Some(outcome);
        problem.settle_at(&start);
    }
    let is_tried = best.is_some();
    let ways = line.iter().flat_map(|line| counts(problem, first).into_iter().map(move |segments| (line, segments)));
    for (line, segments) in ways.collect::<Vec<_>>() {
        let Some(outcome) = in_segments(problem, (line, segments, haste), options, watch)? else { continue };
        attempts.push(Attempt::of(format!("{segments} segments"), &outcome, options));
        if is_final(&outcome, options) || haste == Haste::Brief && attempts.len() == FEW {
            return Ok(Solved { outcome, attempts });
        }
        best = Some(better(best, outcome, options));
        problem.settle_at(&start);
    }
    let mut outcome = match best {
        Some(outcome) if is_tried => outcome,
        best => {
            let outcome = as_one_motion(problem, (&start, reach), (options, &mut attempts), watch)?;
            if is_final(&outcome, options) {
                return Ok(Solved { outcome, attempts });
            }
            if outcome.reason == Reason::Infeasible { outcome } else { better(best, outcome, options) }
        }
    };
    problem.settle_at(&outcome.x);
    if outcome.violation > options.violation {
        outcome.warnings.splice(..0, saturated(problem, &outcome.x));
    }
    Ok(Solved { outcome, attempts })
}

/// Solves from the inputs of the problem without segments, and adds the attempt. If no state at the end has the values asked for, it ends after few
/// iterations, as infeasible.
///
/// # Errors
/// A problem without Hessian products.
fn as_one_motion(
    problem: &mut MotionProblem,
    (start, reach): (&[f64], Reach),
    (options, attempts): (&Options, &mut Vec<Attempt>),
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    let most = if reach == Reach::Impossible { MOST_IMPOSSIBLE } else { usize::MAX };
    let few = Options { iterations: options.iterations.min(most), ..*options };
    let mut outcome = interior_point(problem, start, &few, watch)?;
    if reach == Reach::Impossible && !is_final(&outcome, options) {
        outcome.reason = Reason::Infeasible;
    }
    attempts.push(Attempt::of("one motion".into(), &outcome, options));
    Ok(outcome)
}

/// True if no other way is tried after an outcome.
fn is_final(outcome: &Outcome, options: &Options) -> bool {
    is_solved(outcome, options) || outcome.is_interrupted()
}

/// The outcome with the smaller violation or, if both are feasible, with the lower value.
fn better(one: Option<Outcome>, other: Outcome, options: &Options) -> Outcome {
    let key = |of: &Outcome| [(of.violation - options.violation).max(0.0), of.value];
    match one {
        Some(one) if key(&one) <= key(&other) => one,
        _ => other,
    }
}

/// Makes x the current point.
///
/// # Errors
/// A point without a motion.
pub(super) fn settles_at(problem: &mut MotionProblem, x: &[f64]) -> Result<(), Error> {
    let mut constraints = vec![0.0; problem.constraints().len()];
    problem.evaluate(x, &mut constraints).map(|_| ())
}
