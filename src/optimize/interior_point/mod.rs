//! An interior-point method with trust regions and exact second derivatives (Byrd, Hribar and Nocedal 1999). Without bounds and inequalities it is
//! sequential quadratic programming by Byrd and Omojokun, without constraints the Newton–CG method of Steihaug.
//!
//! ```text
//!   min f(x) − μ Σ ln(distances of y = (x, s) from bounds)      C(y) = 0: equalities c = l_c, and c − s = 0 of inequalities
//! ```
//!
//! for decreasing μ ([`method`]); steps ([`trust_region`](super::trust_region)) are judged at the points to which they lead. If violations do not
//! decrease, they alone are minimised ([`feasibility`]).

mod feasibility;
mod method;
mod saddle;

use super::counted::{Counted, Found, solve};
use super::degenerate::multipliers_diverge;
use super::outcome::largest_change;
use super::trust_region::ROUNDING;
use super::{Iterate, Options, Outcome, Problem, Reason, Watcher};
use crate::Error;
use method::Method;

/// Violations do not decrease if, over this many iterations, all exceed the fraction `SLOW` of the first and `ALIKE` of the largest.
const SLOW_FOR: usize = 20;
const SLOW: f64 = 0.9;
const ALIKE: f64 = 0.5;
/// The method ends after this many steps with no predicted decrease except rounding error, neither of φ nor of the violation.
const MOST_IDLE: usize = 10;

/// Minimises f(x) subject to constraints and bounds with exact products of the Hessian ([`Problem::product`]). The Jacobian of the
/// constraints costs one right-hand side of a backward sweep for each constraint. A start at a bound is moved inside by a hundredth of the
/// bound or of the distance to the other bound, whichever is smaller; if the bound is 0, the largest variable (1 if all are 0) replaces it. The start
/// is moved by less if the problem has no value at the moved start. If the violation does not decrease, up to 100 iterations of a feasibility
/// phase minimise it regardless of f; they have a limit of their own, [`Options::iterations`] in total, and only their end is passed to `watch`
/// and stored in the history.
///
/// At a point where the constraints hold, the method evaluates a neighbouring point to confirm that multipliers exist ([`Reason::Degenerate`]).
///
/// # Errors
/// Invalid sizes, bounds or options, or a problem without Hessian products.
pub fn interior_point(
    problem: &mut dyn Problem,
    start: &[f64],
    options: &Options,
    watch: &mut Watcher,
) -> Result<Outcome, Error> {
    solve(problem, start, options, |problem, x| {
        let mut method = Method::new(problem, &x, options.violation)?;
        let mut iterations = Iterations { history: vec![method.iterate(problem, 0.0)], idle: 0, begin: 0 };
        let found = iterate(problem, &mut method, &mut iterations, options, watch);
        let reason = problem.reason(found, iterations.history.len())?;
        let multipliers = method.all_multipliers(problem);
        let (x, value) = (method.x().as_slice().to_vec(), method.value);
        let (small, feasible) = (loosest(&method, &iterations, options), iterations.last().violation <= options.violation);
        let reason = if feasible { or_degenerate(problem, reason, (&x, &multipliers), small) } else { reason };
        // The problem is left with the motion of the solution.
        problem.ensure(&x);
        Ok(Found { x, value, multipliers, history: iterations.history, reason })
    })
}

/// Iterates until there is a reason to stop.
fn iterate(
    counted: &mut Counted,
    method: &mut Method,
    iterations: &mut Iterations,
    options: &Options,
    watch: &mut Watcher,
) -> Result<Reason, Error> {
    let (mut allowed, unit) = (options.violation, method.barrier.unit);
    method.region.radius = method.first_radius(options);
    loop {
        let last = iterations.last();
        if watch(&last, method.x().as_slice()).is_break() {
            return Ok(Reason::Interrupted);
        }
        let feasible = last.violation <= allowed;
        if feasible && options.target.is_some_and(|target| last.value <= target) {
            return Ok(Reason::Target);
        }
        let is_without_end = iterations.falls() && method.is_far(unit);
        // If constraints held before, a violation may be the rounding error of long steps in any direction.
        let reach = if iterations.held(options.violation) { method.x().norm() } else { 0.0 };
        if is_without_end && (feasible || counted.holds_to_rounding(method.x().as_slice(), reach)?) {
            return Ok(Reason::Unbounded);
        }
        let mut asked = loosest(method, iterations, options);
        if feasible && last.stationarity <= asked {
            asked = options.stationarity * method.reference(counted, iterations.history[0].stationarity)?;
        }
        if feasible && is_stationary(method, counted, iterations, (asked, options.violation))? {
            return Ok(Reason::Stationary);
        }
        if iterations.history.len() > options.iterations || counted.apart > options.iterations {
            return Ok(Reason::Iterations);
        }
        method.lower_barrier(method.small_mu(asked).max(f64::MIN_POSITIVE));
        let ends = iterations.idle >= MOST_IDLE || !feasible && iterations.is_slow();
        match if ends { None } else { method.advance(counted)? } {
            Some((length, is_idle)) => iterations.go(method.iterate(counted, length), is_idle),
            None if counted.is_stopped() => return Ok(Reason::Interrupted),
            None if feasible => return last_reason(method, counted, iterations, (asked, options.violation)),
            // A smaller violation cannot be required.
            None if holds_to_rounding(method, counted)? => allowed = last.violation,
            None => {
                let left = Options { iterations: options.iterations - counted.apart, ..*options };
                let x = method.x().as_slice().to_vec();
                let (end, is_least) = feasibility::approach(counted, &x, &left)?;
                let step = largest_change(&end, &x);
                *method = Method::at(counted, &method.start, end, allowed)?;
                method.region.radius = method.first_radius(options);
                iterations.begin_again(method.iterate(counted, step));
                if is_least {
                    let x = method.x();
                    if !counted.holds_to_rounding(x.as_slice(), 0.0)? {
                        let is_least = counted.is_least_violated(x.as_slice(), unit)?;
                        return Ok(if is_least { Reason::Infeasible } else { Reason::NoLowerValue });
                    }
                    // A smaller violation cannot be required.
                    allowed = counted.violation();
                }
            }
        }
    }
}

/// The largest tolerance of stationarity that may apply.
fn loosest(method: &Method, iterations: &Iterations, options: &Options) -> f64 {
    options.stationarity * method.scale().max(iterations.history[0].stationarity)
}

/// The reason to stop: [`Reason::Degenerate`] at a feasible point if the multipliers of its constraints do not exist.
fn or_degenerate(problem: &mut Counted, reason: Reason, at: (&[f64], &[f64]), small: f64) -> Reason {
    let is_end = matches!(reason, Reason::Stationary | Reason::NoLowerValue | Reason::Iterations);
    // Without derivatives nearby nothing is known.
    let is_degenerate = is_end && multipliers_diverge(problem, at, small).unwrap_or(false);
    match reason {
        _ if problem.is_stopped() => Reason::Interrupted,
        _ if is_degenerate => Reason::Degenerate,
        reason => reason,
    }
}

/// True if the constraints hold at the current point up to rounding.
fn holds_to_rounding(method: &Method, problem: &mut Counted) -> Result<bool, Error> {
    let x = method.x();
    Ok(problem.ensure(x.as_slice()) && problem.holds_to_rounding(x.as_slice(), 0.0)?)
}

/// True if the gradient is within the tolerance or, if the value no longer changes, within its rounding error; and if the constraints hold.
fn is_stationary(method: &Method, problem: &mut Counted, iterations: &Iterations, asked: (f64, f64)) -> Result<bool, Error> {
    let Iterate { stationarity, violation, .. } = iterations.last();
    let is_small =
        method.is_small(stationarity, asked.0) || iterations.stays() && method.is_rounding(problem, stationarity)?;
    Ok(is_small && holds(method, problem, violation <= asked.1)?)
}

/// True if the constraints hold within the tolerance, or to rounding error that finite differences confirm.
fn holds(method: &Method, problem: &mut Counted, as_asked: bool) -> Result<bool, Error> {
    let x = method.x();
    Ok(as_asked || problem.ensure(x.as_slice()) && problem.is_rounding(x.as_slice())?)
}

/// The reason to stop at a feasible point without a further step; the multipliers are already those of a smaller barrier.
fn last_reason(
    method: &Method,
    problem: &mut Counted,
    iterations: &mut Iterations,
    asked: (f64, f64),
) -> Result<Reason, Error> {
    problem.ensure(method.x().as_slice());
    let now = method.iterate(problem, iterations.last().step);
    iterations.history.pop();
    iterations.history.push(now);
    let is_small = method.is_small(now.stationarity, asked.0) || method.is_rounding(problem, now.stationarity)?;
    let is_end = is_small && holds(method, problem, now.violation <= asked.1)?;
    Ok(if is_end { Reason::Stationary } else { Reason::NoLowerValue })
}

/// The iterations so far.
struct Iterations {
    history: Vec<Iterate>,
    /// Number of last steps without a predicted decrease.
    idle: usize,
    /// The iterate at which the method was last started.
    begin: usize,
}

impl Iterations {
    fn last(&self) -> Iterate {
        self.history[self.history.len() - 1]
    }

    fn go(&mut self, to: Iterate, is_idle: bool) {
        self.idle = if is_idle { self.idle + 1 } else { 0 };
        self.history.push(to);
    }

    fn begin_again(&mut self, at: Iterate) {
        (self.idle, self.begin) = (0, self.history.len());
        self.history.push(at);
    }

    /// True if the constraints held at any iterate.
    fn held(&self, allowed: f64) -> bool {
        self.history.iter().any(|of| of.violation <= allowed)
    }

    /// True if the last step led to a lower value, which is also lower than that of the start.
    fn falls(&self) -> bool {
        let before = self.history.iter().rev().nth(1);
        before.is_some_and(|before| self.last().value < before.value.min(self.history[0].value))
    }

    /// True if the last step changed the value only by rounding error.
    fn stays(&self) -> bool {
        let before = self.history.iter().rev().nth(1);
        before.is_some_and(|before| (self.last().value - before.value).abs() <= ROUNDING * self.last().value.abs())
    }

    /// True if the violations stagnate; near a feasible point they change from iterate to iterate.
    fn is_slow(&self) -> bool {
        let Some(lately) = self.history[self.begin..].last_chunk::<SLOW_FOR>() else { return false };
        let violations = lately.map(|of| of.violation);
        let (least, most) = violations.iter().fold((f64::INFINITY, 0.0f64), |(least, most), &x| (least.min(x), most.max(x)));
        least > ALIKE * most && least > SLOW * violations[0]
    }
}
