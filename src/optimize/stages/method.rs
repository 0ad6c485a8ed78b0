//! [`Method`]: an iterate of the primal-dual interior-point method for a problem in stages, with its derivatives and errors.

use nalgebra::DVector;

use super::super::barrier::{Barrier, INSIDE, TO_BOUND};
use super::super::problem::Interval;
use super::filter::Pair;
use super::newton::Step;
use super::problem::{Linear, Multipliers, Residuals, Staged, Values};
use crate::Error;

/// Multipliers of this average size do not change the scale of stationarity.
const USUAL: f64 = 100.0;
/// The largest entry of the gradient of the cost at the start lies between these after scaling.
const GRADIENT: [f64; 2] = [1e-2, 1.0];

/// The first μ is the last one if it would not be larger by more than this factor.
const CLOSE: f64 = 10.0;

/// A row with an inequality.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub stage: usize,
    pub row: usize,
}

/// The point y = (v_0, …, v_K, slacks) with its multipliers and derivatives.
pub(super) struct Method<'p> {
    pub problem: &'p mut dyn Staged,
    /// The first entry of y of each stage, and of the slacks.
    pub first: Vec<usize>,
    /// The rows of each stage that are equalities.
    pub equalities: Vec<Vec<usize>>,
    pub inequalities: Vec<Place>,
    pub y: Vec<f64>,
    pub values: Values,
    pub linear: Vec<Linear>,
    pub multipliers: Multipliers,
    pub barrier: Barrier,
    /// Factor of the cost.
    pub scale: f64,
    /// The last shift of the Hessian that was needed.
    pub shift: f64,
}

/// A start far from any known minimum, or near one.
pub(super) enum Start {
    /// Far from any known minimum: the first μ.
    Far(f64),
    /// Near a minimum: the slopes of its Lagrangian, and the smallest and the largest first μ.
    Near(Slopes, [f64; 2]),
}

/// Derivatives of the Lagrangian, without the multipliers of bounds, by the variables v and by the slacks of rows.
pub(super) struct Slopes {
    pub variables: Vec<DVector<f64>>,
    pub rows: Vec<DVector<f64>>,
}

/// Errors of an iterate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    pub stationarity: f64,
    pub violation: f64,
}

impl<'p> Method<'p> {
    /// The method at a start, which is moved inside its bounds.
    ///
    /// # Errors
    /// A point without values or derivatives.
    pub(super) fn new(problem: &'p mut dyn Staged, v: &[DVector<f64>], start: &Start) -> Result<Self, Error> {
        let shape = problem.shape();
        let mut first = vec![0];
        first.extend(shape.bounds.iter().scan(0, |end, of| {
            *end += of.len();
            Some(*end)
        }));
        let equalities =
            shape.rows.iter().map(|rows| (0..rows.len()).filter(|&row| rows[row].is_equality()).collect()).collect();
        let all = shape.rows.iter().enumerate();
        let places = all.flat_map(|(stage, rows)| (0..rows.len()).map(move |row| Place { stage, row }));
        let inequalities: Vec<Place> = places.filter(|at| !shape.rows[at.stage][at.row].is_equality()).collect();
        let multipliers = Multipliers::zeros(shape);
        let mut method = Method {
            problem,
            first,
            equalities,
            inequalities,
            y: Vec::new(),
            values: Values { cost: f64::INFINITY, next: Vec::new(), rows: Vec::new() },
            linear: Vec::new(),
            multipliers,
            barrier: Barrier::of(Vec::new()),
            scale: 1.0,
            shift: 0.0,
        };
        method.restart(v, start)?;
        Ok(method)
    }

    /// Restarts at a point, which is moved inside its bounds.
    ///
    /// # Errors
    /// A point without values or derivatives.
    pub(super) fn restart(&mut self, v: &[DVector<f64>], start: &Start) -> Result<(), Error> {
        let shape = self.problem.shape();
        let of_rows = self.inequalities.iter().map(|at| shape.rows[at.stage][at.row]);
        let bounds: Vec<Interval> = shape.bounds.iter().flatten().copied().chain(of_rows).collect();
        let mut y: Vec<f64> = v.iter().flat_map(|v| v.iter().copied()).collect();
        y.iter_mut().zip(&bounds).for_each(|(y, of)| *y = of.nearest(*y));
        self.barrier = Barrier::of(bounds);
        self.barrier.unit = y.iter().fold(1.0f64, |most, x| most.max(x.abs()));
        if let Start::Far(mu) = start {
            self.barrier.move_variables(&mut y, INSIDE.min(*mu));
        }
        (self.y, self.scale, self.shift) = (y, 1.0, 0.0);
        self.multipliers = Multipliers::zeros(shape);
        self.begin(matches!(start, Start::Far(_)))?;
        match start {
            _ if !self.barrier.is_there() => Ok(()),
            Start::Far(mu) => {
                self.barrier.set(*mu, &self.y);
                Ok(())
            }
            Start::Near(slopes, mu) => self.begin_near(slopes, *mu),
        }
    }

    /// Moves the start to where complementarity holds for these slopes of the Lagrangian.
    fn begin_near(&mut self, slopes: &Slopes, [least, most]: [f64; 2]) -> Result<(), Error> {
        let of_slack = |at: &Place| slopes.rows[at.stage][at.row];
        let all = slopes.variables.iter().flat_map(|of| of.iter().copied()).chain(self.inequalities.iter().map(of_slack));
        let scaled: Vec<f64> = all.map(|g| self.scale * g).collect();
        let slacks = self.slack(0);
        self.barrier.begin_near(least, &scaled, (slacks, &mut self.y));
        self.evaluate_with_copies()?;
        // Bounds whose distance and multiplier are of the size of the change may become active.
        let mu = self.violation().powi(2).min(most);
        if mu > CLOSE * least {
            self.barrier.begin_near(mu, &scaled, (slacks, &mut self.y));
            self.evaluate_with_copies()?;
        }
        self.linear = self.problem.linearise()?;
        Ok(())
    }

    /// Computes values, slacks, derivatives and the factor of the cost at the start. If it is far from a minimum, slacks are moved inside their
    /// bounds.
    fn begin(&mut self, is_far: bool) -> Result<(), Error> {
        self.evaluate_with_copies()?;
        let slacks: Vec<f64> = self.inequalities.iter().map(|at| self.values.rows[at.stage][at.row]).collect();
        self.y.extend(slacks);
        if is_far {
            self.barrier.move_slacks(self.slack(0), &mut self.y);
        }
        self.linear = self.problem.linearise()?;
        let steepest = self.linear.iter().fold(0.0f64, |most, of| most.max(of.gradient.amax()));
        if steepest > 0.0 {
            self.scale = steepest.clamp(GRADIENT[0], GRADIENT[1]) / steepest;
        }
        Ok(())
    }

    /// Computes values after variables have been moved, of which later stages have copies.
    fn evaluate_with_copies(&mut self) -> Result<(), Error> {
        let values = self.problem.evaluate(&self.v(&self.y))?;
        let shape = self.problem.shape();
        for k in 1..shape.bounds.len() {
            let copies = (0..shape.states).filter(|&i| shape.shifted[k][i] == 0.0);
            copies.for_each(|i| self.y[self.first[k] + i] = values.next[k - 1][i]);
        }
        self.values = self.problem.evaluate(&self.v(&self.y))?;
        Ok(())
    }

    /// The stages' parts of y.
    pub(super) fn v(&self, y: &[f64]) -> Vec<DVector<f64>> {
        self.first.windows(2).map(|ends| DVector::from_column_slice(&y[ends[0]..ends[1]])).collect()
    }

    /// The entry of y of a slack.
    pub(super) fn slack(&self, i: usize) -> usize {
        self.first[self.first.len() - 1] + i
    }

    /// True if the bounds of a variable are equal.
    pub(super) fn is_held(&self, stage: usize, i: usize) -> bool {
        self.barrier.bounds[self.first[stage] + i].is_equality()
    }

    /// The linear changes of the residuals for a change d of y.
    pub(super) fn changes(&self, d: &[f64]) -> Residuals {
        let states = self.problem.shape().states;
        let (mut defects, mut rows) = (Vec::new(), Vec::new());
        for (k, of) in self.linear.iter().enumerate() {
            let own = DVector::from_column_slice(&d[self.first[k]..self.first[k + 1]]);
            if of.dynamics.nrows() > 0 {
                let next = &d[self.first[k + 1]..][..states];
                defects.push(&of.dynamics * &own - DVector::from_column_slice(next));
            }
            rows.push(&of.rows * &own);
        }
        for (i, at) in self.inequalities.iter().enumerate() {
            rows[at.stage][at.row] -= d[self.slack(i)];
        }
        Residuals { defects, rows }
    }

    /// F_k − s_{k+1}, and c less its value or its slack.
    pub(super) fn residuals(&self, y: &[f64], values: &Values) -> Residuals {
        let shape = self.problem.shape();
        let defect = |(k, next): (usize, &DVector<f64>)| {
            let s = &y[self.first[k + 1]..];
            DVector::from_fn(shape.states, |i, _| next[i] - s[i])
        };
        let mut rows = values.rows.clone();
        for (k, rows) in rows.iter_mut().enumerate() {
            self.equalities[k].iter().for_each(|&row| rows[row] -= shape.rows[k][row].least);
        }
        for (i, at) in self.inequalities.iter().enumerate() {
            rows[at.stage][at.row] -= y[self.slack(i)];
        }
        Residuals { defects: values.next.iter().enumerate().map(defect).collect(), rows }
    }

    /// The sum of all violations and the barrier function, at a point.
    pub(super) fn pair(&self, y: &[f64], values: &Values) -> Pair {
        let violation = self.residuals(y, values).all().map(|x| x.abs()).sum();
        Pair { violation, value: self.scale * values.cost + self.barrier.value(y) }
    }

    /// The largest violation: of continuity, of an equality, or of a row with its slack.
    pub(super) fn violation(&self) -> f64 {
        self.residuals(&self.y, &self.values).all().fold(0.0f64, |most, x| most.max(x.abs()))
    }

    /// The gradient of the cost by y.
    pub(super) fn gradient_of_cost(&self) -> Vec<f64> {
        let of_v = self.linear.iter().flat_map(|of| of.gradient.iter().map(|g| self.scale * g));
        of_v.chain(self.inequalities.iter().map(|_| 0.0)).collect()
    }

    /// The gradient of the barrier function by y.
    pub(super) fn gradient_of_value(&self) -> Vec<f64> {
        let mut gradient = self.gradient_of_cost();
        self.barrier.add_gradient(&self.y, &mut gradient);
        gradient
    }

    /// Adds the derivatives of the constraints times their multipliers. Entries that cannot move become zero.
    pub(super) fn add_constraints(&self, Multipliers { costates, rows }: &Multipliers, gradient: &mut [f64]) {
        let shape = self.problem.shape();
        for (k, of) in self.linear.iter().enumerate() {
            let mut here = of.rows.tr_mul(&rows[k]);
            if let Some(costate) = costates.get(k) {
                here.gemv_tr(1.0, &of.dynamics, costate, 1.0);
            }
            if k > 0 {
                (0..shape.states).for_each(|i| here[i] -= costates[k - 1][i]);
            }
            gradient[self.first[k]..].iter_mut().zip(here.iter()).for_each(|(g, x)| *g += x);
        }
        for (i, at) in self.inequalities.iter().enumerate() {
            gradient[self.slack(i)] -= rows[at.stage][at.row];
        }
        (0..shape.states).filter(|i| !shape.of_whole.contains(i)).for_each(|i| gradient[i] = 0.0);
        gradient.iter_mut().zip(&self.barrier.bounds).filter(|(_, of)| of.is_equality()).for_each(|(g, _)| *g = 0.0);
    }

    /// Errors of the conditions for a minimum of the barrier problem with μ.
    pub(super) fn errors(&self, mu: f64) -> Errors {
        let mut gradient = self.gradient_of_cost();
        self.barrier.add_multipliers(&mut gradient);
        self.add_constraints(&self.multipliers, &mut gradient);
        let (count, sum) = self.multipliers.all().fold((0, 0.0), |(count, sum), x| (count + 1, sum + x.abs()));
        let average = (sum + self.barrier.sum_of_multipliers()) / (count + 2 * self.y.len()).max(1) as f64;
        let largest = gradient.iter().fold(0.0f64, |most, g| most.max(g.abs()));
        let stationarity = largest.max(self.barrier.complementarity(&self.y, mu)) / (average / USUAL).max(1.0);
        Errors { stationarity, violation: self.violation() }
    }

    /// The derivative of the barrier function along a step.
    pub(super) fn slope(&self, step: &Step) -> f64 {
        self.gradient_of_value().iter().zip(&step.y).map(|(g, d)| g * d).sum()
    }

    /// Moves to the point y after a fraction α of a step, and computes the derivatives there.
    ///
    /// # Errors
    /// A point without derivatives.
    pub(super) fn go(&mut self, step: &Step, alpha: f64, y: Vec<f64>, values: Values) -> Result<(), Error> {
        self.linear = self.problem.linearise()?;
        self.barrier.step_multipliers(self.share(), &self.y, &step.y, &y);
        (self.y, self.values) = (y, values);
        self.multipliers.add(alpha, &step.multipliers);
        Ok(())
    }

    /// The fraction of the distance to a bound that a step may cover.
    pub(super) fn share(&self) -> f64 {
        TO_BOUND.max(1.0 - self.barrier.mu)
    }
}
