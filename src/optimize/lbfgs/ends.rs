//! Reasons for the end of a descent: a minimum, up to rounding, or a value that decreases without bound.

use super::super::Reason;
use super::super::counted::Counted;
use super::super::line_search::Point;
use super::super::outcome::largest_change;
use super::{Descent, Merit, ROUNDING, add};
use crate::number::{dot, largest};

/// Distance ahead, relative to the variables, at which curvature is measured if no lower value was found.
const AHEAD: f64 = 1e-6;
/// A gradient above this fraction of the mean slope so far has not become small, if the value decreased by more than the fraction `FALLEN` of itself.
const STEEP: f64 = 0.1;
const FALLEN: f64 = 0.5;
/// If the rounding error of x exceeds this fraction of the length scale at the start, gradients may be rounding error.
const NOTICED: f64 = 1e-3;

impl Descent<'_> {
    /// The reason at a feasible point: unbounded, if x is far away without a minimum. The problem may be left at another point.
    pub(in super::super) fn or_unbounded(
        &self,
        problem: &mut Counted,
        merit: &mut dyn Merit,
        (reason, tolerance): (Reason, f64),
    ) -> Reason {
        let (rounding, size) = (f64::EPSILON * largest_change(&self.at.x, &self.start), largest(&self.start));
        // In units of the length scale at the start: the largest variable, or 1.
        let far = if size > 0.0 { rounding / size } else { rounding };
        let last = self.history[self.history.len() - 1].stationarity;
        let is_end = match reason {
            Reason::Iterations | Reason::NoLowerValue => false,
            Reason::Stationary if far > 1.0 && last > tolerance => false,
            Reason::Stationary => far < NOTICED || !self.still_falls(self.steepest_nearby(problem, merit)),
            _ => true,
        };
        match reason {
            _ if is_end => reason,
            _ if far > 1.0 => Reason::Unbounded,
            Reason::Stationary => Reason::NoLowerValue,
            _ => reason,
        }
    }

    /// The larger of the gradients here and at a distance of the rounding error of the largest variable.
    fn steepest_nearby(&self, problem: &mut Counted, merit: &mut dyn Merit) -> f64 {
        let (mut x, mut gradient) = (self.at.x.clone(), vec![0.0; self.at.x.len()]);
        if let Some(x) = x.iter_mut().max_by(|a, b| a.abs().total_cmp(&b.abs())) {
            *x *= 1.0 - 4.0 * f64::EPSILON;
        }
        problem.project(&mut x);
        let is_there = merit.value(problem, &x).is_finite() && merit.gradient(problem, &mut gradient).is_ok();
        let nearby = if is_there { problem.stationarity(&x, &gradient) } else { 0.0 };
        nearby.max(problem.stationarity(&self.at.x, &self.at.gradient))
    }

    /// True if the value is mostly its decrease so far, and the gradient is as large as before: rounding may hide further decreases, but no minimum.
    pub(super) fn still_falls(&self, gradient: f64) -> bool {
        let value = self.history[self.history.len() - 1].value;
        let fall = self.history[0].value - value;
        fall > FALLEN * value.abs() && gradient * largest_change(&self.at.x, &self.start) > STEEP * fall
    }

    /// True if a parabola along the direction would decrease by no more than the rounding error of the value, which a line search cannot detect;
    /// false at a kink or a wall. The problem is left at another point.
    pub(super) fn is_flat(&self, problem: &mut Counted, merit: &mut dyn Merit) -> bool {
        let Point { x, value, gradient } = &self.at;
        let direction = self.direction(problem);
        let length = largest(&direction).max(f64::MIN_POSITIVE);
        // The distance to the origin or the largest step so far; at the origin itself, the first trial step.
        let reach = self.history.iter().fold(largest(x), |reach, it| reach.max(it.step));
        let alpha = AHEAD * if reach > 0.0 { reach / length } else { self.first(&direction, None) };
        let mut ahead = x.clone();
        add(&mut ahead, alpha, &direction);
        problem.project(&mut ahead);
        let mut there = vec![0.0; x.len()];
        if merit.value(problem, &ahead).is_infinite() || merit.gradient(problem, &mut there).is_err() {
            return false;
        }
        add(&mut ahead, -1.0, x);
        let slope = dot(gradient, &ahead);
        let curvature = dot(&there, &ahead) - slope;
        let [slope, curvature, value] = [slope, curvature, value.abs()].map(|x| x / self.unit);
        0.5 * slope * slope <= ROUNDING * value * curvature
    }
}
