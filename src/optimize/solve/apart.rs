//! Controls from which segments begin: away from their bounds, because steps end at bounds and would be short.

use super::super::MotionProblem;
use super::super::barrier::move_inside;
use super::super::problem::Problem;
use super::guess::Line;
use crate::{Control, Mechanics};

/// Distance from two bounds, relative to that between them, and from a single one where no better is known, relative to its size, or 1 if it is smaller.
const APART: f64 = 0.1;

/// The variables of the start of a problem, with controls away from their bounds.
pub(super) fn apart_from_bounds(problem: &MotionProblem, line: &Line) -> Vec<f64> {
    let (mut x, bounds) = (problem.start(), problem.bounds());
    for (free, variables) in problem.free().parts() {
        let (Some(control), of) = (free.quantity.control(), bounds[variables.start]) else { continue };
        let width = of.most - of.least;
        let is_single = of.least.is_finite() != of.most.is_finite();
        let moving = if is_single { moving(problem, line, control) } else { None };
        let from_single = |bound: f64| moving.map_or(APART * bound.abs().max(1.0), |size| size / free.scale);
        let by = |bound: f64| if width.is_finite() { APART * width } else { from_single(bound) };
        x[variables].iter_mut().for_each(|x| move_inside(x, &of, by));
    }
    x
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
