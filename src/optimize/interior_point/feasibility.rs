//! Feasibility phase: the same method minimises ½ Σ excess² if steps that also take f into account do not reduce the violations.

use nalgebra::{DMatrix, DVector};

use super::super::counted::Counted;
use super::super::{Interval, Options, Outcome, Problem, Reason, silent};
use super::interior_point;
use super::saddle::escape;
use crate::Error;

/// Largest number of iterations of a feasibility phase.
const ITERATIONS: usize = 100;
/// ½ Σ excess² is minimal if a restart at the end changes it by less than this fraction, or, if no iterations are left, if the last `FEW` of them do.
/// Merely slow convergence proves nothing.
const FLAT: f64 = 1e-5;
const FEW: usize = 10;
/// Factor of the stationarity tolerance at a restart: the start is moved away from its bounds again, and would lead to the same end.
const FINER: f64 = 1e-3;

/// Reduces the violations from x, regardless of f. Returns the end, and whether the violation has a local minimum there that is not zero.
pub(super) fn approach(problem: &mut Counted, x: &[f64], options: &Options) -> Result<(Vec<f64>, bool), Error> {
    let target = Some(0.5 * options.violation.powi(2));
    let mut options = Options { iterations: ITERATIONS.min(options.iterations), target, stationarity: 1e-7, ..*options };
    let (mut end, mut before) = (x.to_vec(), f64::INFINITY);
    loop {
        // A trait object: the method calls itself, and a new type for every level of recursion could not be compiled.
        let excess: &mut dyn Problem = &mut Excess { of: problem, jacobian: None, factor: 0.0 };
        let Outcome { x: next, history, reason, first_failure, .. } = interior_point(excess, &end, &options, &mut silent)?;
        if let (Reason::NoStart, Some(error)) = (reason, first_failure) {
            return Err(error);
        }
        end = next;
        problem.apart += history.len();
        options.iterations = options.iterations.saturating_sub(history.len());
        let last = history[history.len() - 1].value;
        if problem.is_stopped() {
            return Ok((end, false));
        }
        let is_out = reason == Reason::Iterations;
        let few_ago = history.len().checked_sub(FEW + 1).map_or(f64::INFINITY, |i| history[i].value);
        let earlier = if is_out { few_ago } else { before };
        let is_least = reason != Reason::Target && earlier - last <= FLAT * last;
        if is_least && !is_out {
            let excess: &mut dyn Problem = &mut Excess { of: problem, jacobian: None, factor: 0.0 };
            if let Some(lower) = escape(excess, &end)? {
                (end, before) = (lower, f64::INFINITY);
                continue;
            }
        }
        if is_least || is_out || reason == Reason::Target {
            return Ok((end, is_least));
        }
        before = last;
        options.stationarity *= FINER;
    }
}

/// ½ Σ excess² of the constraints of a problem.
struct Excess<'c, 'p> {
    of: &'c mut Counted<'p>,
    /// The Jacobian of the violated constraints.
    jacobian: Option<DMatrix<f64>>,
    /// The factor of the last gradient.
    factor: f64,
}

impl Problem for Excess<'_, '_> {
    fn variables(&self) -> usize {
        self.of.bounds.len()
    }

    fn variable_name(&self, i: usize) -> String {
        self.of.problem.variable_name(i)
    }

    fn bounds(&self) -> Vec<Interval> {
        self.of.bounds.clone()
    }

    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        self.jacobian = None;
        if !self.of.evaluate(x).is_finite() {
            return self.of.stopped.clone().map_or(Ok(f64::INFINITY), Err);
        }
        Ok(0.5 * self.of.excess().iter().map(|x| x * x).sum::<f64>())
    }

    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let excess = self.of.excess();
        if self.jacobian.is_none() {
            let violated: Vec<usize> = (0..excess.len()).filter(|&j| excess[j] != 0.0).collect();
            self.jacobian = Some(self.of.jacobian(&violated)?);
        }
        self.factor = f;
        let weights: Vec<f64> = excess.iter().map(|x| f * x).collect();
        self.of.gradient(0.0, &weights, gradient)
    }

    /// Σ excess ∇²c + JᵀJ.
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.of.product(direction, product)?;
        if let Some(jacobian) = &self.jacobian {
            let both = jacobian.tr_mul(&(jacobian * DVector::from_column_slice(direction)));
            product.iter_mut().zip(&both).for_each(|(to, x)| *to += self.factor * x);
        }
        Ok(())
    }
}
