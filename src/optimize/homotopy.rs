//! Homotopy: a sequence of problems with a parameter s from 0 to 1, each started from the solution of the previous one.

use super::outcome::largest_change;
use super::{Options, Outcome, Problem, Reason, Watcher, interior_point};
use crate::Error;

/// The first change of s, the factors by which it grows and shrinks, and the smallest change, below which the homotopy fails.
const FIRST: f64 = 0.2;
const LONGER: f64 = 1.5;
const SHORTER: f64 = 0.4;
const LEAST: f64 = 1e-4;
/// An intermediate problem with more iterations than this is too far away; after at most `FEW` iterations the change of s may grow.
const MOST: usize = 60;
const FEW: usize = 12;
/// Smallest tolerances of intermediate problems; that of violations applies after the first problem, relative to the violation at the start.
const STATIONARITY: f64 = 1e-3;
const VIOLATION: f64 = 1e-5;

/// Solves a sequence of problems `set(problem, s)` from s = 0 to s = 1 by [`interior_point`](interior_point()), each starting from the
/// previous solution. If a problem is not solved, s increases by less. The iteration limit applies to each problem.
///
/// `set` changes the quantity that makes the problem hard, such as the final time, a weight or a force. Counts and history cover all
/// problems; the rest of the outcome is that of the last problem, with s < 1 if s = 1 was not reached. `set` is last called with the
/// s that was reached.
///
/// # Errors
/// As [`interior_point`](interior_point()), or an error of the first `set`. Errors of later calls of `set`, and errors at starting points
/// extrapolated from the previous solutions, count as unsolved problems ([`Outcome::first_failure`]).
pub fn homotopy<P: Problem>(
    problem: &mut P,
    start: &[f64],
    options: &Options,
    set: &mut dyn FnMut(&mut P, f64) -> Result<(), Error>,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    options.check()?;
    set(problem, 0.0)?;
    let first = Options { stationarity: options.stationarity.max(STATIONARITY), target: None, ..*options };
    let mut best = interior_point(problem, start, &first, watch)?;
    let on_the_way = Options { violation: options.violation.max(VIOLATION * best.history[0].violation), ..first };
    let (mut s, mut change, mut all) = (0.0, FIRST, best.clone());
    // The previous solution, and the change of s since then.
    let mut before: Option<(Vec<f64>, f64)> = None;
    while best.reason.is_converged() && s < 1.0 && change > LEAST {
        let next = if s + change > 1.0 - 0.3 * change { 1.0 } else { s + change };
        let goal = if next == 1.0 { *options } else { on_the_way };
        let tried = set(problem, next).and_then(|()| {
            let guess = extrapolate(&best.x, before.as_ref(), next - s);
            interior_point(problem, &guess, &Options { iterations: goal.iterations.min(MOST), ..goal }, watch)
        });
        let found = match tried {
            Ok(found) => found,
            Err(error) => {
                let is_stopped = matches!(error, Error::Interrupted { .. });
                all.first_failure.get_or_insert(error);
                if is_stopped {
                    best.reason = Reason::Interrupted;
                    break;
                }
                change *= SHORTER;
                before = None;
                continue;
            }
        };
        all.add(&found);
        if found.reason == Reason::Interrupted {
            (best, s) = (found, next);
            break;
        }
        if !found.reason.is_converged() {
            change = SHORTER * (next - s);
            before = before.filter(|_| found.reason != Reason::NoStart);
            continue;
        }
        if found.history.len() <= FEW {
            change *= LONGER;
        }
        before = Some((std::mem::replace(&mut best, found).x, next - s));
        s = next;
    }
    // The problem is left with the motion of the solution, unless its computation is interrupted.
    match set(problem, s) {
        Ok(()) => {
            let mut c = vec![0.0; best.constraints.len()];
            let _ = problem.evaluate(&best.x, &mut c);
        }
        Err(error) => drop(all.first_failure.get_or_insert(error)),
    }
    let reason = if s == 1.0 || !best.reason.is_converged() { best.reason } else { Reason::NoWay };
    Ok(Outcome { reason, ..best.with_counts_of(all) })
}

/// Extrapolates linearly from the last two solutions, by at most the last change.
fn extrapolate(x: &[f64], before: Option<&(Vec<f64>, f64)>, change: f64) -> Vec<f64> {
    let Some((old, length)) = before.filter(|(old, _)| largest_change(x, old) > 0.0) else { return x.to_vec() };
    let share = (change / length).min(1.0);
    x.iter().zip(old).map(|(x, old)| x + share * (x - old)).collect()
}
