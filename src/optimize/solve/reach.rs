//! [`Reach`]: whether a motion can begin and end in states that satisfy the constraints there.

use nalgebra::DVector;

use super::super::free::Quantity;
use super::super::problem::{Interval, Problem};
use super::super::{Free, MotionProblem, Violation};
use super::guess::Line;
use super::pose::{End, FOUND, Pose};
use crate::{Error, Inputs, Settings, Solver, System, Warning};

/// The result of a search for a state that satisfies constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reach {
    /// A state satisfies them.
    Found,
    /// No such state was found.
    Unknown,
    /// The constraints contradict each other: the sum of squares of what is left is minimal wherever Newton's method ended.
    Impossible,
}

/// Smaller relative violations at the start are rounding errors.
const ROUNDING: f64 = 1e-6;

/// The outputs that must have given values at the end.
pub(super) fn values_at_end(problem: &MotionProblem) -> Vec<(usize, Interval)> {
    let system = problem.solver.system();
    asked(problem, |&(k, to)| to.is_equality() && system.is_terminal(k))
}

fn asked(problem: &MotionProblem, is_asked: impl Fn(&(usize, Interval)) -> bool) -> Vec<(usize, Interval)> {
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
    let End { z: end, reach, .. } = pose.nearest(start, times[last], &all);
    if reach == Reach::Found {
        return (pose.balanced(&end, times[last], &all).unwrap_or(end), reach);
    }
    let end = if values.len() < all.len() { pose.nearest(start, times[last], &values).z } else { end };
    if has_free(problem, |of| matches!(of, Quantity::Design(_))) {
        return (end, Reach::Found);
    }
    let is_certain = are_fixed(problem) && all.iter().all(|(k, _)| is_of_end(*k));
    (end, if is_certain { reach } else { reach.min(Reach::Unknown) })
}

/// True if no free quantity changes which states satisfy the constraints on states.
fn are_fixed(problem: &MotionProblem) -> bool {
    let changes = |of: &Quantity| matches!(of, Quantity::Duration | Quantity::StepLength(_));
    let is_timed = problem.solver.system().timed().is_some() && has_free(problem, changes);
    let has_designs = has_free(problem, |of| matches!(of, Quantity::Design(_)));
    problem.inputs_at(&problem.start()).events.is_empty() && !is_timed && !has_designs
}

/// A warning for the start, if it is fixed and violates constraints, or for the first other node at which no state near that of a line satisfies the
/// constraints on states, as far as the free quantities do not change this; `None` also if the search for a state is inconclusive.
pub(super) fn contradiction(problem: &MotionProblem, line: Option<&Line>) -> Option<Warning> {
    let (intervals, inputs) = (problem.constraints(), problem.inputs_at(&problem.start()));
    let times = inputs.grid.times();
    let named = |output: usize, value: f64| {
        let (name, interval) = (problem.constraint_name(output), intervals[output]);
        Violation { name, value, interval }.to_string()
    };
    let outside = at_fixed_start(problem).into_iter().filter(AtStart::is_outside);
    let violations: Vec<String> = outside.map(|of| named(of.output, of.value)).collect();
    if !violations.is_empty() {
        return Some(Warning::NoState { node: 0, time: times[0], violations });
    }
    let line = line.filter(|_| are_fixed(problem))?;
    let (system, settings) = (problem.solver.system(), problem.solver.settings());
    let not_found = |node: usize| {
        let is_last = node + 1 == times.len();
        let here = asked(problem, |&(k, to)| to != Interval::FREE && system.is_of_state(k, node, is_last));
        if here.is_empty() {
            return None;
        }
        let mut pose = Pose::new((system, settings), &inputs, &line.coordinates, node).ok()?;
        let [q, v] = [&line.q, &line.v].map(|of| of.column(node).into_owned());
        let end = pose.nearest([&q, &v], times[node], &here);
        (end.reach != Reach::Found).then_some((node, here, end))
    };
    let (node, here, End { left, reach, .. }) = (1..times.len()).find_map(not_found)?;
    let violated = here.iter().zip(&left).filter(|(_, by)| by.abs() >= FOUND);
    let named = violated.map(|((k, of), by)| named(*k, by + if *by > 0.0 { of.most } else { of.least }));
    (reach == Reach::Impossible).then(|| Warning::NoState { node, time: times[node], violations: named.collect() })
}

/// True if the start is fixed and violates constraints at the first node.
pub(super) fn is_outside_at_start(problem: &MotionProblem) -> bool {
    at_fixed_start(problem).iter().any(AtStart::is_outside)
}

/// An output that a fixed start determines.
struct AtStart {
    output: usize,
    value: f64,
    /// The distance from its interval.
    excess: f64,
}

impl AtStart {
    /// True if the excess is no rounding error.
    fn is_outside(&self) -> bool {
        self.excess > ROUNDING * self.value.abs().max(1.0)
    }
}

fn at_fixed_start(problem: &MotionProblem) -> Vec<AtStart> {
    let system = problem.solver.system();
    let changes_start = |of: &Quantity| matches!(of, Quantity::Design(_) | Quantity::Coordinate(_) | Quantity::Rate(_));
    let here = asked(problem, |&(k, to)| to != Interval::FREE && system.is_of_state(k, 0, false));
    if here.is_empty() || has_free(problem, changes_start) {
        return Vec::new();
    }
    let solved = solved_start(system, problem.solver.settings(), &problem.inputs_at(&problem.start()));
    let Some(found) = solved.and_then(|solver| solver.outputs().ok()) else { return Vec::new() };
    let at_start = |(output, to): (usize, Interval)| {
        let value = found[output];
        AtStart { output, value, excess: (value - to.nearest(value)).abs() }
    };
    here.into_iter().map(at_start).collect()
}

/// q and v at the start of a motion, if there is a consistent one.
pub(in super::super) fn start_of(system: &System, settings: Settings, inputs: &Inputs) -> Option<[DVector<f64>; 2]> {
    let solver = solved_start(system, settings, inputs)?;
    let motion = solver.trajectory();
    Some([&motion.q, &motion.v].map(|of| of.column(0).into_owned()))
}

/// A solver with the start of a motion as a motion without steps; `None` if the start is not consistent.
fn solved_start(system: &System, settings: Settings, inputs: &Inputs) -> Option<Solver> {
    let mut solver = Solver::new(system, settings);
    let mut own = inputs.clone();
    own.grid = inputs.grid.part(0, 0);
    own.controls = inputs.controls.columns(0, 1).into_owned();
    own.events.clear();
    solver.simulate(&own).ok()?;
    Some(solver)
}

/// Does some work without the constraints that a fixed start satisfies, of which those whose bounds it touches would leave nothing inside the bounds.
pub(super) fn without_known<T>(
    problem: &mut MotionProblem,
    allowed: f64,
    work: impl FnOnce(&mut MotionProblem) -> Result<T, Error>,
) -> Result<T, Error> {
    let stated = problem.constraints();
    let held: Vec<usize> =
        at_fixed_start(problem).into_iter().filter(|of| of.excess <= allowed).map(|of| of.output).collect();
    held.iter().for_each(|&output| problem.set(output, Interval::FREE));
    let done = work(problem);
    held.iter().for_each(|&output| problem.set(output, stated[output]));
    done
}
