//! Variables at their bounds where constraints stay violated.

use std::ops::Range;

use super::super::MotionProblem;
use super::super::free::Free;
use super::super::problem::Interval;
use crate::Warning;

/// Variables this close to a bound, relative to the distance between both or to their size (1 if it is smaller), are at the bound.
const CLOSE: f64 = 1e-2;
/// Controls that are at bounds in this fraction of their variables hinder the constraints.
const MANY: f64 = 0.5;

/// A warning for each free quantity that is at its bounds in many of its variables.
pub(super) fn saturated(problem: &MotionProblem, x: &[f64]) -> Vec<Warning> {
    let (variables, bounds) = (problem.free(), problem.free().bounds());
    let is_at_bound = |(x, Interval { least, most }): (&f64, &Interval)| {
        let close = CLOSE * (most - least).min(x.abs().max(1.0));
        (x - least).min(most - x) <= close
    };
    let steps = problem.inputs_at(x).grid.steps.len();
    let of_part = |(free, range): (&Free, Range<usize>)| {
        let is_held = bounds[range.start].is_equality();
        let count = x[range.clone()].iter().zip(&bounds[range.clone()]).filter(|pair| is_at_bound(*pair)).count();
        let quantity = free.quantity.name(problem.solver.system(), steps).ok()?;
        let is_saturated = !is_held && count as f64 >= MANY * range.len() as f64;
        is_saturated.then(|| Warning::AtBounds { quantity, count, of: range.len() })
    };
    variables.parts().filter_map(of_part).collect()
}
