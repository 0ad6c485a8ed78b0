//! Controls from which segments begin: away from their bounds, because steps end at bounds and would be short.

use super::super::MotionProblem;
use super::super::barrier::move_inside;
use super::super::problem::{Interval, Problem};
use super::guess::Line;
use crate::{Control, Mechanics};

/// Distance from two bounds, relative to that between them, and from a single one where no better is known, relative to its size, or 1 if it is smaller.
const APART: f64 = 0.1;
/// A control is beside a bound if this fraction of the distance is left, or less.
const BESIDE: f64 = 0.01;

/// The variables of the start of a problem, with controls that are beside a bound at all nodes moved away from it.
pub(super) fn apart_from_bounds(problem: &MotionProblem, line: &Line) -> Vec<f64> {
    let (mut x, bounds) = (problem.start(), problem.bounds());
    for (free, variables) in problem.free().parts() {
        let (Some(control), of) = (free.quantity.control(), bounds[variables.start]) else { continue };
        let scene_needs = || moving(problem, line, control).map(|size| size / free.scale);
        let distance = distance(&of, scene_needs);
        let is_beside = |x: &f64| {
            let room = (x - of.least).min(of.most - x);
            room <= BESIDE * distance
        };
        if x[variables.clone()].iter().all(is_beside) {
            x[variables].iter_mut().for_each(|x| move_inside(x, &of, |_| distance));
        }
    }
    x
}

/// The distance from bounds at which a variable begins.
fn distance(of: &Interval, from_single: impl Fn() -> Option<f64>) -> f64 {
    let width = of.most - of.least;
    match [of.least, of.most].into_iter().find(|bound| bound.is_finite()) {
        Some(_) if width.is_finite() => APART * width,
        Some(bound) => from_single().unwrap_or(APART * bound.abs().max(1.0)),
        None => 0.0,
    }
}

/// The size of a control whose effect on the accelerations at the start is as large as that of all forces there and as those with which coordinates
/// move evenly accelerated, and then decelerated, from the beginning of a line to its end; `None` if there is none.
fn moving(problem: &MotionProblem, line: &Line, control: Control) -> Option<f64> {
    let (system, inputs) = (problem.solver.system(), problem.inputs_at(&problem.start()));
    let mut u = vec![0.0; system.k()];
    let here = Mechanics::at_start(system, &inputs).and_then(|here| here.with_controls(&u)).ok()?;
    let (own, _) = here.accelerations().ok()?;
    u[control.index()] = 1.0;
    let (with_control, _) = here.with_controls(&u).and_then(|here| here.accelerations()).ok()?;
    let (from, to) = (line.q.column(0), line.q.column(line.q.ncols() - 1));
    let duration: f64 = inputs.grid.steps.iter().sum();
    let size = (own.norm() + 4.0 * (to - from).norm() / duration.powi(2)) / (with_control - &own).norm();
    (size > 0.0 && size.is_finite()).then_some(size)
}
