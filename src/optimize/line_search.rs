//! A line search for the weak Wolfe conditions by interpolation and bisection (Lewis and Overton 2013), along P(x + α d).

use super::counted::Counted;
use crate::Error;

/// Constants of the Wolfe conditions: sufficient decrease of the value, and sufficient increase of the slope.
const DECREASE: f64 = 1e-4;
const SLOPE: f64 = 0.9;
/// Largest number of trials along a direction.
const MOST_TRIALS: usize = 50;

/// The function that a line search minimises: f, or a function of f and c.
pub(super) trait Merit {
    /// The value at a point; infinite if there is none.
    fn value(&mut self, problem: &mut Counted, x: &[f64]) -> f64;

    /// The gradient at the point of the last value.
    fn gradient(&mut self, problem: &mut Counted, gradient: &mut [f64]) -> Result<(), Error>;

    /// f at the point of the last value.
    fn cost(&self) -> f64;
}

/// A point with its value and gradient.
#[derive(Clone, Debug, Default)]
pub(super) struct Point {
    pub(super) x: Vec<f64>,
    pub(super) value: f64,
    pub(super) gradient: Vec<f64>,
}

/// A lower point along the direction, at which the problem is left; `None` if there is none up to rounding. Points without a gradient are rejected.
pub(super) fn search(
    problem: &mut Counted,
    merit: &mut dyn Merit,
    from: &Point,
    direction: &[f64],
    first: f64,
) -> Option<Point> {
    let (mut low, mut high, mut alpha) = (0.0, f64::INFINITY, first);
    let mut best: Option<Point> = None;
    let mut trial = Point { x: from.x.clone(), value: 0.0, gradient: vec![0.0; from.x.len()] };
    for _ in 0..MOST_TRIALS {
        trial.x.iter_mut().zip(&from.x).zip(direction).for_each(|((t, x), d)| *t = x + alpha * d);
        problem.project(&mut trial.x);
        if trial.x == from.x {
            break;
        }
        let slope = along(&from.gradient, &trial.x, &from.x);
        trial.value = merit.value(problem, &trial.x);
        let mut is_lower = trial.value <= from.value + DECREASE * slope && trial.value < from.value;
        if is_lower && merit.gradient(problem, &mut trial.gradient).is_err() {
            (is_lower, trial.value) = (false, f64::INFINITY);
        }
        if problem.is_stopped() {
            return None;
        }
        if is_lower {
            if along(&trial.gradient, &trial.x, &from.x) >= SLOPE * slope {
                return Some(trial);
            }
            low = alpha;
            best = Some(trial.clone());
        } else {
            high = alpha;
        }
        alpha = if high.is_infinite() {
            2.0 * low
        } else if low == 0.0 {
            // The minimum of the parabola, but not too close to either end.
            let rise = trial.value - from.value - slope;
            let share = if rise.is_finite() && rise > 0.0 { -0.5 * slope / rise } else { 0.1 };
            high * share.clamp(0.1, 0.5)
        } else {
            0.5 * (low + high)
        };
        if high - low <= 1e-14 * high {
            break;
        }
    }
    // A lower value with a steep slope is better than no lower value.
    best.filter(|best| merit.value(problem, &best.x).is_finite())
}

/// gᵀ (x − y).
fn along(g: &[f64], x: &[f64], y: &[f64]) -> f64 {
    g.iter().zip(x.iter().zip(y)).map(|(g, (x, y))| g * (x - y)).sum()
}
