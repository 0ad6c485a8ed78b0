//! L-BFGS with bounds: projected quasi-Newton steps of the variables that no bound holds (Bertsekas 1982; Nocedal and Wright, Algorithm 7.4).

mod ends;

use super::counted::{Counted, Found, solve};
use super::line_search::{Merit, Point, search};
use super::norm::magnitude;
use super::outcome::largest_change;
use super::{Interval, Iterate, Options, Outcome, Problem, Reason, Watcher};
use crate::Error;
use crate::number::{dot, largest};
use std::collections::VecDeque;

/// Differences of a value below this fraction of it are rounding error.
const ROUNDING: f64 = 1e-14;

/// f itself.
struct Cost(f64);

impl Merit for Cost {
    fn value(&mut self, problem: &mut Counted, x: &[f64]) -> f64 {
        self.0 = problem.evaluate(x);
        self.0
    }

    fn gradient(&mut self, problem: &mut Counted, gradient: &mut [f64]) -> Result<(), Error> {
        let none = vec![0.0; problem.c.len()];
        problem.gradient(1.0, &none, gradient)
    }

    fn cost(&self) -> f64 {
        self.0
    }
}

/// Minimises f(x) within bounds on x by the limited-memory BFGS method. All constraints must be free ([`Interval::FREE`]).
///
/// # Errors
/// Invalid sizes, bounds or options, or constraints, for which [`augmented_lagrangian`](super::augmented_lagrangian()) exists.
pub fn lbfgs(problem: &mut dyn Problem, start: &[f64], options: &Options, watch: &mut Watcher) -> Result<Outcome, Error> {
    options.fit(problem, start)?;
    refuse_constraints(problem)?;
    solve(problem, start, options, |problem, x| {
        let value = problem.evaluate_start(&x)?;
        let mut merit = Cost(value);
        let mut descent = Descent::begin(problem, &mut merit, (x, value), options)?;
        let tolerance = options.stationarity * descent.history[0].stationarity;
        let reason = descent.run(problem, &mut merit, tolerance, watch);
        let reason = descent.or_unbounded(problem, &mut merit, (reason, tolerance));
        let (Point { x, value, .. }, history) = (descent.at, descent.history);
        // The problem is left with the motion of the best point.
        problem.evaluate(&x);
        Ok(Found { x, value, multipliers: Vec::new(), history, reason })
    })
}

/// # Errors
/// Constraints that are not free, by name.
fn refuse_constraints(problem: &dyn Problem) -> Result<(), Error> {
    const NAMED: usize = 3;
    let constraints = problem.constraints();
    let bounded: Vec<usize> = (0..constraints.len()).filter(|&j| constraints[j] != Interval::FREE).collect();
    if bounded.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = bounded.iter().take(NAMED).map(|&j| problem.constraint_name(j)).collect();
    let more = if bounded.len() > NAMED { ", …" } else { "" };
    let what = format!("the number of constraints that are not `Interval::FREE` ({}{more})", names.join(", "));
    let must_be = "0 for L-BFGS; use `augmented_lagrangian` for constraints or `levenberg_marquardt` for residuals";
    Err(Error::Parameter { what, value: bounded.len() as f64, must_be })
}

/// A minimisation of a merit function, with its stored pairs and its history.
pub(super) struct Descent<'o> {
    pub(super) at: Point,
    options: &'o Options,
    /// The first point.
    start: Vec<f64>,
    /// The magnitude of gradients, relative to which their squares do not overflow or underflow.
    unit: f64,
    /// Steps s, and changes y of the gradient in this unit.
    pairs: VecDeque<(Vec<f64>, Vec<f64>)>,
    pub(super) history: Vec<Iterate>,
}

impl<'o> Descent<'o> {
    /// Starts at the last evaluated point, with its value.
    ///
    /// # Errors
    /// A start without a gradient.
    pub(super) fn begin(
        problem: &mut Counted,
        merit: &mut dyn Merit,
        (x, value): (Vec<f64>, f64),
        options: &'o Options,
    ) -> Result<Self, Error> {
        let mut at = Point { value, gradient: vec![0.0; x.len()], x };
        merit.gradient(problem, &mut at.gradient)?;
        let (start, unit) = (at.x.clone(), magnitude(largest(&at.gradient)));
        let mut descent = Descent { start, at, options, unit, pairs: VecDeque::new(), history: Vec::new() };
        descent.note(problem, merit.cost(), 0.0);
        Ok(descent)
    }

    fn note(&mut self, problem: &mut Counted, value: f64, step: f64) {
        let stationarity = problem.stationarity(&self.at.x, &self.at.gradient);
        self.history.push(problem.iterate(value, stationarity, step));
    }

    /// Continues with another merit function: discards the pairs if `forget` is set, and updates value and gradient.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
    pub(super) fn renew(
        &mut self,
        problem: &mut Counted,
        merit: &mut dyn Merit,
        value: f64,
        forget: bool,
    ) -> Result<(), Error> {
        if forget {
            self.pairs.clear();
        }
        self.at.value = value;
        merit.gradient(problem, &mut self.at.gradient)
    }

    /// Moves to another point, with the last value of the merit function there.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
    pub(super) fn go(
        &mut self,
        problem: &mut Counted,
        merit: &mut dyn Merit,
        (x, value): (Vec<f64>, f64),
    ) -> Result<(), Error> {
        let step = largest_change(&x, &self.at.x);
        self.at.x = x;
        self.renew(problem, merit, value, true)?;
        self.note(problem, merit.cost(), step);
        Ok(())
    }

    pub(super) fn run(
        &mut self,
        problem: &mut Counted,
        merit: &mut dyn Merit,
        tolerance: f64,
        watch: &mut Watcher,
    ) -> Reason {
        loop {
            let last = self.history[self.history.len() - 1];
            let stationarity = problem.stationarity(&self.at.x, &self.at.gradient);
            if watch(&last, &self.at.x).is_break() {
                return Reason::Interrupted;
            }
            if self.options.target.is_some_and(|target| last.value <= target) && last.violation <= self.options.violation {
                return Reason::Target;
            }
            if stationarity <= tolerance || stationarity == 0.0 {
                return Reason::Stationary;
            }
            if self.history.len() > self.options.iterations {
                return Reason::Iterations;
            }
            let Some(next) = self.next(problem, merit) else {
                if problem.is_stopped() {
                    return Reason::Interrupted;
                }
                let is_least = !self.still_falls(stationarity) && self.is_flat(problem, merit);
                return if is_least { Reason::Stationary } else { Reason::NoLowerValue };
            };
            self.remember(&next);
            let step = largest_change(&next.x, &self.at.x);
            self.at = next;
            self.note(problem, merit.cost(), step);
        }
    }

    /// A lower point, if one is found.
    fn next(&mut self, problem: &mut Counted, merit: &mut dyn Merit) -> Option<Point> {
        let given = self.options.first_step;
        let mut found = self.step(problem, merit, given);
        if found.is_none() && !self.pairs.is_empty() && !problem.is_stopped() {
            // The stored pairs may have been misleading.
            self.pairs.clear();
            found = self.step(problem, merit, given);
        }
        if found.is_none() && given.is_some() && !problem.is_stopped() {
            // The given step may be lost to rounding or far too long; then lower values may exist nevertheless.
            found = self.step(problem, merit, None);
        }
        found
    }

    fn step(&self, problem: &mut Counted, merit: &mut dyn Merit, given: Option<f64>) -> Option<Point> {
        let direction = self.direction(problem);
        search(problem, merit, &self.at, &direction, self.first(&direction, given))
    }

    /// The length of the first trial step along a direction.
    fn first(&self, direction: &[f64], given: Option<f64>) -> f64 {
        match (self.pairs.is_empty(), given) {
            (false, _) => 1.0,
            (true, Some(length)) => length / largest(direction).max(f64::MIN_POSITIVE),
            // Half the distance to the minimum of a parabola whose minimum value is 0; if the value is zero or rounding error, the size of the
            // variables, or 1.
            (true, None) => {
                let (square, size) = (dot(direction, direction), largest(&self.at.x));
                let parabola = self.at.value.abs() / self.unit / square;
                let is_rounding = parabola * largest(direction) <= ROUNDING * size;
                let far = if size > 0.0 { size } else { 1.0 };
                if is_rounding { far / square.sqrt() } else { parabola }
            }
        }
    }

    /// −H g over the variables that are not held at a bound, by the two-loop recursion. Held variables enter no product: their gradient changes as
    /// others move, which would be mistaken for curvature along the steps.
    fn direction(&self, problem: &Counted) -> Vec<f64> {
        let Point { x, gradient, .. } = &self.at;
        let parts = x.iter().zip(gradient).zip(&problem.bounds);
        let held: Vec<bool> = parts.map(|((x, g), of)| of.holds(*x, *g).is_some()).collect();
        let is_any_held = held.contains(&true);
        let dot = |a: &[f64], b: &[f64]| if is_any_held { dot_of_free(a, b, &held) } else { dot(a, b) };
        let free = |d: &mut Vec<f64>| d.iter_mut().zip(&held).filter(|(_, held)| **held).for_each(|(d, _)| *d = 0.0);
        let mut d: Vec<f64> = gradient.iter().map(|g| -g / self.unit).collect();
        free(&mut d);
        // Each pair with 1/(sᵀy) over the free variables, unless no curvature is left there, and with its factor.
        let mut used = Vec::with_capacity(self.pairs.len());
        for (s, y) in self.pairs.iter().rev() {
            let curvature = dot(s, y);
            if is_any_held && !is_curved(curvature, dot(s, s), dot(y, y)) {
                continue;
            }
            let rho = 1.0 / curvature;
            let factor = rho * dot(s, &d);
            add(&mut d, -factor, y);
            used.push((s, y, rho, factor));
        }
        if let Some((s, y, ..)) = used.first() {
            let scale = dot(s, y) / dot(y, y);
            d.iter_mut().for_each(|d| *d *= scale);
        }
        for (s, y, rho, factor) in used.into_iter().rev() {
            let other = rho * dot(y, &d);
            add(&mut d, factor - other, s);
        }
        free(&mut d);
        d
    }

    /// Stores the pair of a step if the curvature along it is positive.
    fn remember(&mut self, next: &Point) {
        let s: Vec<f64> = next.x.iter().zip(&self.at.x).map(|(new, old)| new - old).collect();
        let y: Vec<f64> = next.gradient.iter().zip(&self.at.gradient).map(|(new, old)| (new - old) / self.unit).collect();
        if is_curved(dot(&s, &y), dot(&s, &s), dot(&y, &y)) {
            if self.pairs.len() == self.options.memory.max(1) {
                self.pairs.pop_front();
            }
            self.pairs.push_back((s, y));
        }
    }
}

/// True if sᵀy is positive beyond rounding, for given sᵀs and yᵀy.
fn is_curved(curvature: f64, of_s: f64, of_y: f64) -> bool {
    curvature > 1e-12 * of_y.sqrt() * of_s.sqrt()
}

fn dot_of_free(a: &[f64], b: &[f64], held: &[bool]) -> f64 {
    a.iter().zip(b).zip(held).filter(|(_, held)| !**held).map(|((a, b), _)| a * b).sum()
}

fn add(to: &mut [f64], factor: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, x)| *to += factor * x);
}
