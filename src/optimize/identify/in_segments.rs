//! A fit by segments whose distances are reduced step by step, followed by a fit of the motions as they are.

use std::collections::HashSet;

use super::super::motion_problem::MotionProblem;
use super::super::multiple_shooting::MultipleShooting;
use super::super::problem::{Interval, Problem};
use super::super::solve::start_of;
use super::super::trials::Trials;
use super::super::{Fit, Options, Outcome, Watcher, levenberg_marquardt};
use super::states::fit_states;
use super::weighted::Weighted;
use crate::assembly::Retraction;
use crate::{Error, Sum, System};

/// The weights of the distances, relative to those with which they count as much as their effects on the residuals in a segment.
const MULTIPLES: [f64; 6] = [0.1, 1.0, 10.0, 1e2, 1e3, 1e4];
/// The largest number of segments of a motion.
const MOST: usize = 40;
/// The largest number of iterations with one weight, and their tolerance.
const ITERATIONS: usize = 30;
const STATIONARITY: f64 = 1e-4;
/// Motions are fitted as they are once their value is at most this multiple of that in segments.
const NEAR: f64 = 3.0;

/// Fits in segments with this number of nodes with readings, and then as the motions are; `None` if there are not several segments. Returns the last
/// fit with the counts of all.
///
/// # Errors
/// As [`levenberg_marquardt`].
pub(super) fn in_segments(
    trials: &mut Trials,
    (start, readings): (&[f64], usize),
    options: &Options,
    watch: &mut Watcher,
) -> Result<Option<Fit>, Error> {
    let divided: Option<Vec<MultipleShooting>> =
        (0..trials.parts.len()).map(|k| divided(&trials.parts[k], &trials.own(k, start), readings)).collect();
    let Some(mut parts) = divided.filter(|parts| parts.iter().any(|of| of.segments.len() > 1)) else { return Ok(None) };
    let (mut states, mut evaluations) = (Vec::new(), 0);
    for part in &mut parts {
        let Ok((x, count)) = fit_states(part) else { return Ok(None) };
        // A segment is a part of a motion.
        evaluations += count.div_ceil(part.segments.len());
        states.push(x);
    }
    let mut segments = Trials::join(parts, trials.sharing())?;
    let mut x = segments.whole(states.into_iter());
    let mut c = vec![0.0; segments.constraints().len()];
    let mut done: Option<Outcome> = None;
    for multiple in MULTIPLES {
        if segments.evaluate(&x, &mut c).is_err() {
            break;
        }
        let Ok(mut weighted) = Weighted::new(&mut segments, multiple) else { break };
        let few =
            Options { iterations: options.iterations.min(ITERATIONS), stationarity: STATIONARITY, target: None, ..*options };
        let outcome = levenberg_marquardt(&mut weighted, &x, &few, watch)?.outcome;
        let (is_interrupted, value) = (outcome.is_interrupted(), outcome.value);
        if value.is_finite() {
            x.clone_from(&outcome.x);
        }
        match &mut done {
            Some(done) => done.add(&outcome),
            None => done = Some(outcome),
        }
        if is_interrupted || !value.is_finite() || value_of(trials, &merged(trials, &segments, &x)) <= NEAR * value {
            break;
        }
    }
    let x = merged(trials, &segments, &x);
    let mut fit = levenberg_marquardt(trials, &x, options, watch)?;
    if let Some(mut all) = done {
        all.evaluations += evaluations;
        all.add(&fit.outcome);
        let history = std::mem::take(&mut fit.outcome.history);
        fit.outcome = fit.outcome.with_counts_of(all);
        fit.outcome.history = history;
    }
    Ok(Some(fit))
}

/// A motion in segments with about this number of nodes with readings; `None` if it cannot be divided.
fn divided(motion: &MotionProblem, x: &[f64], readings: usize) -> Option<MultipleShooting> {
    let (system, settings) = (motion.solver.system(), motion.solver.settings());
    let inputs = motion.inputs_at(x);
    let intervals = motion.constraints();
    let asked: Vec<usize> = (0..intervals.len()).filter(|&j| intervals[j] != Interval::FREE).collect();
    let steps = inputs.grid.macro_ends().count();
    let count = (nodes(system, &asked).len() / readings).clamp(1, MOST.min(steps).max(1));
    let preferred: Vec<usize> = asked.iter().flat_map(|&j| system.coordinates_of(1 + j)).collect();
    let [q, _] = start_of(system, settings, &inputs)?;
    let mut at = inputs.clone();
    at.start.q_mut().copy_from(&q);
    let states = Retraction::choose(system, &preferred, &at);
    MultipleShooting::of(motion, x, (&states, count)).ok()
}

/// The single nodes at which these outputs are evaluated.
fn nodes(system: &System, outputs: &[usize]) -> HashSet<usize> {
    let sums = outputs.iter().flat_map(|&j| system.sums(1 + j).map(|(sum, _)| sum));
    sums.filter_map(|sum| if let Sum::Node(node) = sum { Some(node) } else { None }).collect()
}

/// The variables of motions that begin as the first segments do.
fn merged(trials: &Trials, segments: &Trials<MultipleShooting>, x: &[f64]) -> Vec<f64> {
    let own = |k: usize| segments.own(k, x)[..trials.parts[k].variables()].to_vec();
    trials.whole((0..trials.parts.len()).map(own))
}

/// ½‖r‖² of trials; infinite if there is no value.
fn value_of(trials: &mut Trials, x: &[f64]) -> f64 {
    let intervals = trials.constraints();
    let mut c = vec![0.0; intervals.len()];
    if trials.evaluate(x, &mut c).is_err() {
        return f64::INFINITY;
    }
    let sum: f64 = intervals.iter().zip(c).map(|(of, c)| of.excess(c).powi(2)).sum();
    if sum.is_finite() { 0.5 * sum } else { f64::INFINITY }
}
