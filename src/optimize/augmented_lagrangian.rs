//! The augmented Lagrangian of Powell, Hestenes and Rockafellar, minimised by L-BFGS (Nocedal and Wright, Algorithm 17.4; Birgin and Martínez 2014).
//!
//! With multipliers w and penalties ρ_j: f + Σ ½ρ_j (t_j − P(t_j))², t_j = c_j + w_j/ρ_j, P the nearest value that is allowed. It serves equalities and
//! inequalities alike, and its gradient is that of f + Σ ρ_j (t_j − P(t_j)) c_j: one backward sweep. ρ_j = ρ/|∇c_j|² where constraints are violated first,
//! so that their units are no matter.

use nalgebra::DVector;

use super::counted::{Counted, Found, solve};
use super::lbfgs::{Descent, Merit};
use super::least_squares::{Descended, descend};
use super::norm::norm;
use super::problem::Interval;
use super::{Options, Outcome, Problem, Reason, Watcher, silent};
use crate::Error;
use crate::number::dot;

/// The penalty grows by this factor where the violation did not shrink to this share.
const GROWTH: f64 = 10.0;
const SHRINKS: f64 = 0.25;
/// The least and the greatest first penalty, and one that drowns f in rounding, in a unit of their own ([`Augmented::unit`]).
const FIRST_PENALTY: [f64; 2] = [1e-6, 10.0];
const LARGEST_PENALTY: f64 = 1e12;
const MOST_ROUNDS: usize = 60;
/// A violation above this share of the one before comes no closer. After so many greater penalties that brought it no closer, violations alone are minimised.
const CLOSER: f64 = 0.9;
const STALLED: usize = 3;
/// Singular values of the Jacobian below this share of the largest are zero.
const SINGULAR: f64 = 1e-13;
/// Violations whose squares some iterations lower by no more than this share are least: at the edge of an interval steps are short.
const CREEP: f64 = 1e-9;

struct Augmented {
    w: Vec<f64>,
    /// ρ; none until constraints are violated somewhere: where they hold, without multipliers, it is no matter.
    penalty: Option<f64>,
    /// ρ_j/ρ.
    shares: Vec<f64>,
    /// |∇f|, the largest so far, and |∇ ½ Σ ρ_j/ρ v_j²| of the first violations v.
    steepness: [f64; 2],
    /// f at the point of the last value.
    cost: f64,
}

impl Augmented {
    /// ρ_j.
    fn penalty(&self, j: usize) -> Option<f64> {
        self.penalty.map(|penalty| penalty * self.shares[j])
    }

    /// ρ_j (t_j − P(t_j)): the multiplier that belongs to a value of a constraint.
    fn multiplier(&self, j: usize, c: f64, of: &Interval) -> f64 {
        self.penalty(j).map_or(0.0, |penalty| {
            let t = c + self.w[j] / penalty;
            penalty * (t - of.nearest(t))
        })
    }

    fn multipliers(&self, problem: &Counted) -> Vec<f64> {
        problem.c.iter().zip(&problem.intervals).enumerate().map(|(j, (c, of))| self.multiplier(j, *c, of)).collect()
    }

    /// The largest change of a multiplier, in the unit of its constraint: an equality's violation; of an inequality also how far from its bound it is while
    /// it has a multiplier, which would be as large as that is.
    fn change(&self, next: &[f64]) -> f64 {
        let changes = self.w.iter().zip(next).enumerate();
        changes.filter_map(|(j, (w, next))| Some((next - w).abs() / self.penalty(j)?)).fold(0.0, f64::max)
    }

    /// The augmented Lagrangian at the point that was evaluated last.
    fn of(&self, problem: &Counted) -> f64 {
        let multipliers = self.multipliers(problem);
        let of_penalty = multipliers.iter().enumerate().filter_map(|(j, w)| Some(0.5 * w * w / self.penalty(j)?));
        self.cost + of_penalty.sum::<f64>()
    }

    /// Takes note of f at the point that was evaluated last.
    fn note(&mut self, problem: &mut Counted) -> Result<(), Error> {
        let none = vec![0.0; problem.c.len()];
        self.steepness[0] = self.steepness[0].max(length_of_gradient(problem, 1.0, &none)?);
        Ok(())
    }

    /// The penalty that makes f and the violations alike in steepness, whatever their units are; 1 if there is none.
    fn unit(&self) -> f64 {
        let unit = self.steepness[0] / self.steepness[1];
        if unit.is_normal() { unit } else { 1.0 }
    }

    /// Takes the first penalty where constraints are violated first: f and what they add to it begin alike.
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

/// |∇c_j|⁻² at the point that was evaluated last; of a constraint that changes with nothing there, the least of them; 1 where any value is allowed.
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
        problem.ensure(&descent.at.x);
        let value = descent.history[descent.history.len() - 1].value;
        Ok(Found { x: descent.at.x, value, multipliers: merit.w, history: descent.history, reason })
    })
}

/// Descents, each with multipliers that the one before left, and greater penalties where constraints come no closer. The problem is left at the end.
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
        // The constraints of the point itself, not of the last trial.
        if !merit.value(problem, &descent.at.x).is_finite() {
            // A problem that failed where it did not before: nothing is known of the constraints.
            return Ok(if reason.is_converged() { Reason::NoDerivative } else { reason });
        }
        let (next, violation) = (merit.multipliers(problem), norm(&problem.excess()));
        let now = problem.violation().max(merit.change(&next));
        merit.w = next;
        let stationarity = problem.stationarity(&descent.at.x, &descent.at.gradient);
        if matches!(reason, Reason::Interrupted | Reason::Target | Reason::Iterations) {
            return Ok(reason);
        }
        // Above the goal nothing lower was found, nor would be in another round.
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

/// Goes from a point to where the sum of squares of violations is least to rounding, whatever f becomes: why that is the end, none if constraints hold
/// there. Then the multipliers are those that come closest to −∇f.
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
        // In units that differ by many powers of ten, the slopes of small violations are rounding beside those of others: then no step finds a lower sum.
        Reason::Stationary if !is_rounding => Some(Reason::Infeasible),
        Reason::NoLowerValue if !is_rounding && (!meets_wall || problem.is_least_violated(&descent.at.x, 0.0)?) => {
            Some(Reason::Infeasible)
        }
        Reason::Stationary | Reason::Target => Some(Reason::NoLowerValue),
        other => Some(other),
    })
}
