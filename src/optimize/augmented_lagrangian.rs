//! The augmented Lagrangian of Powell, Hestenes and Rockafellar, minimised by L-BFGS (Nocedal and Wright, Algorithm 17.4; Birgin and Martínez 2014).
//!
//! With multipliers w and a penalty ρ: f + Σ ½ρ (t_j − P(t_j))², t = c + w/ρ, P the nearest value that is allowed. It serves equalities and
//! inequalities alike, and its gradient is that of f + Σ ρ (t_j − P(t_j)) c_j: one backward sweep.

use super::lbfgs::{Descent, Merit};
use super::outcome::Counted;
use super::problem::Interval;
use super::{Options, Outcome, Problem, Reason, Watcher};
use crate::Error;
use crate::number::dot;

/// The penalty grows by this factor where the violation did not shrink to this share.
const GROWTH: f64 = 10.0;
const SHRINKS: f64 = 0.25;
/// The least and the greatest first penalty, and one that drowns f in rounding, in a unit of their own ([`Steepness`]).
const FIRST_PENALTY: [f64; 2] = [1e-6, 10.0];
const LARGEST_PENALTY: f64 = 1e12;
const MOST_ROUNDS: usize = 60;

struct Augmented {
    w: Vec<f64>,
    penalty: f64,
    /// f at the point of the last value.
    cost: f64,
}

impl Augmented {
    /// ρ (t − P(t)): the multiplier that belongs to a value of a constraint.
    fn multiplier(&self, j: usize, c: f64, of: &Interval) -> f64 {
        let t = c + self.w[j] / self.penalty;
        self.penalty * (t - of.nearest(t))
    }

    fn multipliers<P: Problem + ?Sized>(&self, problem: &Counted<P>) -> Vec<f64> {
        problem.c.iter().zip(&problem.intervals).enumerate().map(|(j, (c, of))| self.multiplier(j, *c, of)).collect()
    }

    /// The augmented Lagrangian at the point that was evaluated last.
    fn of<P: Problem + ?Sized>(&self, problem: &Counted<P>) -> f64 {
        self.cost + self.multipliers(problem).iter().map(|w| 0.5 * w * w / self.penalty).sum::<f64>()
    }
}

impl<P: Problem + ?Sized> Merit<P> for Augmented {
    fn value(&mut self, problem: &mut Counted<P>, x: &[f64]) -> f64 {
        self.cost = problem.evaluate(x);
        if self.cost.is_finite() { self.of(problem) } else { f64::INFINITY }
    }

    fn gradient(&mut self, problem: &mut Counted<P>, gradient: &mut [f64]) -> Result<(), Error> {
        let weights = self.multipliers(problem);
        problem.gradient(1.0, &weights, gradient)
    }

    fn cost(&self) -> f64 {
        self.cost
    }
}

/// |∇f|, the largest so far, and |∇ ½ Σ v²| of the violations v at the start.
struct Steepness {
    of_cost: f64,
    of_violations: f64,
}

impl Steepness {
    fn at_start<P: Problem + ?Sized>(problem: &mut Counted<P>) -> Result<Self, Error> {
        let violations: Vec<f64> = problem.c.iter().zip(&problem.intervals).map(|(c, of)| of.excess(*c)).collect();
        let of_violations = length_of_gradient(problem, 0.0, &violations)?;
        let mut steepness = Steepness { of_cost: 0.0, of_violations };
        steepness.note(problem)?;
        Ok(steepness)
    }

    /// Takes note of f at the point that was evaluated last.
    fn note<P: Problem + ?Sized>(&mut self, problem: &mut Counted<P>) -> Result<(), Error> {
        let none = vec![0.0; problem.c.len()];
        self.of_cost = self.of_cost.max(length_of_gradient(problem, 1.0, &none)?);
        Ok(())
    }

    /// The penalty that makes both alike, whatever the units of f and c are; 1 if there is none.
    fn unit(&self) -> f64 {
        let unit = self.of_cost / self.of_violations;
        if unit.is_normal() { unit } else { 1.0 }
    }
}

fn length_of_gradient<P: Problem + ?Sized>(problem: &mut Counted<P>, of_cost: f64, of_c: &[f64]) -> Result<f64, Error> {
    let mut gradient = vec![0.0; problem.bounds.len()];
    problem.gradient(of_cost, of_c, &mut gradient)?;
    Ok(dot(&gradient, &gradient).sqrt())
}

/// Minimises f(x) subject to constraints and bounds.
///
/// # Errors
/// As [`lbfgs`](super::lbfgs()).
pub fn augmented_lagrangian<P: Problem + ?Sized>(
    problem: &mut P,
    start: &[f64],
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    let (mut counted, x) = Counted::new(problem, start, options)?;
    let f = counted.evaluate_start(&x)?;
    let squares: f64 = counted.c.iter().zip(&counted.intervals).map(|(c, of)| of.violation(*c).powi(2)).sum();
    // f and what constraints add to it begin alike.
    let mut steepness = Steepness::at_start(&mut counted)?;
    let [least, most] = FIRST_PENALTY.map(|penalty| penalty * steepness.unit());
    let penalty = if squares > 0.0 && f != 0.0 { (2.0 * f.abs() / squares).clamp(least, most) } else { steepness.unit() };
    let mut merit = Augmented { w: vec![0.0; counted.c.len()], penalty, cost: f };
    let value = merit.of(&counted);
    let mut descent = Descent::begin(&mut counted, &mut merit, (x, value), options)?;
    let asked = options.stationarity * descent.history[0].stationarity;
    let mut tolerance = 0.1 * descent.history[0].stationarity;
    let mut violation = f64::INFINITY;
    let mut reason = Reason::Iterations;
    for _ in 0..MOST_ROUNDS {
        let goal = tolerance.max(asked);
        reason = descent.run(&mut counted, &mut merit, goal, watch)?;
        // The constraints of the point itself, not of the last trial.
        merit.value(&mut counted, &descent.at.x);
        let now = counted.violation();
        merit.w = merit.multipliers(&counted);
        let stationarity = counted.stationarity(&descent.at.x, &descent.at.gradient);
        if matches!(reason, Reason::Asked | Reason::Target | Reason::Iterations) {
            break;
        }
        // Above the goal nothing lower was found, nor would be in another round.
        if now <= options.violation && (stationarity <= asked || stationarity > goal) {
            break;
        }
        let grows = now > options.violation && now > SHRINKS * violation;
        if grows {
            steepness.note(&mut counted)?;
            if merit.penalty >= LARGEST_PENALTY * steepness.unit() {
                reason = Reason::Infeasible;
                break;
            }
            merit.penalty *= GROWTH;
        }
        violation = now;
        tolerance *= 0.1;
        let value = merit.of(&counted);
        descent.renew(&mut counted, &mut merit, value, grows)?;
    }
    let (x, value, w) = (descent.at.x, merit.cost, merit.w);
    Ok(counted.outcome(x, value, w, descent.history, reason))
}
