//! The point y = (x, s) of the interior-point method, and its steps.

mod small;
mod trial;
mod unit;

use std::rc::Rc;

use nalgebra::{DMatrix, DVector, DVectorView};

use super::super::barrier::{Barrier, INSIDE};
use super::super::counted::Counted;
use super::super::norm::{magnitude, norm};
use super::super::problem::Interval;
use super::super::projection::Projection;
use super::super::trust_region::{Model, ROUNDING, Region};
use super::super::{Iterate, Options};
use crate::Error;
use crate::number::largest;
use trial::Trial;

/// Factor by which μ is reduced once its problem is solved to `SOLVED` times μ.
const LESS: f64 = 0.2;
const SOLVED: f64 = 10.0;
/// The first μ relative to the forces on the variables: with a smaller μ, slacks would be at their bounds before constraints hold.
const FIRST: f64 = 1.0;
/// A step that reduces the violation by less than this fraction makes no progress towards the constraints.
const STUCK: f64 = 1e-9;
/// If a start moved inside its bounds has no value, it is moved by this fraction of the distance, down to `LEAST_INSIDE`.
const SHORTER: f64 = 0.1;
const LEAST_INSIDE: f64 = 1e-9;

/// The point y = (x, s) with its values, derivatives and scales.
pub(super) struct Method {
    /// The constraints that are not free, and those of them that are inequalities.
    rows: Vec<usize>,
    inequalities: Vec<usize>,
    pub(super) barrier: Barrier,
    y: DVector<f64>,
    /// The first x, f and its largest derivative there, and the decrease of f along its gradient.
    pub(super) start: Vec<f64>,
    first_value: f64,
    first_slope: f64,
    first_fall: f64,
    /// The smaller of `first_fall` and the change of f so far: constraints may prevent the first decrease.
    fall: f64,
    pub(super) value: f64,
    /// The gradient of f alone.
    gradient: DVector<f64>,
    c: DVector<f64>,
    jacobian: DMatrix<f64>,
    /// The allowed violation of constraints.
    allowed: f64,
    /// For each row, true if it is an inequality that holds and that no variable changes here, such as a bound at the node where a motion starts. Its
    /// bounds may leave no room for a slack.
    still: Vec<bool>,
    /// The scales D, and the projection onto the constraints in scaled variables.
    scales: DVector<f64>,
    projection: Rc<Projection>,
    /// The multipliers of C.
    multipliers: DVector<f64>,
    pub(super) region: Region,
    /// The first μ, and the largest |C| so far.
    first_mu: f64,
    farthest: f64,
    /// The largest reduced gradient so far.
    steepest: f64,
}

impl Method {
    /// The method at a start moved inside its bounds, by less if the moved start has no value.
    pub(super) fn new(problem: &mut Counted, start: &[f64], allowed: f64) -> Result<Self, Error> {
        let mut share = INSIDE;
        loop {
            let mut x = start.to_vec();
            let size = largest(&x);
            let mut barrier = Barrier::new(problem, &[]);
            barrier.unit = if size > 0.0 { size } else { 1.0 };
            barrier.move_variables(&mut x, share);
            let is_moved = x != start && share > LEAST_INSIDE;
            match Method::at(problem, start, x, allowed) {
                Err(_) if is_moved && !problem.is_stopped() => share *= SHORTER,
                found => return found,
            }
        }
    }

    /// The method at an x inside its bounds, with slacks equal to their constraints and moved inside their bounds.
    pub(super) fn at(problem: &mut Counted, start: &[f64], x: Vec<f64>, allowed: f64) -> Result<Self, Error> {
        let rows: Vec<usize> = (0..problem.intervals.len()).filter(|&j| problem.intervals[j] != Interval::FREE).collect();
        let is_inequality = |j: &usize| !problem.intervals[*j].is_equality();
        let inequalities: Vec<usize> = rows.iter().copied().filter(is_inequality).collect();
        let value = problem.evaluate_start(&x)?;
        let y: Vec<f64> = x.iter().copied().chain(inequalities.iter().map(|&j| problem.c[j])).collect();
        let barrier = Barrier::new(problem, &inequalities);
        let (m, len) = (rows.len(), y.len());
        let mut method = Method {
            rows,
            inequalities,
            barrier,
            y: DVector::from_vec(y),
            start: start.to_vec(),
            first_value: value,
            first_slope: 0.0,
            first_fall: 0.0,
            fall: 0.0,
            value,
            gradient: DVector::zeros(len),
            c: DVector::zeros(m),
            jacobian: DMatrix::zeros(m, len),
            allowed,
            still: vec![false; m],
            scales: DVector::zeros(len),
            projection: Rc::new(Projection::new(&DMatrix::zeros(0, len), &[])),
            multipliers: DVector::zeros(m),
            region: Region { radius: 0.0, penalty: 0.0 },
            first_mu: 0.0,
            farthest: 0.0,
            steepest: 0.0,
        };
        let jacobian = problem.jacobian(&method.rows)?;
        // Computed last, because Hessian products refer to this gradient.
        let gradient = slope(problem)?;
        method.differentiate(problem, (gradient, jacobian));
        method.take_unit(problem)?;
        method.barrier.move_slacks(x.len(), method.y.as_mut_slice());
        method.take_scales(problem);
        if method.barrier.is_there() {
            method.first_mu = FIRST * method.forces(problem)?;
            method.barrier.set(method.first_mu, method.y.as_slice());
        }
        method.find_multipliers();
        Ok(method)
    }

    /// The variables x.
    pub(super) fn x(&self) -> DVectorView<'_, f64> {
        self.y.rows(0, self.y.len() - self.inequalities.len())
    }

    /// C(y), with the values of c at the last evaluated point.
    fn constraints(&self, problem: &Counted, y: &DVector<f64>) -> DVector<f64> {
        let mut slacks = y.iter().skip(problem.bounds.len());
        let differences = self.rows.iter().zip(&self.still).map(|(&j, is_still)| {
            let of = problem.intervals[j];
            let target = if of.is_equality() { Some(&of.least) } else { slacks.next() };
            target.filter(|_| !is_still).map_or(0.0, |target| problem.c[j] - target)
        });
        DVector::from_iterator(self.rows.len(), differences)
    }

    /// ∇f and the Jacobian at the last evaluated point.
    fn derivatives(&self, problem: &mut Counted) -> Result<(Vec<f64>, DMatrix<f64>), Error> {
        Ok((slope(problem)?, problem.jacobian(&self.rows)?))
    }

    /// Stores derivatives, and computes from them the distances `far` of the slacks.
    fn differentiate(&mut self, problem: &Counted, (gradient, jacobian): (Vec<f64>, DMatrix<f64>)) {
        let n = problem.bounds.len();
        self.gradient.rows_mut(0, n).copy_from_slice(&gradient);
        self.jacobian.columns_mut(0, n).copy_from(&jacobian);
        for (slack, k) in self.slacks(n) {
            // Also for variables at their bounds: the room of a slack does not depend on the room of variables.
            let slopes = self.jacobian.row(k).columns(0, n).into_owned();
            let free = slopes.iter().zip(&self.barrier.bounds).filter(|(_, of)| !of.is_equality());
            let change = free.map(|(slope, _)| *slope).fold(0.0, f64::hypot);
            if change > 0.0 {
                self.barrier.far[slack] = change;
            }
        }
    }

    /// Computes C, the scales and the projection.
    fn take_scales(&mut self, problem: &Counted) {
        let n = problem.bounds.len();
        self.scales = self.barrier.scales(self.y.as_slice(), self.barrier.unit).into();
        for (slack, k) in self.slacks(n) {
            let (j, changes) = (self.rows[k], self.jacobian.row(k).columns(0, n).amax() > 0.0);
            self.still[k] = !changes && problem.intervals[j].violation(problem.c[j]) <= self.allowed;
            let moves = if self.still[k] { 0.0 } else { 1.0 };
            self.jacobian[(k, slack)] = -moves;
            self.scales[slack] *= moves;
        }
        self.c = self.constraints(problem, &self.y);
        self.farthest = self.farthest.max(self.c.amax());
        self.projection = Rc::new(Projection::new(&self.jacobian, self.scales.as_slice()));
    }

    /// The slacks, which follow n variables, and their rows.
    fn slacks(&self, n: usize) -> Vec<(usize, usize)> {
        let rows = (0..self.rows.len()).filter(|&k| self.inequalities.binary_search(&self.rows[k]).is_ok());
        (n..).zip(rows).collect()
    }

    /// The gradient of f + barrier in scaled variables.
    fn scaled_gradient(&self) -> DVector<f64> {
        let mut gradient = self.gradient.clone();
        self.barrier.add_gradient(self.y.as_slice(), gradient.as_mut_slice());
        gradient.component_mul(&self.scales)
    }

    /// The largest force on a variable, in scaled units; if all are zero, the largest one after all variables have moved by their scales.
    fn forces(&self, problem: &mut Counted) -> Result<f64, Error> {
        let scales = &self.scales;
        let forces = self.gradient.component_mul(scales).amax();
        if forces > 0.0 {
            return Ok(forces);
        }
        slope(problem)?;
        let ones = DVector::from_element(scales.len(), 1.0);
        Ok(product(problem, &ones, scales, &vec![0.0; scales.len()])?.amax())
    }

    fn find_multipliers(&mut self) {
        self.multipliers = self.projection.multipliers(&self.scaled_gradient());
    }

    /// The multipliers of all constraints of the problem.
    pub(super) fn all_multipliers(&self, problem: &Counted) -> Vec<f64> {
        let mut all = vec![0.0; problem.c.len()];
        self.rows.iter().zip(&self.multipliers).for_each(|(&j, w)| all[j] = *w);
        all
    }

    pub(super) fn first_radius(&self, options: &Options) -> f64 {
        options.first_step.unwrap_or(self.barrier.unit).max(self.x().amax()) / self.barrier.unit
    }

    pub(super) fn iterate(&self, problem: &mut Counted, step: f64) -> Iterate {
        let lagrangian = &self.gradient + self.jacobian.tr_mul(&self.multipliers);
        let stationarity = self.barrier.stationarity(self.y.as_slice(), lagrangian.as_slice(), self.length());
        problem.iterate(self.value, stationarity, step)
    }

    /// Reduces μ while its problem is solved, but not below `asked`, nor, relative to the first μ, below |C| relative to its largest value.
    pub(super) fn lower_barrier(&mut self, asked: f64) {
        while self.barrier.mu > 0.0 {
            let forces = (self.scaled_gradient() + self.projection.a.tr_mul(&self.multipliers)).amax();
            let c = self.c.amax();
            let is_far = c > self.allowed && c * self.first_mu > self.farthest * self.barrier.mu;
            if is_far || forces > SOLVED * self.barrier.mu || self.barrier.mu <= 0.1 * asked {
                return;
            }
            self.barrier.mu *= LESS;
            self.find_multipliers();
        }
    }

    /// Tries steps within shrinking radii. Returns the largest change, and true if no decrease was predicted; `None` if no step is accepted.
    pub(super) fn advance(&mut self, problem: &mut Counted) -> Result<Option<(f64, bool)>, Error> {
        let (scales, mut gradient, projection) = (self.scales.clone(), self.scaled_gradient(), Rc::clone(&self.projection));
        let unit = magnitude(gradient.amax());
        gradient /= unit;
        let curvature = self.barrier.curvature(self.y.as_slice());
        self.prepare_products(problem)?;
        self.region.raise_penalty(norm(self.multipliers.as_slice()));
        let (y, c) = (self.y.clone(), self.c.clone());
        let barrier = self.barrier.clone();
        let model = Model {
            unit,
            gradient: &gradient,
            c: &c,
            constraints: &*projection,
            barrier: &barrier,
            y: &y,
            scales: &scales,
            steepest: self.steepest,
        };
        let (mut step, known) =
            model.step(self.region.radius, &mut |p| Ok(product(problem, p, &scales, &curvature)? / unit))?;
        self.steepest = self.steepest.max(known.reduced);
        while Region::is_long_enough(&step) && !problem.is_stopped() {
            let foreseen = self.region.predict(&step);
            let here = self.merit(self.value, &self.y, &self.c);
            let (next, mut ratio) = self.better_trial(problem, &step, &projection, &scales, (here, foreseen));
            if Region::accepts(ratio)
                && let Some(derivatives) = self.derivatives_at(problem, &next.y)
            {
                self.region.grow(ratio, step.length);
                let is_idle = foreseen <= ROUNDING * here.abs() && step.closer <= STUCK * self.c.norm();
                return Ok(Some((self.take(problem, next, derivatives), is_idle)));
            }
            if Region::accepts(ratio) {
                ratio = f64::NEG_INFINITY;
            }
            self.region.shrink(ratio, step.length);
            step = model.shorter(self.region.radius, &known);
        }
        Ok(None)
    }

    /// Computes the gradient of the Lagrangian, so that products are those of its Hessian.
    fn prepare_products(&self, problem: &mut Counted) -> Result<(), Error> {
        let mut lagrangian = vec![0.0; problem.bounds.len()];
        problem.gradient(1.0, &self.all_multipliers(problem), &mut lagrangian)
    }

    /// Derivatives at a trial point, which is evaluated again if another one was evaluated since; `None`, if there are none, rejects the trial.
    fn derivatives_at(&self, problem: &mut Counted, y: &DVector<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let has_value = problem.ensure(&y.as_slice()[..problem.bounds.len()]);
        if has_value { self.derivatives(problem).ok() } else { None }
    }

    /// Moves to the last evaluated point.
    fn take(&mut self, problem: &Counted, to: Trial, derivatives: (Vec<f64>, DMatrix<f64>)) -> f64 {
        let length = (to.y.rows(0, self.x().len()) - self.x()).amax();
        self.barrier.step(self.y.as_slice(), to.y.as_slice());
        (self.y, self.value) = (to.y, to.value);
        self.fall = self.first_fall.min((self.value - self.first_value).abs());
        self.differentiate(problem, derivatives);
        self.take_scales(problem);
        self.find_multipliers();
        length
    }
}

/// ∇f at the last evaluated point.
fn slope(problem: &mut Counted) -> Result<Vec<f64>, Error> {
    let mut gradient = vec![0.0; problem.bounds.len()];
    problem.gradient(1.0, &vec![0.0; problem.c.len()], &mut gradient)?;
    Ok(gradient)
}

/// D (H + Σ) D p.
pub(super) fn product(
    problem: &mut Counted,
    p: &DVector<f64>,
    scales: &DVector<f64>,
    curvature: &[f64],
) -> Result<DVector<f64>, Error> {
    let (n, d) = (problem.bounds.len(), p.component_mul(scales));
    let mut result = DVector::zeros(d.len());
    problem.product(&d.as_slice()[..n], &mut result.as_mut_slice()[..n])?;
    let terms = result.iter_mut().zip(&d).zip(curvature.iter().zip(scales));
    terms.for_each(|((x, d), (curvature, scale))| *x = (*x + curvature * d) * scale);
    Ok(result)
}
