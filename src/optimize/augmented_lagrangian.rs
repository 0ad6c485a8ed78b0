//! The augmented Lagrangian of Powell, Hestenes and Rockafellar, minimised by L-BFGS (Nocedal and Wright, Algorithm 17.4; Birgin and Martínez 2014).
//!
//! With multipliers w and penalties ρ_j: f + Σ ½ρ_j (t_j − P(t_j))², t_j = c_j + w_j/ρ_j, P the nearest value that is allowed. It serves equalities and
//! inequalities alike, and its gradient is that of f + Σ ρ_j (t_j − P(t_j)) c_j: one backward sweep. ρ_j = ρ/|∇c_j|² where constraints are violated first,
//! so that their units are no matter.

use super::counted::Counted;
use super::lbfgs::{Descent, Merit};
use super::norm::norm;
use super::problem::Interval;
use super::{Options, Outcome, Problem, Reason, Watcher};
use crate::Error;
use crate::number::dot;

/// The penalty grows by this factor where the violation did not shrink to this share.
const GROWTH: f64 = 10.0;
const SHRINKS: f64 = 0.25;
/// The least and the greatest first penalty, and one that drowns f in rounding, in a unit of their own ([`Augmented::unit`]).
const FIRST_PENALTY: [f64; 2] = [1e-6, 10.0];
const LARGEST_PENALTY: f64 = 1e12;
const MOST_ROUNDS: usize = 60;
/// A violation that becomes less than this share of the one before still comes closer: there is a limit to penalties then, not to constraints.
const CLOSER: f64 = 0.9;

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

/// Minimises f(x) subject to constraints and bounds. Where constraints are violated first their Jacobian is taken once, for their units.
///
/// # Errors
/// As [`lbfgs`](super::lbfgs()).
pub fn augmented_lagrangian(
    problem: &mut dyn Problem,
    start: &[f64],
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    let (mut counted, x) = Counted::new(problem, start, options)?;
    let cost = counted.evaluate_start(&x)?;
    let m = counted.c.len();
    let mut merit = Augmented { w: vec![0.0; m], penalty: None, shares: vec![1.0; m], steepness: [0.0; 2], cost };
    merit.note(&mut counted)?;
    merit.weigh(&mut counted)?;
    let value = merit.of(&counted);
    let mut descent = Descent::begin(&mut counted, &mut merit, (x, value), options)?;
    let found = rounds(&mut counted, &mut merit, &mut descent, options, watch);
    let reason = counted.reason(found, descent.history.len())?;
    let tolerance = options.stationarity * descent.history[0].stationarity;
    let reason = match counted.violation() <= options.violation {
        true => descent.or_unbounded(&mut counted, &mut merit, (reason, tolerance)),
        false => reason,
    };
    counted.ensure(&descent.at.x);
    let value = descent.history[descent.history.len() - 1].value;
    Ok(counted.outcome(descent.at.x, value, merit.w, descent.history, reason))
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
    let (asked, mut tolerance, mut violation) = (options.stationarity * first, 0.1 * first, f64::INFINITY);
    let mut reason = Reason::Iterations;
    for _ in 0..MOST_ROUNDS {
        let goal = tolerance.max(asked);
        reason = descent.run(problem, merit, goal, watch);
        // The constraints of the point itself, not of the last trial.
        if !merit.value(problem, &descent.at.x).is_finite() {
            // A problem that failed where it did not before: nothing is known of the constraints.
            return Ok(if reason.is_converged() { Reason::NoDerivative } else { reason });
        }
        let next = merit.multipliers(problem);
        let now = problem.violation().max(merit.change(&next));
        merit.w = next;
        let stationarity = problem.stationarity(&descent.at.x, &descent.at.gradient);
        if matches!(reason, Reason::Asked | Reason::Target | Reason::Iterations) {
            break;
        }
        // Above the goal nothing lower was found, nor would be in another round.
        if now <= options.violation && (stationarity <= asked || stationarity > goal) {
            break;
        }
        let grows = now > options.violation && now > SHRINKS * violation;
        if grows {
            merit.note(problem)?;
            if merit.penalty.is_some_and(|penalty| penalty >= LARGEST_PENALTY * merit.unit()) {
                // The largest penalty alone proves nothing: it is one for constraints of any units.
                let (x, reach, comes_closer) = (&descent.at.x, descent.reach(), now < CLOSER * violation);
                let is_least = !comes_closer && problem.is_least_violated(x, reach, &merit.shares)?;
                let is_infeasible = is_least && !problem.holds_to_rounding(x, reach)?;
                return Ok(if is_infeasible { Reason::Infeasible } else { Reason::NoLowerValue });
            }
            merit.penalty = merit.penalty.map(|penalty| GROWTH * penalty);
        }
        violation = now;
        tolerance *= 0.1;
        let value = merit.of(problem);
        descent.renew(problem, merit, value, grows)?;
    }
    Ok(reason)
}
