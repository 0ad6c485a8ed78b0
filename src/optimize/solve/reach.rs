//! [`Reach`]: whether the states at the ends of a motion can be as the constraints ask.

use nalgebra::DVector;

use super::super::free::Quantity;
use super::super::problem::{Interval, Problem};
use super::super::{Free, MotionProblem};
use super::pose::Pose;
use crate::{Error, Solver};

/// Whether a state has the values asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reach {
    /// One has.
    Found,
    /// None was found.
    Unknown,
    /// The constraints contradict each other: the sum of squares of what is left is minimal wherever Newton's method ended.
    Impossible,
}

/// Smaller relative violations at the start are rounding errors.
const ROUNDING: f64 = 1e-6;

/// Outputs, and the intervals in which they must lie.
type Asked = Vec<(usize, Interval)>;

/// The outputs that must have given values at the end.
pub(super) fn values_at_end(problem: &MotionProblem) -> Asked {
    let system = problem.solver.system();
    asked(problem, |&(k, to)| to.is_equality() && system.is_terminal(k))
}

fn asked(problem: &MotionProblem, is_asked: impl Fn(&(usize, Interval)) -> bool) -> Asked {
    problem.constraints().into_iter().enumerate().filter(is_asked).collect()
}

fn has_free(problem: &MotionProblem, is_one: impl Fn(&Quantity) -> bool) -> bool {
    problem.free().free().iter().any(|Free { quantity, .. }| is_one(quantity))
}

/// The state at the end in which all outputs that it determines lie in their intervals or, if there is none, at least those have their values that
/// must; and whether there is one, as far as the free quantities do not change this.
pub(super) fn end_of(problem: &MotionProblem, pose: &mut Pose, start: [&DVector<f64>; 2]) -> (Vec<f64>, Reach) {
    let (system, inputs) = (problem.solver.system(), problem.inputs_at(&problem.start()));
    let (last, times) = (inputs.grid.steps.len(), inputs.grid.times());
    let values = values_at_end(problem);
    let is_of_end = |k: usize| system.is_of_state(k, last, true);
    let all = asked(problem, |&(k, to)| to != Interval::FREE && is_of_end(k) || values.iter().any(|of| of.0 == k));
    let (end, reach) = pose.end(start, times[last], &all);
    if reach == Reach::Found {
        return (end, reach);
    }
    let end = if values.len() < all.len() { pose.end(start, times[last], &values).0 } else { end };
    if has_free(problem, |of| matches!(of, Quantity::Design(_))) {
        return (end, Reach::Found);
    }
    let changes_time = |of: &Quantity| matches!(of, Quantity::Duration | Quantity::StepLength(_));
    let is_fixed = inputs.events.is_empty() && (system.timed().is_none() || !has_free(problem, changes_time));
    let is_certain = is_fixed && all.iter().all(|(k, _)| is_of_end(*k));
    (end, if is_certain { reach } else { reach.min(Reach::Unknown) })
}

/// True if the start is fixed and violates constraints at the first node.
pub(super) fn is_outside_at_start(problem: &MotionProblem) -> bool {
    known_at_start(problem).into_iter().any(|Known { excess, size, .. }| excess > ROUNDING * size.max(1.0))
}

/// An output that a fixed start determines.
struct Known {
    output: usize,
    /// The distance from its interval.
    excess: f64,
    size: f64,
}

fn known_at_start(problem: &MotionProblem) -> Vec<Known> {
    let system = problem.solver.system();
    let changes_start = |of: &Quantity| matches!(of, Quantity::Design(_) | Quantity::Coordinate(_) | Quantity::Rate(_));
    let here = asked(problem, |&(k, to)| to != Interval::FREE && system.is_of_state(k, 0, false));
    if here.is_empty() || has_free(problem, changes_start) {
        return Vec::new();
    }
    let (mut inputs, mut solver) = (problem.inputs_at(&problem.start()), Solver::new(system, problem.solver.settings()));
    inputs.events.clear();
    inputs.controls = inputs.controls.columns(0, 1).into_owned();
    inputs.grid = inputs.grid.part(0, 0);
    if solver.simulate(&inputs).is_err() {
        return Vec::new();
    }
    let Ok(found) = solver.outputs() else { return Vec::new() };
    let known = |(output, to): (usize, Interval)| {
        let value = found[output];
        Known { output, excess: (value - to.nearest(value)).abs(), size: value.abs() }
    };
    here.into_iter().map(known).collect()
}

/// Does some work without the constraints that a fixed start satisfies, of which those whose bounds it touches would leave nothing inside the bounds.
pub(super) fn without_known<T>(
    problem: &mut MotionProblem,
    allowed: f64,
    work: impl FnOnce(&mut MotionProblem) -> Result<T, Error>,
) -> Result<T, Error> {
    let stated = problem.constraints();
    let held: Vec<usize> =
        known_at_start(problem).into_iter().filter(|of| of.excess <= allowed).map(|of| of.output).collect();
    held.iter().for_each(|&output| problem.set(output, Interval::FREE));
    let done = work(problem);
    held.iter().for_each(|&output| problem.set(output, stated[output]));
    done
}
