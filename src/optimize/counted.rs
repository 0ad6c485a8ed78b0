//! [`Counted`]: a problem with counts of its evaluations, and the result of a method.

mod violated;

use nalgebra::{DMatrix, DVector};

use super::outcome::{Iterate, Options, Outcome, Reason};
use super::problem::{Interval, largest_violation};
use super::{Problem, Violation};
use crate::motion::check_size;
use crate::{Error, Warning};

/// A problem with counts of its evaluations.
pub(super) struct Counted<'p> {
    pub(super) problem: &'p mut dyn Problem,
    pub(super) c: Vec<f64>,
    pub(super) intervals: Vec<Interval>,
    pub(super) bounds: Vec<Interval>,
    pub(super) evaluations: usize,
    pub(super) gradients: usize,
    pub(super) products: usize,
    /// Number of iterations of feasibility phases, of which the history contains only the end.
    pub(super) apart: usize,
    /// The last evaluated point.
    last: Vec<f64>,
    /// c at the last iterate.
    c_of_iterate: Vec<f64>,
    /// The error of a simulation that was stopped by its callback; the problem is then not evaluated any more.
    pub(super) stopped: Option<Error>,
    /// Warnings at the last iterate.
    warnings: Vec<Warning>,
    halved: usize,
    pub(super) failures: usize,
    pub(super) first_failure: Option<Error>,
}

/// The result of a method.
pub(super) struct Found {
    pub(super) x: Vec<f64>,
    pub(super) value: f64,
    pub(super) multipliers: Vec<f64>,
    pub(super) history: Vec<Iterate>,
    pub(super) reason: Reason,
}

/// The outcome of a method from a start, which is first moved into its bounds. An error at the start becomes a reason of the outcome.
///
/// # Errors
/// As [`Counted::new`]; a problem that does not implement what the method needs, or returns vectors of wrong length.
pub(super) fn solve(
    problem: &mut dyn Problem,
    start: &[f64],
    options: &Options,
    method: impl FnOnce(&mut Counted, Vec<f64>) -> Result<Found, Error>,
) -> Result<Outcome, Error> {
    let (mut counted, x) = Counted::new(problem, start, options)?;
    match method(&mut counted, x) {
        Err(error @ (Error::NoSecondDerivatives { .. } | Error::Size { .. })) => Err(error),
        found => Ok(counted.outcome(found, options.violation)),
    }
}

impl<'p> Counted<'p> {
    /// A problem with counts of zero, and the start moved into its bounds.
    ///
    /// # Errors
    /// Invalid sizes or options, a start that is not finite, or bounds that exclude every value.
    pub(super) fn new(problem: &'p mut dyn Problem, start: &[f64], options: &Options) -> Result<(Self, Vec<f64>), Error> {
        options.fit(problem, start)?;
        let (intervals, bounds) = (problem.constraints(), problem.bounds());
        let c = vec![0.0; intervals.len()];
        let counted = Counted {
            problem,
            c_of_iterate: c.clone(),
            stopped: None,
            c,
            intervals,
            bounds,
            evaluations: 0,
            gradients: 0,
            products: 0,
            apart: 0,
            last: Vec::new(),
            warnings: Vec::new(),
            halved: 0,
            failures: 0,
            first_failure: None,
        };
        let mut x = start.to_vec();
        counted.project(&mut x);
        Ok((counted, x))
    }

    /// f(x), infinite if it has no value. At an x that is not finite the problem is not evaluated.
    pub(super) fn evaluate(&mut self, x: &[f64]) -> f64 {
        if let Err(error) = self.check_range(x, "") {
            self.fail(error);
            return f64::INFINITY;
        }
        self.evaluations += 1;
        self.last.clear();
        self.last.extend_from_slice(x);
        let error = match self.problem.evaluate(x, &mut self.c) {
            Ok(f) if f.is_finite() && self.c.iter().all(|c| c.is_finite()) => {
                self.halved += usize::from(self.problem.is_halved());
                return f;
            }
            Ok(f) => match self.c.iter().position(|c| !c.is_finite()).filter(|_| f.is_finite()) {
                Some(j) => {
                    Error::NotFinite { what: format!("the value of {}", self.problem.constraint_name(j)), value: self.c[j] }
                }
                None => Error::NotFinite { what: "the value of the cost".into(), value: f },
            },
            Err(error) => error,
        };
        self.fail(error);
        f64::INFINITY
    }

    fn fail(&mut self, error: Error) {
        self.failures += 1;
        if let Error::Interrupted { .. } = error {
            self.stopped.get_or_insert(error.clone());
        }
        self.first_failure.get_or_insert(error);
    }

    /// Returns a result, and records its error.
    fn noting<T>(&mut self, found: Result<T, Error>) -> Result<T, Error> {
        if let Err(error) = &found {
            self.fail(error.clone());
        }
        found
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    /// Evaluates this point, unless it was evaluated last; true if it has a value.
    pub(super) fn ensure(&mut self, x: &[f64]) -> bool {
        self.last == x || self.evaluate(x).is_finite()
    }

    /// f at the start.
    ///
    /// # Errors
    /// The error of the evaluation.
    pub(super) fn evaluate_start(&mut self, x: &[f64]) -> Result<f64, Error> {
        let earlier = self.first_failure.take();
        let f = self.evaluate(x);
        std::mem::replace(&mut self.first_failure, earlier).map_or(Ok(f), Err)
    }

    pub(super) fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.gradients += 1;
        let found =
            self.problem.gradient(f, c, gradient).and_then(|()| self.check_range(gradient, "the gradient component for "));
        self.noting(found)
    }

    /// Error for the first number that is not finite, with the name of its variable.
    fn check_range(&self, numbers: &[f64], what: &str) -> Result<(), Error> {
        match numbers.iter().position(|x| !x.is_finite()) {
            Some(i) => {
                let what = format!("{what}`{}`", self.problem.variable_name(i));
                Err(Error::NotFinite { what, value: numbers[i] })
            }
            None => Ok(()),
        }
    }

    /// The Hessian of the function whose gradient was computed last, times a direction.
    pub(super) fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.products += 1;
        let found = self.check_range(direction, "the component of the direction for ").and_then(|()| {
            self.problem.product(direction, product)?;
            self.check_range(product, "the component of the Hessian product for ")
        });
        self.noting(found)
    }

    /// The given rows of ∂c/∂x at the last evaluated point: by columns if this is less work and the problem supports it, otherwise row by row.
    pub(super) fn jacobian(&mut self, rows: &[usize]) -> Result<DMatrix<f64>, Error> {
        let found = self.find_jacobian(rows);
        self.noting(found)
    }

    fn find_jacobian(&mut self, rows: &[usize]) -> Result<DMatrix<f64>, Error> {
        let (m, n) = (self.c.len(), self.bounds.len());
        let [by_rows, by_columns] = self.problem.jacobian_work(rows);
        if by_columns < by_rows {
            let mut all = DMatrix::zeros(m, n);
            if self.fill_columns(&mut all)? {
                let jacobian = all.select_rows(rows);
                self.check_jacobian(&jacobian)?;
                return Ok(jacobian);
            }
        }
        let mut jacobian = DMatrix::zeros(rows.len(), n);
        self.gradients += rows.len();
        self.problem.jacobian(rows, &mut jacobian)?;
        self.check_jacobian(&jacobian)?;
        Ok(jacobian)
    }

    fn check_jacobian(&self, jacobian: &DMatrix<f64>) -> Result<(), Error> {
        let bad = jacobian.iter().position(|x| !x.is_finite());
        bad.map_or(Ok(()), |at| {
            let what = format!("the derivative with respect to `{}`", self.problem.variable_name(at / jacobian.nrows()));
            Err(Error::NotFinite { what, value: jacobian[at] })
        })
    }

    /// Returns false if the problem does not support derivatives along a direction.
    fn fill_columns(&mut self, jacobian: &mut DMatrix<f64>) -> Result<bool, Error> {
        let mut direction = vec![0.0; jacobian.ncols()];
        for (i, mut column) in jacobian.column_iter_mut().enumerate() {
            direction[i] = 1.0;
            match self.problem.push_forward(&direction, column.as_mut_slice()) {
                Err(Error::NoSecondDerivatives { .. }) => return Ok(false),
                done => done?,
            }
            direction[i] = 0.0;
            self.gradients += 1;
        }
        Ok(true)
    }

    /// The errors of the residuals that are not free, caused by a discretisation at the last evaluated point; `None` if they are not known.
    pub(super) fn grid_errors(&mut self) -> Option<DVector<f64>> {
        let found = self.problem.grid_errors().and_then(|errors| {
            let count = errors.as_ref().map_or(self.c.len(), Vec::len);
            check_size("the grid errors of constraints", self.c.len(), count).map(|()| errors)
        });
        let errors = self.noting(found).ok().flatten()?;
        Some(DVector::from_iterator(self.asked().count(), self.asked().map(|j| errors[j])))
    }

    /// The constraints that are not free.
    pub(super) fn asked(&self) -> impl Iterator<Item = usize> {
        (0..self.c.len()).filter(|&j| self.intervals[j] != Interval::FREE)
    }

    /// The signed violations of all constraints at the last evaluated point.
    pub(super) fn excess(&self) -> Vec<f64> {
        self.c.iter().zip(&self.intervals).map(|(c, of)| of.excess(*c)).collect()
    }

    pub(super) fn violation(&self) -> f64 {
        largest_violation(&self.intervals, &self.c)
    }

    /// The last evaluated point as an iterate.
    pub(super) fn iterate(&mut self, value: f64, stationarity: f64, step: f64) -> Iterate {
        self.c_of_iterate.copy_from_slice(&self.c);
        self.warnings = self.problem.warnings();
        Iterate { value, violation: self.violation(), stationarity, step, evaluations: self.evaluations }
    }

    /// Reason why a method ended. An error after the start becomes a reason, so that the results so far are kept.
    ///
    /// # Errors
    /// The error of a start.
    pub(super) fn reason(&mut self, found: Result<Reason, Error>, iterates: usize) -> Result<Reason, Error> {
        match found {
            _ if self.is_stopped() => Ok(Reason::Interrupted),
            Err(error) if iterates > 1 => {
                self.first_failure = Some(error);
                Ok(Reason::NoDerivative)
            }
            other => other,
        }
    }

    /// The nearest point within the bounds.
    pub(super) fn project(&self, x: &mut [f64]) {
        x.iter_mut().zip(&self.bounds).for_each(|(x, of)| *x = of.nearest(*x));
    }

    /// The largest component of the gradient over the variables that are not held at a bound.
    pub(super) fn stationarity(&self, x: &[f64], g: &[f64]) -> f64 {
        let free = x.iter().zip(g).zip(&self.bounds).filter(|((x, g), of)| of.holds(**x, **g).is_none());
        free.fold(0.0, |most: f64, ((_, g), _)| most.max(g.abs()))
    }

    /// The outcome at the last iterate, or at a start without a value or derivatives, with the tolerance of violations.
    fn outcome(mut self, found: Result<Found, Error>, allowed: f64) -> Outcome {
        self.c.copy_from_slice(&self.c_of_iterate);
        let mut violation = self.violation();
        let found = found.unwrap_or_else(|error| {
            let (none, evaluations) = (f64::INFINITY, self.evaluations);
            self.first_failure = Some(error);
            self.c.fill(f64::NAN);
            violation = none;
            let start = Iterate { value: none, violation: none, stationarity: none, step: 0.0, evaluations };
            let reason = if self.is_stopped() { Reason::Interrupted } else { Reason::NoStart };
            Found {
                x: std::mem::take(&mut self.last),
                value: none,
                multipliers: vec![0.0; self.c.len()],
                history: vec![start],
                reason,
            }
        });
        let Found { x, value, multipliers, history, reason } = found;
        Outcome {
            x,
            value,
            violated: Violation::all(self.problem, &self.c, reason.named_above(allowed)),
            constraints: self.c,
            violation,
            multipliers,
            reason,
            iterations: history.len() - 1 + self.apart,
            evaluations: self.evaluations,
            gradients: self.gradients,
            products: self.products,
            history,
            warnings: self.warnings,
            halved: self.halved,
            failures: self.failures,
            first_failure: self.first_failure,
        }
    }
}
