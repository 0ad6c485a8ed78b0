//! The augmented Lagrangian of Powell, Hestenes and Rockafellar, minimised by L-BFGS (Nocedal and Wright, Algorithm 17.4; Birgin and Martínez 2014).
//!
//! With multipliers w and penalties ρ_j it is f + Σ ½ρ_j (t_j − P(t_j))², t_j = c_j + w_j/ρ_j, where P(t) is the allowed value nearest to t. It
//! covers equalities and inequalities, and its gradient, that of f + Σ ρ_j (t_j − P(t_j)) c_j, costs one backward sweep. ρ_j = ρ/|∇c_j|² at the first
//! point that violates constraints, so that their units do not matter.

use nalgebra::DVector;

use super::counted::{Counted, Found, solve};
use super::degenerate::multipliers_diverge;
use super::lbfgs::Descent;
use super::least_squares::{Descended, descend};
use super::line_search::Merit;
use super::norm::norm;
use super::problem::Interval;
use super::{Options, Outcome, Problem, Reason, Watcher, silent};
use crate::Error;
use crate::number::dot;

/// Factor by which the penalty grows if the violation did not shrink to the fraction `SHRINKS` of the previous one.
const GROWTH: f64 = 10.0;
const SHRINKS: f64 = 0.25;
/// Bounds of the first penalty, and the penalty at which f is lost in rounding, in units of [`Augmented::unit`].
const FIRST_PENALTY: [f64; 2] = [1e-6, 10.0];
const LARGEST_PENALTY: f64 = 1e12;
const MOST_ROUNDS: usize = 60;
/// A violation above this fraction of the previous one is not reduced. After `STALLED` such larger penalties, violations alone are minimised.
const CLOSER: f64 = 0.9;
const STALLED: usize = 3;
/// Singular values of the Jacobian below this fraction of the largest are zero.
const SINGULAR: f64 = 1e-13;
/// Violations are minimal if some iterations reduce their squares by no more than this fraction: at the edge of an interval steps are short.
const CREEP: f64 = 1e-9;

struct Augmented {
    w: Vec<f64>,
    /// ρ; `None` until constraints are violated: while they hold without multipliers, ρ has no effect.
    penalty: Option<f64>,
    /// ρ_j/ρ.
    shares: Vec<f64>,
    /// The largest |∇f| so far, and |∇ ½ Σ ρ_j/ρ v_j²| of the first violations v.
    steepness: [f64; 2],
    /// f at the point of the last value.
    cost: f64,
}

impl Augmented {
    /// ρ_j.
    fn penalty(&self, j: usize) -> Option<f64> {
        self.penalty.map(|penalty| penalty * self.shares[j])
    }

    /// ρ_j (t_j − P(t_j)): the multiplier for a value of a constraint.
    fn multiplier(&self, j: usize, c: f64, of: &Interval) -> f64 {
        self.penalty(j).map_or(0.0, |penalty| {
            let t = c + self.w[j] / penalty;
            penalty * (t - of.nearest(t))
        })
    }

    fn multipliers(&self, problem: &Counted) -> Vec<f64> {
        problem.c.iter().zip(&problem.intervals).enumerate().map(|(j, (c, of))| self.multiplier(j, *c, of)).collect()
    }

    /// The largest change of a multiplier divided by its penalty: the violation of an equality; for an inequality with a multiplier also its distance
    /// from the bound, at most w_j/ρ_j.
    fn change(&self, next: &[f64]) -> f64 {
        let changes = self.w.iter().zip(next).enumerate();
        changes.filter_map(|(j, (w, next))| Some((next - w).abs() / self.penalty(j)?)).fold(0.0, f64::max)
    }

    /// The augmented Lagrangian at the last evaluated point.
    fn of(&self, problem: &Counted) -> f64 {
        let multipliers = self.multipliers(problem);
        let of_penalty = multipliers.iter().enumerate().filter_map(|(j, w)| Some(0.5 * w * w / self.penalty(j)?));
        self.cost + of_penalty.sum::<f64>()
    }

    /// Updates |∇f| from the last evaluated point.
    fn note(&mut self, problem: &mut Counted) -> Result<(), Error> {
        let none = vec![0.0; problem.c.len()];
        self.steepness[0] = self.steepness[0].max(length_of_gradient(problem, 1.0, &none)?);
        Ok(())
    }

    /// The penalty for which the gradients of f and of the penalty term are equally large, whatever their units are; 1 if there is none.
    fn unit(&self) -> f64 {
        let unit = self.steepness[0] / self.steepness[1];
        if unit.is_normal() { unit } else { 1.0 }
    }

    /// Sets the first penalty at the first point that violates constraints, so that f and the penalty term are equal there.
    fn weigh(&mut self, problem: &mut Counted) -> Result<(), Error> {
        if self.penalty.is_some() {
            return Ok(());
        }
        let violations = problem.excess();
        if violations.iter().all(|violation| *violation == 0.0) {
            return Ok(());
        }
        self.note(problem)?;
        self.shares = shares(problem)?;
        let weighted = Vec::from_iter(violations.iter().zip(&self.shares).map(|(violation, share)| violation * share));
        let squares = dot(&violations, &weighted);
        self.steepness[1] = length_of_gradient(problem, 0.0, &weighted)?;
        let [least, most] = FIRST_PENALTY.map(|penalty| penalty * self.unit());
        let alike = 2.0 * self.cost.abs() / squares;
        self.penalty = Some(if self.cost == 0.0 { self.unit() } else { alike.clamp(least, most) });
        Ok(())
    }
}

impl Merit for Augmented {
    fn value(&mut self, problem: &mut Counted, x: &[f64]) -> f64 {
        self.cost = problem.evaluate(x);
        if self.cost.is_finite() && self.weigh(problem).is_ok() { self.of(problem) } else { f64::INFINITY }
    }

    fn gradient(&mut self, problem: &mut Counted, gradient: &mut [f64]) -> Result<(), Error> {
        let weights = self.multipliers(problem);
        problem.gradient(1.0, &weights, gradient)
    }

    fn cost(&self) -> f64 {
        self.cost
    }
}

/// |∇c_j|⁻² at the last evaluated point; the smallest of them for a constraint with zero gradient; 1 for a free constraint.
fn shares(problem: &mut Counted) -> Result<Vec<f64>, Error> {
    let asked = Vec::from_iter(problem.asked());
    let jacobian = problem.jacobian(&asked)?;
    let share = |row: usize| norm(&Vec::from_iter(jacobian.row(row).iter().copied())).powi(-2);
    let found = Vec::from_iter((0..asked.len()).map(|row| Some(share(row)).filter(|share| share.is_normal())));
    let least = found.iter().copied().flatten().reduce(f64::min).unwrap_or(1.0);
    let mut shares = vec![1.0; problem.c.len()];
    asked.iter().zip(found).for_each(|(&j, share)| shares[j] = share.unwrap_or(least));
    Ok(shares)
}

fn length_of_gradient(problem: &mut Counted, of_cost: f64, of_c: &[f64]) -> Result<f64, Error> {
    let mut gradient = vec![0.0; problem.bounds.len()];
    problem.gradient(of_cost, of_c, &mut gradient)?;
    Ok(norm(&gradient))
}

/// Minimises f(x) subject to constraints and bounds by gradients alone. The Jacobian of the constraints is computed once, at the first
/// violated point, to scale them. If larger penalties do not reduce the violations of the constraints, the sum of squares of the violations
/// is minimised as by [`levenberg_marquardt`](super::levenberg_marquardt()), regardless of f; these iterations are not passed to `watch`,
/// and the history contains only their result.
///
/// # Errors
/// As [`lbfgs`](super::lbfgs()).
pub fn augmented_lagrangian(
    problem: &mut dyn Problem,
    start: &[f64],
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    solve(problem, start, options, |problem, x| {
        let (cost, m) = (problem.evaluate_start(&x)?, problem.c.len());
        let mut merit = Augmented { w: vec![0.0; m], penalty: None, shares: vec![1.0; m], steepness: [0.0; 2], cost };
        merit.note(problem)?;
        merit.weigh(problem)?;
        let value = merit.of(problem);
        let mut descent = Descent::begin(problem, &mut merit, (x, value), options)?;
        let found = rounds(problem, &mut merit, &mut descent, options, watch);
        let reason = problem.reason(found, descent.history.len())?;
        let tolerance = options.stationarity * descent.history[0].stationarity;
        let reason = match problem.violation() <= options.violation {
            true => descent.or_unbounded(problem, &mut merit, (reason, tolerance)),
            false => reason,
        };
        let is_end = reason == Reason::Stationary && problem.violation() <= options.violation;
        let is_degenerate = is_end && multipliers_diverge(problem, (&descent.at.x, &merit.w), tolerance).unwrap_or(false);
        let reason = if is_degenerate { Reason::Degenerate } else { reason };
        problem.ensure(&descent.at.x);
        let value = descent.history[descent.history.len() - 1].value;
        Ok(Found { x: descent.at.x, value, multipliers: merit.w, history: descent.history, reason })
    })
}

/// Minimisations, each with the multipliers of the previous one, and with larger penalties if violations do not decrease.
fn rounds(
    problem: &mut Counted,
    merit: &mut Augmented,
    descent: &mut Descent,
    options: &Options,
    watch: &mut Watcher,
) -> Result<Reason, Error> {
    let first = descent.history[0].stationarity;
    let (asked, mut tolerance, mut before) = (options.stationarity * first, 0.1 * first, f64::INFINITY);
    let (mut stalled, mut is_second) = (0, false);
    let (start, violation_of_start) = (descent.at.x.clone(), norm(&problem.excess()));
    for _ in 0..MOST_ROUNDS {
        let goal = tolerance.max(asked);
        let reason = descent.run(problem, merit, goal, watch);
        // The constraints at the point itself, not at the last trial.
        if !merit.value(problem, &descent.at.x).is_finite() {
            // The evaluation fails although it succeeded before, so the constraints are not known.
            return Ok(if reason.is_converged() { Reason::NoDerivative } else { reason });
        }
        let (next, violation) = (merit.multipliers(problem), norm(&problem.excess()));
        let now = problem.violation().max(merit.change(&next));
        merit.w = next;
        let stationarity = problem.stationarity(&descent.at.x, &descent.at.gradient);
        if matches!(reason, Reason::Interrupted | Reason::Target | Reason::Iterations) {
            return Ok(reason);
        }
        // If the stationarity is above the goal, no lower value was found, and another round would find none.
        if now <= options.violation && (stationarity <= asked || stationarity > goal) {
            return Ok(reason);
        }
        let grows = now > options.violation && now > SHRINKS * before;
        if grows {
            merit.note(problem)?;
            let is_violated = problem.violation() > options.violation;
            stalled = if is_violated && now > CLOSER * before { stalled + 1 } else { 0 };
            let is_largest = merit.penalty.is_some_and(|penalty| penalty >= LARGEST_PENALTY * merit.unit());
            if is_largest && !is_violated {
                return Ok(Reason::NoLowerValue);
            }
            if is_largest || stalled == STALLED {
                let held = descent.history.iter().any(|of| of.violation <= options.violation);
                let is_away = !held && violation > violation_of_start;
                let from = if is_away { &start } else { &descent.at.x }.clone();
                match approach(problem, merit, descent, options, from)? {
                    Some(Reason::Infeasible) if held => return Ok(Reason::NoLowerValue),
                    Some(reason) => return Ok(reason),
                    None if is_largest || is_second => return Ok(Reason::NoLowerValue),
                    None => {}
                }
                (stalled, is_second, before) = (0, true, f64::INFINITY);
                continue;
            }
            merit.penalty = merit.penalty.map(|penalty| GROWTH * penalty);
        }
        before = now;
        tolerance *= 0.1;
        let value = merit.of(problem);
        descent.renew(problem, merit, value, grows)?;
    }
    Ok(Reason::NoLowerValue)
}

/// Minimises the sum of squared violations from a point to rounding error, regardless of f. Returns the reason to stop there; `None` if the
/// constraints hold, in which case the multipliers are those that approximate −∇f best.
fn approach(
    problem: &mut Counted,
    merit: &mut Augmented,
    descent: &mut Descent,
    options: &Options,
    from: Vec<f64>,
) -> Result<Option<Reason>, Error> {
    let iterations = options.iterations.saturating_sub(descent.history.len() - 1 + problem.apart);
    let target = Some(0.5 * options.violation.powi(2));
    let options = Options { iterations, target, stationarity: 0.0, ..*options };
    let failures = problem.failures;
    let found = descend(problem, from, &options, &mut silent, CREEP);
    // Points without a value may hide lower sums.
    let meets_wall = problem.failures > failures;
    let Ok(Descended { at, history, reason }) = found else { return Ok(Some(Reason::NoLowerValue)) };
    problem.apart += history.len() - 1;
    merit.w.fill(0.0);
    let holds = problem.violation() <= options.violation;
    if holds {
        let mut slope = DVector::zeros(at.x.len());
        problem.gradient(1.0, &merit.w, slope.as_mut_slice())?;
        let svd = at.jacobian.transpose().svd(true, true);
        let multipliers = svd.solve(&-slope, SINGULAR * svd.singular_values.amax()).unwrap_or_default();
        problem.asked().zip(&multipliers).for_each(|(j, w)| merit.w[j] = *w);
    }
    let (value, is_rounding) = (merit.value(problem, &at.x), at.is_rounding());
    descent.go(problem, merit, (at.x, value))?;
    Ok(match reason {
        _ if holds => None,
        // If units differ by many powers of ten, rounding errors of large violations hide the slopes of small ones; then no step finds a lower sum.
        Reason::Stationary if !is_rounding => Some(Reason::Infeasible),
        Reason::NoLowerValue if !is_rounding && (!meets_wall || problem.is_least_violated(&descent.at.x, 0.0)?) => {
            Some(Reason::Infeasible)
        }
        Reason::Stationary | Reason::Target => Some(Reason::NoLowerValue),
        other => Some(other),
    })
}
