//! A quadratic programme with few constraints: the primal–dual active set method (Hintermüller, Ito and Kunisch 2002).
//!
//! min gᵀd + ½ dᵀBd with x + d and c + A d within their bounds. Where a set of bounds is taken for active, it is a linear system; the solution says which
//! bounds are active instead, until nothing changes. Where that goes round in circles, `splitting` says where to begin.

use nalgebra::{DMatrix, DVector};

use super::problem::Interval;
use super::splitting;
use super::sqp::Linearisation;

const MOST_ROUNDS: usize = 30;

pub(super) struct Quadratic<'a> {
    /// B, positive definite.
    pub(super) b: &'a DMatrix<f64>,
    pub(super) at: &'a Linearisation,
    pub(super) bounds: &'a [Interval],
    pub(super) intervals: &'a [Interval],
}

pub(super) struct Solution {
    pub(super) step: DVector<f64>,
    /// w of the constraints.
    pub(super) multipliers: DVector<f64>,
}

/// The value at which a variable or a constraint is held, if it is.
pub(super) type Held = Vec<Option<f64>>;

impl Quadratic<'_> {
    pub(super) fn solve(&self) -> Solution {
        let Linearisation { x, gradient, c, .. } = self.at;
        let variables = (0..x.len()).map(|i| self.bounds[i].holds(x[i], gradient[i])).collect();
        let constraints = (0..c.len()).map(|j| beyond(&self.intervals[j], c[j])).collect();
        let (solution, _) = self.settle(variables, constraints);
        self.within(solution)
    }

    /// The same where that has gone round in circles, and led nowhere.
    pub(super) fn solve_surely(&self) -> Solution {
        let none = || Solution { step: DVector::zeros(self.at.x.len()), multipliers: DVector::zeros(self.at.c.len()) };
        let Some((rough, variables, constraints)) = splitting::solve(self) else { return none() };
        let (solution, is_settled) = self.settle(variables, constraints);
        self.within(if is_settled { solution } else { rough })
    }

    /// From these sets to those that are their own answer, and whether there are such.
    fn settle(&self, mut variables: Held, mut constraints: Held) -> (Solution, bool) {
        let mut solution = self.held(&variables, &constraints);
        for _ in 0..MOST_ROUNDS {
            let (next, more) = self.active(&solution, &variables, &constraints);
            if next == variables && more == constraints {
                return (solution, true);
            }
            (variables, constraints) = (next, more);
            solution = self.held(&variables, &constraints);
        }
        (solution, false)
    }

    /// What is beyond a bound, at it.
    fn within(&self, mut solution: Solution) -> Solution {
        for (i, of) in self.bounds.iter().enumerate() {
            solution.step[i] = of.nearest(self.at.x[i] + solution.step[i]) - self.at.x[i];
        }
        solution
    }

    /// What is active at a solution: what is beyond its bound, or is pushed against it.
    fn active(&self, solution: &Solution, variables: &Held, constraints: &Held) -> (Held, Held) {
        let Linearisation { x, gradient, c, jacobian, .. } = self.at;
        let residual = gradient + self.b * &solution.step + jacobian.tr_mul(&solution.multipliers);
        let next = (0..x.len()).map(|i| match variables[i] {
            // The multiplier of a lower bound is the residual, that of an upper one its opposite.
            Some(bound) if bound == self.bounds[i].least && residual[i] > 0.0 => Some(bound),
            Some(bound) if bound == self.bounds[i].most && residual[i] < 0.0 => Some(bound),
            Some(_) => None,
            None => beyond_open(&self.bounds[i], x[i] + solution.step[i]),
        });
        let ahead = c + jacobian * &solution.step;
        let more = (0..c.len()).map(|j| {
            let of = &self.intervals[j];
            match constraints[j] {
                Some(bound) if of.least == of.most => Some(bound),
                Some(bound) if bound == of.least && solution.multipliers[j] < 0.0 => Some(bound),
                Some(bound) if bound == of.most && solution.multipliers[j] > 0.0 => Some(bound),
                Some(_) => None,
                None => beyond_open(of, ahead[j]),
            }
        });
        (next.collect(), more.collect())
    }

    /// The solution with some variables and constraints held: B over the others by Cholesky, then the constraints by their Schur complement.
    fn held(&self, variables: &Held, constraints: &Held) -> Solution {
        let Linearisation { x, gradient, c, jacobian, .. } = self.at;
        let (n, m) = (x.len(), c.len());
        let free: Vec<usize> = (0..n).filter(|i| variables[*i].is_none()).collect();
        let rows: Vec<usize> = (0..m).filter(|j| constraints[*j].is_some()).collect();
        let mut step = DVector::from_fn(n, |i, _| variables[i].map_or(0.0, |bound| bound - x[i]));
        let mut multipliers = DVector::zeros(m);
        let moved = gradient + self.b * &step;
        let right = DVector::from_fn(free.len(), |i, _| -moved[free[i]]);
        let b = DMatrix::from_fn(free.len(), free.len(), |i, k| self.b[(free[i], free[k])]);
        let Some(factors) = regular(b) else { return Solution { step, multipliers } };
        let a = DMatrix::from_fn(rows.len(), free.len(), |j, i| jacobian[(rows[j], free[i])]);
        let mut inner = factors.solve(&right);
        if !rows.is_empty() {
            let by_rows = factors.solve(&a.transpose());
            let mut schur = &a * &by_rows;
            // Rows that depend on each other share what is asked of them.
            let most = schur.diagonal().amax();
            (0..rows.len()).for_each(|j| schur[(j, j)] += 1e-11 * most.max(f64::MIN_POSITIVE));
            let already = c + jacobian * &step;
            let missing = DVector::from_fn(rows.len(), |j, _| constraints[rows[j]].unwrap_or(0.0) - already[rows[j]]);
            if let Some(schur) = schur.cholesky() {
                let w = schur.solve(&(&a * &inner - missing));
                inner -= by_rows * &w;
                rows.iter().zip(w.iter()).for_each(|(&j, w)| multipliers[j] = *w);
            }
        }
        free.iter().zip(inner.iter()).for_each(|(&i, d)| step[i] = *d);
        Solution { step, multipliers }
    }
}

/// The bound that a value is at or beyond.
fn beyond(of: &Interval, x: f64) -> Option<f64> {
    if of.least == of.most { Some(of.least) } else { beyond_open(of, x) }
}

/// The bound that a value is beyond.
fn beyond_open(of: &Interval, x: f64) -> Option<f64> {
    if x < of.least {
        Some(of.least)
    } else if x > of.most {
        Some(of.most)
    } else {
        None
    }
}

/// The factors, with a little added to the diagonal where rounding has made it indefinite.
pub(super) fn regular(b: DMatrix<f64>) -> Option<nalgebra::Cholesky<f64, nalgebra::Dyn>> {
    let most = b.diagonal().amax();
    let shifts = [0.0, 1e-12, 1e-8, 1e-4];
    shifts.into_iter().find_map(|shift| {
        let mut b = b.clone();
        (0..b.nrows()).for_each(|i| b[(i, i)] += shift * most);
        b.cholesky()
    })
}
