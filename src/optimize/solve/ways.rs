//! The ways from one start to a minimum: near a known one, in segments, and as one motion.

use std::collections::VecDeque;
use std::fmt;

use super::super::problem::Problem;
use super::super::{MotionProblem, Options, Outcome, Reason, Watcher, interior_point};
use super::attempt::{Haste, Known, in_segments, near_optimum};
use super::division::counts;
use super::guess::{Guess, Line};
use super::reach::{Reach, contradiction};
use super::saturated::saturated;
use super::solved::{Attempt, Solved};
use crate::{Error, Warning};

/// If so many ways end where the violation cannot be reduced, no others are tried.
const ENOUGH: usize = 3;
/// The largest numbers of iterations as one motion: if no state at the end has the values asked for, and from starts after the first one.
const MOST_IMPOSSIBLE: usize = 100;
const MOST_OTHER: usize = 100;

/// True for a minimum of the problem as stated; false also for segments that meet but violate the constraints as a single motion.
pub(super) fn is_solved(outcome: &Outcome, options: &Options) -> bool {
    outcome.reason.is_converged() && outcome.violation <= options.violation
}

/// A start of a search.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Start {
    /// The inputs of the problem, from which all ways are tried.
    First,
    /// Random inputs, from which one way is tried.
    Other { which: usize, is_one_motion: bool },
}

impl Start {
    fn number(self) -> usize {
        match self {
            Start::First => 0,
            Start::Other { which, .. } => which,
        }
    }

    fn haste(self) -> Haste {
        if self == Start::First { Haste::Patient } else { Haste::Brief }
    }
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

/// Solves from the inputs of the problem.
///
/// # Errors
/// As [`solve`].
pub(super) fn from_start(
    problem: &mut MotionProblem,
    guess: &Guess,
    (options, start): (&Options, Start),
    watch: &mut Watcher,
) -> Result<Solved, Error> {
    let mut attempts = Vec::new();
    let line = match guess {
        Guess::Inputs => None,
        Guess::Optimum { x, multipliers } if start == Start::First && settles_at(problem, x).is_ok() => {
            let known = Known::of(problem, multipliers).ok();
            if let Some(known) = &known
                && let Some(outcome) = from_known(problem, (known, "near the optimum"), (options, &mut attempts), watch)?
            {
                return Ok(Solved { outcome, attempts });
            }
            known.map(|known| known.line)
        }
        _ => Line::new(problem, guess, start.number()),
    };
    by_ways(problem, (line.as_ref(), start), (options, attempts), watch)
}

/// Solves by one way after another; after the first start, by one.
///
/// # Errors
/// As [`solve`].
fn by_ways(
    problem: &mut MotionProblem,
    (line, at): (Option<&Line>, Start),
    (options, mut attempts): (&Options, Vec<Attempt>),
    watch: &mut Watcher,
) -> Result<Solved, Error> {
    let (start, haste) = (problem.start(), at.haste());
    let reach = line.map_or(Reach::Found, |line| line.reach);
    let counts = if line.is_some() { counts(problem, at.number()) } else { Vec::new() };
    let mut ways = in_order(counts, at, reach);
    let most = match haste {
        _ if reach == Reach::Impossible => MOST_IMPOSSIBLE,
        Haste::Brief if ways.len() > 1 => MOST_OTHER,
        _ => usize::MAX,
    };
    let (before, mut best) = (attempts.len(), None);
    while let Some(way) = ways.pop_front() {
        let is_first = haste == Haste::Patient && attempts.len() == before;
        let found = match (way, line) {
            (Way::Segments(count), Some(line)) => in_segments(problem, (line, count, haste), options, watch)?,
            _ => Some(as_one_motion(problem, (&start, reach, most), options, watch)?),
        };
        let Some(mut outcome) = found else { continue };
        let is_end = is_final(&outcome, options);
        if is_first
            && !is_end
            && let Some(warning) = contradiction(problem, line)
        {
            outcome.warnings.insert(0, warning);
            outcome.reason = Reason::Infeasible;
        }
        attempts.push(Attempt::of(way.to_string(), &outcome, options));
        let is_infeasible = way == Way::OneMotion && outcome.reason == Reason::Infeasible;
        if is_end || is_hopeless(&outcome) || is_infeasible && reach != Reach::Found || haste == Haste::Brief {
            return Ok(Solved { outcome, attempts });
        }
        // Where segments do not lead to a minimum, one motion often does, for less work than other segments.
        bring_one_motion_forward(&mut ways);
        let tried = &attempts[before..];
        let are_stuck = tried.iter().all(|attempt| is_stuck(attempt, options));
        best = Some(better(best, outcome, are_stuck, options));
        problem.settle_at(&start);
        if are_stuck && tried.len() == ENOUGH {
            break;
        }
    }
    let mut outcome = best.expect("one motion is always tried");
    problem.settle_at(&outcome.x);
    if outcome.violation > options.violation {
        outcome.warnings.splice(..0, saturated(problem, &outcome.x));
    }
    Ok(Solved { outcome, attempts })
}

/// A way from a start to a minimum.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// From the inputs.
    OneMotion,
    /// From a guess of the states in a number of segments.
    Segments(usize),
}

/// The ways from a start, in the order in which they are tried.
fn in_order(counts: Vec<usize>, at: Start, reach: Reach) -> VecDeque<Way> {
    let mut ways: VecDeque<Way> = counts.into_iter().map(Way::Segments).chain([Way::OneMotion]).collect();
    let is_one_motion_first = match at {
        // Segments would fail where the target is out of reach, too, but would not say so.
        Start::First => reach != Reach::Found,
        Start::Other { is_one_motion, .. } => is_one_motion || reach == Reach::Impossible,
    };
    if is_one_motion_first {
        bring_one_motion_forward(&mut ways);
    }
    ways
}

/// Makes one motion the next way, if it has not been tried.
fn bring_one_motion_forward(ways: &mut VecDeque<Way>) {
    if let Some(one) = ways.iter().position(|way| *way == Way::OneMotion).and_then(|at| ways.remove(at)) {
        ways.push_front(one);
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Way::OneMotion => write!(f, "one motion"),
            Way::Segments(count) => write!(f, "{count} segments"),
        }
    }
}

/// Solves from the inputs of the problem without segments. If no state at the end has the values asked for, it ends after few
/// iterations, as infeasible.
///
/// # Errors
/// A problem without Hessian products.
fn as_one_motion(
    problem: &mut MotionProblem,
    (start, reach, most): (&[f64], Reach, usize),
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    let few = Options { iterations: options.iterations.min(most), ..*options };
    let mut outcome = interior_point(problem, start, &few, watch)?;
    if reach == Reach::Impossible && !is_final(&outcome, options) {
        outcome.reason = Reason::Infeasible;
    }
    Ok(outcome)
}

/// True for an attempt that ended where the violation cannot be reduced.
fn is_stuck(attempt: &Attempt, options: &Options) -> bool {
    attempt.violation > options.violation && matches!(attempt.reason, Reason::NoLowerValue | Reason::Infeasible)
}

/// True if no other way is tried after an outcome.
fn is_final(outcome: &Outcome, options: &Options) -> bool {
    is_solved(outcome, options) || outcome.is_interrupted() || outcome.reason == Reason::Unbounded
}

/// True for problems without a minimum, whatever the start is.
pub(super) fn is_hopeless(outcome: &Outcome) -> bool {
    outcome.reason == Reason::Unbounded || outcome.warnings.iter().any(|of| matches!(of, Warning::NoState { .. }))
}

/// The outcome with the smaller violation or, if both are feasible, with the lower value. If no way could reduce the violation, it is one that says so.
fn better(one: Option<Outcome>, other: Outcome, are_stuck: bool, options: &Options) -> Outcome {
    let key = |of: &Outcome| {
        let is_told = are_stuck && of.reason == Reason::Infeasible;
        [if is_told { 0.0 } else { 1.0 }, (of.violation - options.violation).max(0.0), of.value]
    };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_starts_go_the_way_whose_turn_it_is() {
        let first = |is_one_motion, reach| in_order(vec![33, 10], Start::Other { which: 1, is_one_motion }, reach)[0];
        for reach in [Reach::Found, Reach::Unknown] {
            assert!(first(false, reach) == Way::Segments(33) && first(true, reach) == Way::OneMotion);
        }
        assert!(first(false, Reach::Impossible) == Way::OneMotion);
        assert!(in_order(vec![33], Start::First, Reach::Unknown)[0] == Way::OneMotion);
    }

    #[test]
    fn one_motion_is_brought_forward_if_it_is_left() {
        let mut ways: VecDeque<Way> = [Way::Segments(33), Way::Segments(10), Way::OneMotion].into();
        bring_one_motion_forward(&mut ways);
        assert!(ways == [Way::OneMotion, Way::Segments(33), Way::Segments(10)]);
        ways.pop_front();
        bring_one_motion_forward(&mut ways);
        assert!(ways == [Way::Segments(33), Way::Segments(10)]);
    }
}
