//! The accuracy of a minimum: the errors that the grid causes are estimated and, if an accuracy is wanted, the problem is solved again by schemes of higher
//! order.

use super::super::problem::{Interval, Problem};
use super::super::{MotionProblem, Options, Outcome, Watcher};
use super::attempt::{Known, sum};
use super::halved::Halved;
use super::solved::Solved;
use super::ways::{Start, from_known, from_start, is_solved};
use crate::estimate::GridErrors;
use crate::{Error, Scheme, Warning};

/// The largest number of times that a problem is solved with smaller errors of the grid, the largest growth of the number of steps, and the order of the
/// scheme from which on steps are halved.
const MOST: usize = 12;
const GROWTH: usize = 16;
const ORDER: usize = 4;
/// Errors are estimated from steps divided into these numbers of parts; if an accuracy is wanted from all of them, because where a force begins within a step,
/// halves may err as the step does.
const PARTS: [usize; 2] = [2, 4];
/// Errors of outputs are compared with values of at least this size in the units of an output, m or rad; those of J with at least this fraction of J
/// at the start.
const LEAST: f64 = 1.0;
const FRACTION: f64 = 1e-3;

/// The quantity with the largest relative error.
struct Deviation {
    /// An output, or J.
    name: String,
    value: f64,
    error: f64,
    /// |error| relative to the size of the value.
    relative: f64,
}

impl Deviation {
    /// The largest error of J and of the constrained outputs that the grid causes at a minimum, where the problem was evaluated last, by steps divided into
    /// these numbers of parts. `None` if it cannot be estimated.
    fn of(problem: &MotionProblem, minimum: &Outcome, parts: &[usize]) -> Option<Self> {
        let of_parts = parts.iter().filter_map(|parts| Self::by(problem, minimum, *parts));
        of_parts.max_by(|a, b| a.relative.total_cmp(&b.relative))
    }

    fn by(problem: &MotionProblem, minimum: &Outcome, parts: usize) -> Option<Self> {
        let GridErrors { value, outputs } = problem.errors_of((minimum.value, &minimum.constraints), parts).ok()??;
        let of =
            |name: String, value: f64, error: f64, size: f64| Deviation { name, value, error, relative: error.abs() / size };
        // At the minimum, J may be zero up to rounding.
        let at_start = minimum.history.first().map_or(0.0, |first| FRACTION * first.value.abs());
        let of_cost =
            of("the cost J".into(), minimum.value, value, minimum.value.abs().max(at_start).max(f64::MIN_POSITIVE));
        let constrained = problem.constraints().into_iter().enumerate().filter(|(_, of)| *of != Interval::FREE);
        let of_outputs = constrained.map(|(k, _)| {
            let value = minimum.constraints[k];
            of(problem.constraint_name(k), value, outputs[k], value.abs().max(LEAST))
        });
        of_outputs.chain([of_cost]).max_by(|a, b| a.relative.total_cmp(&b.relative))
    }

    fn warning(self, wanted: Option<f64>) -> Warning {
        Warning::Inaccurate { quantity: self.name, value: self.value, error: self.error, wanted }
    }
}

/// Solves again by schemes of higher order until the minimum has an accuracy, if one is wanted. What deviates then is a warning.
///
/// # Errors
/// As [`solve`](super::solve()).
pub(super) fn make_accurate(
    problem: &mut MotionProblem,
    found: &mut Solved,
    (accuracy, options): (Option<f64>, &Options),
    watch: &mut Watcher,
) -> Result<(), Error> {
    let allowed = accuracy.unwrap_or(Warning::INACCURATE);
    let parts = if accuracy.is_some() { &PARTS[..] } else { &PARTS[..1] };
    let is_far = |problem: &MotionProblem, outcome: &Outcome| {
        let deviation = if is_solved(outcome, options) { Deviation::of(problem, outcome, parts) } else { None };
        deviation.filter(|deviation| deviation.relative > allowed)
    };
    let most_steps = GROWTH * steps(problem);
    for count in 0.. {
        let Some(deviation) = is_far(problem, &found.outcome) else { break };
        let may_grow = accuracy.is_some() && count < MOST && steps(problem) <= most_steps;
        let finer = if may_grow { finer(problem, &found.outcome) } else { None };
        let Some(mut finer) = finer else {
            found.outcome.warnings.push(deviation.warning(accuracy));
            break;
        };
        let Solved { outcome, attempts } = finer.solved(options, watch)?;
        found.attempts.extend(attempts);
        if !is_solved(&outcome, options) && !outcome.is_interrupted() {
            found.outcome.warnings.push(deviation.warning(accuracy));
            break;
        }
        found.outcome = sum(found.outcome.clone(), outcome);
        *problem = finer.problem;
    }
    Ok(())
}

fn steps(problem: &MotionProblem) -> usize {
    problem.inputs_at(&problem.start()).grid.steps.len()
}

/// A problem with smaller errors of the grid, and what is known of its minimum.
struct Finer {
    problem: MotionProblem,
    known: Known,
    what: String,
}

/// The problem with a scheme of order 4, or, if it has one, on a grid with halved steps, or, if that is not possible, with the next scheme.
fn finer(problem: &mut MotionProblem, minimum: &Outcome) -> Option<Finer> {
    let known = Known::of(problem, &minimum.multipliers).ok()?;
    let scheme = problem.solver.settings().scheme;
    if scheme.order >= ORDER
        && let Some(Halved { problem, known }) = Halved::new(problem, &known)
    {
        let what = format!("{} steps", steps(&problem));
        return Some(Finer { problem, known, what });
    }
    let next = above(scheme)?;
    let by_scheme = problem.statement().by(next).at(&minimum.x).ok()?;
    Some(Finer { problem: by_scheme, known, what: format!("by {}", next.name) })
}

impl Finer {
    /// Solves from the states of the minimum.
    ///
    /// # Errors
    /// As [`solve`](super::solve()).
    fn solved(&mut self, options: &Options, watch: &mut Watcher) -> Result<Solved, Error> {
        let mut attempts = Vec::new();
        let near = from_known(&mut self.problem, (&self.known, &self.what), (options, &mut attempts), watch)?;
        if let Some(outcome) = near {
            return Ok(Solved { outcome, attempts });
        }
        let mut found = from_start(&mut self.problem, &self.known.guess(), (options, Start::First), watch)?;
        found.attempts.splice(..0, attempts);
        Ok(found)
    }
}

/// The next scheme of higher order, if there is one.
fn above(scheme: Scheme) -> Option<Scheme> {
    [Scheme::ESDIRK4, Scheme::ESDIRK5].into_iter().find(|of| of.order > scheme.order)
}
