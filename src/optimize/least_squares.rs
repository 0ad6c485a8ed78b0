//! Levenberg–Marquardt for ½‖r(x)‖² with bounds (damping: Nielsen 1999); with fewer residuals than variables, the steps have least norm.
//!
//! (AᵀA + μ D²) d = −Aᵀr, with the lengths D of the columns of the Jacobian A (Marquardt 1963), so that units of variables do not matter; or, with
//! fewer rows than columns, d = −Aᵀ (A Aᵀ + μ I)⁻¹ r.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::counted::{Counted, Found, solve};
use super::norm::norm;
use super::outcome::largest_change;
use super::{Fit, Interval, Iterate, Options, Problem, Reason, Watcher};
use crate::Error;

/// Differences of a residual below this fraction of its terms are rounding error.
const ROUNDING: f64 = 1e-14;
/// The method ends after this many iterations that lower the value by rounding error only.
const FEW: usize = 10;
/// A value above this multiple of its rounding error is significant.
const SEEN: f64 = 100.0;

/// Minimises ½‖r‖² within bounds. The residuals r are the constraints of the problem minus the nearest allowed value; f is not used.
///
/// [`Options::stationarity`] applies to derivatives relative to the largest norms of the columns ∂r/∂x_i so far, so that the units of the
/// variables do not matter.
///
/// If there are more residuals than variables, the errors that the grid causes are estimated at the end
/// ([`Problem::grid_errors`]), for motions by one simulation with twice as many steps; [`Fit::standard_errors`] includes them. If all residuals
/// are those of readings ([`Problem::is_reading`]), a sum of squares that a correct model would hardly have causes [`Warning::Misfit`](crate::Warning::Misfit).
///
/// # Errors
/// Invalid sizes, bounds or options, or a problem without residuals.
pub fn levenberg_marquardt(
    problem: &mut dyn Problem,
    start: &[f64],
    options: &Options,
    watch: &mut Watcher,
) -> Result<Fit, Error> {
    options.fit(problem, start)?;
    let rows = problem.constraints().iter().filter(|of| **of != Interval::FREE).count();
    if rows == 0 {
        let must_be = "at least 1 (residuals are constraints; use `lbfgs` or `interior_point` to minimise f)";
        return Err(Error::Parameter { what: "the number of residuals".into(), value: 0.0, must_be });
    }
    let (mut jacobian, mut grid_errors) = (DMatrix::zeros(rows, start.len()), None);
    let mut residuals = DVector::zeros(rows);
    let outcome = solve(problem, start, options, |problem, x| {
        let Descended { at, history, reason } = descend(problem, x, options, watch, ROUNDING)?;
        let (value, mut multipliers) = (half_square(&at.r), vec![0.0; problem.c.len()]);
        problem.asked().zip(&at.r).for_each(|(j, r)| multipliers[j] = *r);
        (jacobian, residuals) = (at.jacobian, at.r);
        // Without standard errors, the errors of the grid are not needed.
        if rows > start.len() && !problem.is_stopped() {
            grid_errors = problem.grid_errors();
        }
        Ok(Found { x: at.x, value, multipliers, history, reason })
    })?;
    let mut fit = Fit { outcome, jacobian, grid_errors };
    fit.outcome.warnings.extend(fit.warning(|i| problem.variable_name(i)));
    let is_free = |j: &usize| problem.constraints()[*j] == Interval::FREE;
    if (0..fit.outcome.constraints.len()).all(|j| is_free(&j) || problem.is_reading(j)) {
        fit.outcome.warnings.extend(fit.misfit(&residuals));
    }
    Ok(fit)
}

/// The end of a minimisation of ½‖r‖², its history, and the reason.
pub(super) struct Descended {
    pub(super) at: State,
    pub(super) history: Vec<Iterate>,
    pub(super) reason: Reason,
}

/// Minimises ½‖r‖² from x while `FEW` iterations lower it by more than the fraction `creep`. The problem is left at the end.
///
/// # Errors
/// A start without a value or a Jacobian, or with squares that overflow or underflow.
pub(super) fn descend(
    counted: &mut Counted,
    x: Vec<f64>,
    options: &Options,
    watch: &mut Watcher,
    creep: f64,
) -> Result<Descended, Error> {
    counted.evaluate_start(&x)?;
    let mut at = State::at(counted, x)?;
    at.check_smallness()?;
    let mut history = vec![at.iterate(counted, 0.0)];
    let mut lengths = at.lengths();
    let first = at.slope(counted, &lengths);
    let first_damping = 1e-3 * at.in_units(&lengths).row_iter().map(|row| row.norm_squared()).fold(0.0, f64::max);
    let mut damping = first_damping;
    let reason = loop {
        let last = history[history.len() - 1];
        if watch(&last, &at.x).is_break() {
            break Reason::Interrupted;
        }
        if options.target.is_some_and(|target| last.value <= target) {
            break Reason::Target;
        }
        if at.slope(counted, &lengths) <= options.stationarity * first {
            break Reason::Stationary;
        }
        // Decreases by rounding error, or creeping from one side of a bend to the other, could continue for ever.
        let few_ago = history.iter().rev().nth(FEW).map_or(f64::INFINITY, |before| before.value);
        if few_ago - last.value <= creep * last.value {
            let is_least = at.along_gradient(counted, &lengths) <= at.noise();
            break if is_least { Reason::Stationary } else { Reason::NoLowerValue };
        }
        if history.len() > options.iterations {
            break Reason::Iterations;
        }
        // Tries shorter and shorter steps until one lowers the value; `foreseen` is the predicted decrease of the first.
        let (mut growth, mut foreseen) = (2.0, None);
        // If the damping has grown, none of its steps may change the value noticeably; then the first damping is tried again.
        let mut is_last = damping <= first_damping;
        let next = loop {
            // If rounding prevents the factorisation, the damping is increased as well.
            if let Some(step) = at.step(counted, damping, &lengths) {
                let mut x: Vec<f64> = at.x.iter().zip(&step).map(|(x, d)| x + d).collect();
                counted.project(&mut x);
                let predicted = at.decrease(&x);
                foreseen.get_or_insert(predicted);
                if x == at.x && is_last {
                    break None;
                }
                if x == at.x {
                    (damping, growth, foreseen, is_last) = (first_damping, 2.0, None, true);
                    continue;
                }
                let value = if counted.evaluate(&x).is_finite() { half_square(&residuals(counted)) } else { f64::INFINITY };
                let gain = (last.value - value) / predicted;
                // A point without a Jacobian is rejected.
                let next = if value < last.value && gain > 1e-4 { State::at(counted, x).ok() } else { None };
                if next.is_some() {
                    damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
                    break next;
                }
            }
            damping = (damping * growth).max(f64::MIN_POSITIVE);
            growth *= 2.0;
            if counted.is_stopped() || !damping.is_finite() {
                break None;
            }
        };
        let Some(next) = next else {
            break match foreseen {
                _ if counted.is_stopped() => Reason::Interrupted,
                Some(decrease) if at.along_gradient(counted, &lengths).max(decrease) <= at.noise() => Reason::Stationary,
                _ => Reason::NoLowerValue,
            };
        };
        let length = largest_change(&next.x, &at.x);
        at = next;
        lengths.iter_mut().zip(at.lengths()).for_each(|(most, now)| *most = most.max(now));
        history.push(at.iterate(counted, length));
    };
    // The problem is left with the motion of the best point.
    counted.evaluate(&at.x);
    Ok(Descended { at, history, reason })
}

fn half_square(r: &DVector<f64>) -> f64 {
    0.5 * r.norm_squared()
}

fn residuals(problem: &Counted) -> DVector<f64> {
    let all = problem.asked().map(|j| problem.intervals[j].excess(problem.c[j])).collect::<Vec<f64>>();
    DVector::from_vec(all)
}

pub(super) struct State {
    pub(super) x: Vec<f64>,
    r: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
}

impl State {
    /// The state at the last evaluated point.
    ///
    /// # Errors
    /// A Jacobian that cannot be computed; sums of squares that overflow.
    fn at(problem: &mut Counted, x: Vec<f64>) -> Result<Self, Error> {
        let rows: Vec<usize> = problem.asked().collect();
        let (r, mut jacobian) = (residuals(problem), problem.jacobian(&rows)?);
        let descent = -jacobian.tr_mul(&r);
        for (k, &j) in rows.iter().enumerate().filter(|(k, _)| r[*k] == 0.0) {
            let (of, c) = (&problem.intervals[j], problem.c[j]);
            let room = if jacobian.row(k).tr_dot(&descent) > 0.0 { of.most - c } else { c - of.least };
            // Inside its interval a residual stays zero nearby, unless it soon leaves the interval along the descent direction.
            if of.least != of.most && room * room > ROUNDING * r.norm_squared() {
                jacobian.row_mut(k).fill(0.0);
            }
        }
        let state = State { x, r, jacobian };
        state.check_range(problem)?;
        Ok(state)
    }

    /// Error for sums of finite terms that are not finite: nothing can be compared with them.
    fn check_range(&self, problem: &Counted) -> Result<(), Error> {
        let value = half_square(&self.r);
        if !value.is_finite() {
            return Err(Error::Overflow { what: "½‖r‖² of the residuals".into(), value });
        }
        for (i, (column, g)) in self.jacobian.column_iter().zip(&self.gradient()).enumerate() {
            if let Some(value) = [column.norm(), *g].into_iter().find(|sum| !sum.is_finite()) {
                let what =
                    format!("a sum of derivatives of residuals with respect to `{}`", problem.problem.variable_name(i));
                return Err(Error::Overflow { what, value });
            }
        }
        Ok(())
    }

    /// Error for sums of squares at the start that underflow although their terms are not zero: every point would look like a minimum.
    fn check_smallness(&self) -> Result<(), Error> {
        let is_lost = |square: f64, terms: f64| square < f64::MIN_POSITIVE && terms > 0.0;
        let value = half_square(&self.r);
        if is_lost(value, self.r.amax()) {
            return Err(Error::Overflow { what: "½‖r‖² of the residuals".into(), value: 0.0 });
        }
        let value = self.in_units(&self.lengths()).norm_squared();
        if is_lost(value, self.jacobian.amax()) {
            return Err(Error::Overflow { what: "the sum of squares of all derivatives of residuals".into(), value: 0.0 });
        }
        Ok(())
    }

    fn gradient(&self) -> DVector<f64> {
        self.jacobian.tr_mul(&self.r)
    }

    /// The gradient with respect to variables in units of `lengths`; factors are scaled first if their products underflow.
    fn derivatives(&self, lengths: &[f64]) -> Vec<f64> {
        let of = |((g, column), length): ((&f64, DVectorView<f64>), &f64)| {
            let inverse = reciprocal(*length);
            if g.is_normal() { g * inverse } else { column.iter().zip(&self.r).map(|(a, r)| a * inverse * r).sum() }
        };
        self.gradient().iter().zip(self.jacobian.column_iter()).zip(lengths).map(of).collect()
    }

    fn iterate(&self, problem: &mut Counted, step: f64) -> Iterate {
        let stationarity = problem.stationarity(&self.x, self.gradient().as_slice());
        problem.iterate(half_square(&self.r), stationarity, step)
    }

    /// The lengths of the columns of the Jacobian.
    fn lengths(&self) -> Vec<f64> {
        self.jacobian.column_iter().map(|column| norm(column.as_slice())).collect()
    }

    /// The largest derivative with respect to a variable that no bound holds, in units of `lengths`, so that units of variables do not matter.
    fn slope(&self, problem: &Counted, lengths: &[f64]) -> f64 {
        problem.stationarity(&self.x, &self.derivatives(lengths))
    }

    /// True if the value may be rounding error.
    pub(super) fn is_rounding(&self) -> bool {
        half_square(&self.r) <= SEEN * self.noise()
    }

    /// Rounding error of the value, due to the residuals and the terms of their sums.
    fn noise(&self) -> f64 {
        let sizes = DVector::from_iterator(self.x.len(), self.x.iter().map(|x| x.abs()));
        let of_residuals = (self.jacobian.abs() * sizes + self.r.abs()) * ROUNDING;
        self.r.abs().dot(&of_residuals) + half_square(&of_residuals)
    }

    /// Decrease of the linear model at x.
    fn decrease(&self, x: &[f64]) -> f64 {
        let step = DVector::from_iterator(x.len(), x.iter().zip(&self.x).map(|(new, old)| new - old));
        let change = &self.jacobian * step;
        -(change.dot(&self.r) + half_square(&change))
    }

    /// Decrease of the linear model at its minimum along the gradient of the variables that no bound holds, in units of `lengths`.
    fn along_gradient(&self, problem: &Counted, lengths: &[f64]) -> f64 {
        let a = self.free(problem, scaled(&self.jacobian, lengths), lengths);
        let gradient = a.tr_mul(&self.r);
        let square = gradient.norm_squared();
        if square > 0.0 { 0.5 * square * square / (a * gradient).norm_squared() } else { 0.0 }
    }

    /// The Jacobian in units of `lengths`; unscaled if there are fewer residuals than variables, because the shortest step is then taken.
    fn in_units(&self, lengths: &[f64]) -> DMatrix<f64> {
        let is_short = self.jacobian.nrows() < self.jacobian.ncols();
        if is_short { self.jacobian.clone() } else { scaled(&self.jacobian, lengths) }
    }

    /// A Jacobian with zero columns for variables that bounds hold.
    fn free(&self, problem: &Counted, mut a: DMatrix<f64>, lengths: &[f64]) -> DMatrix<f64> {
        let gradient = self.derivatives(lengths);
        for (i, of) in problem.bounds.iter().enumerate() {
            if of.holds(self.x[i], gradient[i]).is_some() {
                a.column_mut(i).fill(0.0);
            }
        }
        a
    }

    /// The step, without variables that bounds hold; `None` if its equations cannot be solved.
    fn step(&self, problem: &Counted, damping: f64, lengths: &[f64]) -> Option<DVector<f64>> {
        let a = self.free(problem, self.in_units(lengths), lengths);
        let (m, n) = a.shape();
        let damping = damping.max(f64::MIN_POSITIVE);
        if m < n {
            let square = &a * a.transpose() + DMatrix::from_diagonal_element(m, m, damping);
            return square.cholesky().map(|factors| -(a.tr_mul(&factors.solve(&self.r))));
        }
        // Orthogonal factors, with large rows first: AᵀA would lose rows in small units beside rows in large units.
        let mut order = Vec::from_iter(0..m);
        order.sort_by(|&i, &j| a.row(j).amax().total_cmp(&a.row(i).amax()));
        let mut stacked = a.select_rows(&order).insert_rows(m, n, 0.0);
        stacked.view_mut((m, 0), (n, n)).fill_diagonal(damping.sqrt());
        let mut r = self.r.select_rows(&order).insert_rows(m, n, 0.0);
        let factors = stacked.qr();
        factors.q_tr_mul(&mut r);
        let step = factors.r().solve_upper_triangular(&r.rows(0, n))?;
        Some(DVector::from_iterator(n, step.iter().zip(lengths).map(|(d, of)| -d * reciprocal(*of))))
    }
}

/// The columns of a Jacobian divided by `lengths`.
fn scaled(jacobian: &DMatrix<f64>, lengths: &[f64]) -> DMatrix<f64> {
    let mut scaled = jacobian.clone();
    scaled.column_iter_mut().zip(lengths).for_each(|(mut column, length)| column *= reciprocal(*length));
    scaled
}

/// 1/length, or 0 if length is zero or its inverse overflows: variables without effect do not move.
fn reciprocal(length: f64) -> f64 {
    if length >= f64::MIN_POSITIVE { length.recip() } else { 0.0 }
}
