//! Sequential quadratic programming: damped BFGS, an ℓ₁ merit function, second-order correction (Nocedal and Wright, chapter 18).
//!
//! Each step d is that of min gᵀd + ½ dᵀBd with c + A d and x + d within their bounds ([`quadratic`](super::quadratic)).

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};

use super::outcome::Counted;
use super::problem::Interval;
use super::quadratic::{Quadratic, Solution};
use super::{Iterate, Options, Outcome, Problem, Reason};
use crate::Error;

/// Sufficient decrease of the merit function.
const DECREASE: f64 = 1e-4;
/// The least curvature of an update, as a share of what was there.
const DAMPING: f64 = 0.2;
const SHORTER: f64 = 0.3;
const MOST_TRIALS: usize = 20;
/// Differences of the merit function below this share are rounding.
const ROUNDING: f64 = 1e-15;

/// Minimises f(x) subject to constraints and bounds; the constraints should be few, their Jacobian is a backward sweep for each.
///
/// # Errors
/// As [`lbfgs`](super::lbfgs()).
pub fn sqp<P: Problem + ?Sized>(
    problem: &mut P,
    start: &[f64],
    options: &Options,
    watch: &mut dyn FnMut(&Iterate) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let (mut counted, x) = Counted::new(problem, start)?;
    let value = counted.evaluate_start(&x)?;
    let mut at = Linearisation::at(&mut counted, x, value)?;
    let mut hessian = Hessian::new(&at);
    let mut w = DVector::zeros(counted.c.len());
    let (bounds, intervals) = (counted.bounds.clone(), counted.intervals.clone());
    let is_bounded = bounds.iter().chain(&intervals).any(|of| of.least != of.most && *of != Interval::FREE);
    let (mut penalty, mut radius): (f64, f64) = (0.0, f64::INFINITY);
    let mut history = vec![at.iterate(&counted, &w, 0.0)];
    let mut failed = false;
    let reason = loop {
        let last = history[history.len() - 1];
        if watch(&last).is_break() {
            break Reason::Asked;
        }
        let feasible = last.violation <= options.violation;
        if feasible && options.target.is_some_and(|target| last.value <= target) {
            break Reason::Target;
        }
        // Multipliers are known after the first step.
        if feasible && history.len() > 1 && last.stationarity <= options.stationarity * at.gradient_scale(&w) {
            break Reason::Stationary;
        }
        if history.len() > options.iterations {
            break Reason::Iterations;
        }
        let quadratic = Quadratic { b: &hessian.b, at: &at, bounds: &bounds, intervals: &intervals };
        let mut solution = quadratic.solve();
        let mut found = at.search(&mut counted, &solution, &mut penalty, &mut radius)?;
        if found.is_none() && is_bounded {
            solution = quadratic.solve_surely();
            found = at.search(&mut counted, &solution, &mut penalty, &mut radius)?;
        }
        let Some((x, value)) = found else {
            // What was learnt of the curvature may have misled it: once more without.
            if failed || hessian.is_guess {
                let hopeless = last.violation > options.violation;
                break if hopeless { Reason::Infeasible } else { Reason::NoLowerValue };
            }
            failed = true;
            hessian = Hessian::new(&at);
            radius = f64::INFINITY;
            continue;
        };
        let is_null =
            value >= at.value && x.iter().zip(&at.x).all(|(new, old)| (new - old).abs() <= 1e-15 * old.abs().max(1.0));
        if is_null && failed {
            break Reason::NoLowerValue;
        }
        failed = is_null;
        let next = Linearisation::at(&mut counted, x, value)?;
        w = solution.multipliers;
        hessian.update(&at, &next, &w);
        let length = (&next.x - &at.x).amax();
        at = next;
        history.push(at.iterate(&counted, &w, length));
    };
    let (x, value) = (at.x.as_slice().to_vec(), at.value);
    // What the problem keeps is the motion of the answer.
    counted.evaluate(&x);
    Ok(counted.outcome(x, value, w.as_slice().to_vec(), history, reason))
}

/// A point with f, c and their derivatives.
pub(super) struct Linearisation {
    pub(super) x: DVector<f64>,
    pub(super) value: f64,
    pub(super) gradient: DVector<f64>,
    pub(super) c: DVector<f64>,
    /// ∂c/∂x.
    pub(super) jacobian: DMatrix<f64>,
}

impl Linearisation {
    /// At the point that was evaluated last.
    fn at<P: Problem + ?Sized>(problem: &mut Counted<P>, x: Vec<f64>, value: f64) -> Result<Self, Error> {
        let (c, mut gradient) = (DVector::from_column_slice(&problem.c), DVector::zeros(x.len()));
        problem.gradient(1.0, &vec![0.0; c.len()], gradient.as_mut_slice())?;
        Ok(Linearisation { x: DVector::from_vec(x), value, gradient, c, jacobian: problem.jacobian()? })
    }

    /// ∇f + Aᵀw.
    fn lagrangian(&self, w: &DVector<f64>) -> DVector<f64> {
        &self.gradient + self.jacobian.tr_mul(w)
    }

    /// What the gradient of the Lagrangian is small against.
    fn gradient_scale(&self, w: &DVector<f64>) -> f64 {
        let terms = self.jacobian.row_iter().zip(w.iter()).map(|(row, w)| row.amax() * w.abs());
        terms.fold(self.gradient.amax(), f64::max)
    }

    fn iterate<P: Problem + ?Sized>(&self, problem: &Counted<P>, w: &DVector<f64>, step: f64) -> Iterate {
        Iterate {
            value: self.value,
            violation: problem.violation(),
            stationarity: problem.stationarity(self.x.as_slice(), self.lagrangian(w).as_slice()),
            step,
            evaluations: problem.evaluations,
        }
    }

    /// A point with a lower value of f + ν Σ |violation of c|, evaluated; none if there is none.
    ///
    /// The step is split into the least change that takes constraints to what they must be, which is kept, and the rest, which is shortened
    /// (Byrd and Omojokun), unless variables have bounds. After each trial what constraints bent away meanwhile is taken back. `radius` is the length of the rest that went well last.
    fn search<P: Problem + ?Sized>(
        &self,
        problem: &mut Counted<P>,
        Solution { step, multipliers }: &Solution,
        penalty: &mut f64,
        radius: &mut f64,
    ) -> Result<Option<(Vec<f64>, f64)>, Error> {
        let largest = multipliers.amax();
        if *penalty < 1.1 * largest || *penalty > 100.0 * largest {
            *penalty = 1.5 * largest;
        }
        let sum = |problem: &Counted<P>, c: &[f64]| -> f64 {
            c.iter().zip(&problem.intervals).map(|(c, of)| of.violation(*c)).sum()
        };
        let violation = sum(problem, self.c.as_slice());
        let normal = self.least_change(problem, self.x.as_slice(), self.c.as_slice());
        let tangential = step - &normal;
        let length = tangential.amax();
        // A point between x and x + d keeps the bounds; one beside it may not.
        let meets = problem.bounds.iter().any(|of| *of != Interval::FREE);
        let is_shortened = length > *radius && !meets;
        let (mut alpha, mut beta) = (if is_shortened { *radius / length } else { 1.0 }, 1.0);
        for trial in 0..MOST_TRIALS {
            let part = &normal * beta + &tangential * alpha;
            let mut x: Vec<f64> = self.x.iter().zip(&part).map(|(x, d)| x + d).collect();
            problem.project(&mut x);
            if x == self.x.as_slice() {
                return Ok(None);
            }
            let ahead = &self.c + &self.jacobian * &part;
            let (closer, rise) = (violation - sum(problem, ahead.as_slice()), self.gradient.dot(&part));
            // What is gained in constraints outweighs what it costs.
            if !meets && closer > 0.0 && rise > 0.5 * *penalty * closer {
                *penalty = 2.5 * rise / closer;
            }
            let here = self.value + *penalty * violation;
            let enough = here + DECREASE * (rise - *penalty * closer).min(0.0) + ROUNDING * here.abs();
            let value = problem.evaluate(&x);
            if value.is_finite() {
                let merit = value + *penalty * sum(problem, &problem.c);
                // Where constraints hold well the first point will do.
                let is_close = sum(problem, &problem.c) <= 1e-3 * violation;
                let good = merit <= enough;
                if good && (is_close || meets) {
                    *radius = widened(alpha, length);
                    return Ok(Some((x, value)));
                }
                if meets && trial > 0 {
                    alpha *= SHORTER;
                    beta = alpha;
                    continue;
                }
                let back = self.least_change(problem, &x, &problem.c);
                let mut corrected: Vec<f64> = x.iter().zip(&back).map(|(x, d)| x + d).collect();
                problem.project(&mut corrected);
                let corrected_value = problem.evaluate(&corrected);
                let corrected_merit = corrected_value + *penalty * sum(problem, &problem.c);
                if corrected_merit <= enough && corrected_merit <= merit {
                    *radius = widened(alpha, length);
                    return Ok(Some((corrected, corrected_value)));
                }
                if good {
                    *radius = widened(alpha, length);
                    problem.evaluate(&x);
                    return Ok(Some((x, value)));
                }
            }
            alpha *= SHORTER;
            beta = if meets {
                alpha
            } else if trial < 2 {
                1.0
            } else {
                beta * SHORTER
            };
        }
        Ok(None)
    }

    /// The least change of x that takes values of c to what they must be, to first order: −Aᵀ (A Aᵀ)⁻¹ (c − P(c)).
    fn least_change<P: Problem + ?Sized>(&self, problem: &Counted<P>, x: &[f64], c: &[f64]) -> DVector<f64> {
        let off = DVector::from_iterator(c.len(), c.iter().zip(&problem.intervals).map(|(c, of)| of.excess(*c)));
        let mut a = self.jacobian.clone();
        for (i, of) in problem.bounds.iter().enumerate() {
            if x[i] <= of.least || x[i] >= of.most {
                a.column_mut(i).fill(0.0);
            }
        }
        for (j, of) in problem.intervals.iter().enumerate() {
            if of.least != of.most && off[j] == 0.0 {
                a.row_mut(j).fill(0.0);
            }
        }
        let mut square = &a * a.transpose();
        let most = square.diagonal().amax();
        // What no variable can change stays.
        (0..square.nrows()).for_each(|j| square[(j, j)] += if square[(j, j)] > 0.0 { 1e-12 * most } else { 1.0 });
        match square.cholesky() {
            Some(factors) => -a.tr_mul(&factors.solve(&off)),
            None => DVector::zeros(x.len()),
        }
    }
}

/// How long the next step may be after one of this share of a length.
fn widened(alpha: f64, length: f64) -> f64 {
    if alpha == 1.0 { 4.0 * length.max(1e-6) } else { 2.0 * alpha * length }
}

/// B.
struct Hessian {
    b: DMatrix<f64>,
    /// Whether it is still a guess of its size.
    is_guess: bool,
}

impl Hessian {
    fn new(at: &Linearisation) -> Self {
        let n = at.x.len();
        // So that a step along the gradient lowers f by half of it, if that is a size at all.
        let (square, value) = (at.gradient.norm_squared(), at.value.abs());
        let size = if square > 0.0 && value > 0.0 { square / value } else { 1.0 };
        Hessian { b: DMatrix::identity(n, n) * size, is_guess: true }
    }

    /// Powell's damped update by the change of ∇f + Aᵀw.
    fn update(&mut self, from: &Linearisation, to: &Linearisation, w: &DVector<f64>) {
        let s = &to.x - &from.x;
        let y = to.lagrangian(w) - from.lagrangian(w);
        let (sy, ss) = (s.dot(&y), s.norm_squared());
        if ss == 0.0 || !y.norm_squared().is_finite() {
            return;
        }
        if self.is_guess {
            // The curvature of f, if it has one: what constraints add to it acts on few directions, which updates learn soon.
            let of_cost = s.dot(&(&to.gradient - &from.gradient)) / ss;
            let size = if of_cost > 1e-12 * to.gradient.norm() / ss.sqrt() {
                of_cost
            } else if sy > 1e-10 * s.norm() * y.norm() {
                y.norm_squared() / sy
            } else {
                y.norm() / ss.sqrt()
            };
            if size > 0.0 {
                self.b = DMatrix::identity(s.len(), s.len()) * size;
                self.is_guess = false;
            }
        }
        let bs = &self.b * &s;
        let sbs = s.dot(&bs);
        let theta = if sy >= DAMPING * sbs { 1.0 } else { (1.0 - DAMPING) * sbs / (sbs - sy) };
        let r = &y * theta + &bs * (1.0 - theta);
        self.b.ger(-1.0 / sbs, &bs, &bs, 1.0);
        self.b.ger(1.0 / s.dot(&r), &r, &r, 1.0);
    }
}
