//! Trust-region steps for a problem in stages ([`trust_region`](super::super::trust_region)). They are used when the filter line search fails: they
//! are slower, but more reliable far from feasible points and near bounds. Multipliers are least-squares estimates, which cannot grow from step to step.

use nalgebra::{DMatrix, DVector};

use super::super::Reason;
use super::super::barrier::TO_BOUND;
use super::super::norm::{magnitude, norm};
use super::super::outcome::largest_change;
use super::super::trust_region::{CORRECTIONS, Linearised, Model, ROUNDING, Region, Step, TAKEN_BACK};
use super::method::Method;
use super::newton::{Kkt, Newton};
use super::problem::Values;
use super::run::Run;
use super::tangent_plane::TangentPlane;
use crate::Error;

/// Newton steps that bounds shorten by more than this are not taken.
const UNHINDERED: f64 = 0.9;
/// The violation is stationary if no variable would reduce the sum of squares by more than this fraction on its way to a bound, or by one unit.
const STATIONARY: f64 = 1e-3;
/// The method ends after this many steps in sequence that change φ by no more than rounding error.
const MOST_IDLE: usize = 10;

/// The Hessian with the curvature of the barrier, in scaled variables.
struct Hessian<'a> {
    blocks: &'a [DMatrix<f64>],
    curvature: &'a [f64],
    scales: &'a DVector<f64>,
    /// Power of two by which Ĥ is divided.
    unit: f64,
}

impl Hessian<'_> {
    fn times(&self, p: &DVector<f64>) -> DVector<f64> {
        let d = p.component_mul(self.scales);
        let mut product = DVector::from_iterator(d.len(), d.iter().zip(self.curvature).map(|(d, of)| d * of));
        let mut first = 0;
        for block in self.blocks {
            product.rows_mut(first, block.nrows()).gemv(1.0, block, &d.rows(first, block.nrows()), 1.0);
            first += block.nrows();
        }
        product.component_mul(self.scales) / self.unit
    }
}

/// A point to which a step leads, and its constraints.
struct Trial {
    y: Vec<f64>,
    values: Values,
    c: DVector<f64>,
}

/// The metric of the trust region at the current point.
type Metric<'a> = (&'a Newton<'a>, &'a DVector<f64>);

impl Run<'_, '_> {
    /// Iterates within a trust region until there is a reason to stop, or, if this is asked for, until steps along lines may lead on (`None`).
    ///
    /// # Errors
    /// A problem without second derivatives.
    pub(super) fn within_region(&mut self, method: &mut Method<'_>, until_close: bool) -> Result<Option<Reason>, Error> {
        let (unit, begin) = (method.barrier.unit, self.history.len());
        let radius = method.y.iter().fold(unit, |most, y| most.max(y.abs())) / unit;
        let (mut region, mut steepest) = (Region { radius, penalty: 0.0 }, 0.0);
        let (mut moved, mut idle) = (0.0, 0);
        loop {
            let scales = method.scales();
            let metric = method.metric(&scales);
            let Some(newton) = metric.factors() else { return Ok(Some(Reason::NoLowerValue)) };
            let metric = (&newton, &scales);
            method.multipliers = method.plane(metric).multipliers();
            if let Some(reason) = self.record(method, moved) {
                return Ok(Some(reason));
            }
            if until_close && self.comes_close(begin) {
                return Ok(None);
            }
            if self.lower_barrier(method) {
                method.multipliers = method.plane(metric).multipliers();
            }
            let (before, value) = (method.y.clone(), method.pair(&method.y, &method.values).value);
            let is_moved = match self.is_stuck(begin) || idle >= MOST_IDLE {
                true => Ok(false),
                false => self.step_within(method, metric, (&mut region, &mut steepest)),
            };
            match is_moved {
                Ok(true) => moved = largest_change(&method.y, &before),
                Ok(false) if self.is_interrupted() => return Ok(Some(Reason::Interrupted)),
                Ok(false) if self.is_violated() && method.is_least_violated() => return Ok(Some(Reason::Infeasible)),
                Ok(false) => return Ok(Some(Reason::NoLowerValue)),
                Err(error) => return self.without_derivatives(error).map(Some),
            }
            let change = (method.pair(&method.y, &method.values).value - value).abs();
            idle = if !self.is_violated() && change <= ROUNDING * value.abs() { idle + 1 } else { 0 };
        }
    }

    /// Takes a step within the region, which shrinks until one is accepted; false if none is.
    ///
    /// # Errors
    /// A point without second derivatives.
    fn step_within(
        &mut self,
        method: &mut Method<'_>,
        metric: Metric<'_>,
        (region, steepest): (&mut Region, &mut f64),
    ) -> Result<bool, Error> {
        let (scales, c) = (metric.1, method.residuals(&method.y, &method.values).flat());
        let mut gradient = DVector::from_vec(method.gradient_of_value()).component_mul(scales);
        let unit = magnitude(gradient.amax());
        gradient /= unit;
        region.raise_penalty(norm(&method.multipliers.all().copied().collect::<Vec<f64>>()));
        let (y, barrier, curvature) =
            (DVector::from_column_slice(&method.y), method.barrier.clone(), method.barrier.curvature(&method.y));
        let blocks = method.problem.hessians(method.scale, &method.multipliers)?;
        let hessian = Hessian { blocks: &blocks, curvature: &curvature, scales, unit };
        let kkt = method.kkt_of(blocks.clone(), curvature.clone());
        let (mut known, mut is_first) = (None, true);
        loop {
            let plane = method.plane(metric);
            let largest = *steepest;
            let (constraints, y, barrier) = (&plane, &y, &barrier);
            let model = Model { unit, gradient: &gradient, c: &c, constraints, barrier, y, scales, steepest: largest };
            let direct = std::mem::take(&mut is_first)
                .then(|| method.newton_step(&kkt, &plane, &model, (&hessian, region.radius)))
                .flatten();
            let step = match (direct, &known) {
                (Some(step), _) => step,
                (_, Some(known)) => model.shorter(region.radius, known),
                _ => {
                    let (step, found) = model.step(region.radius, &mut |p| Ok(hessian.times(p)))?;
                    *steepest = largest.max(found.reduced);
                    known = Some(found);
                    step
                }
            };
            if !Region::is_long_enough(&step) || self.is_interrupted() {
                return Ok(false);
            }
            let foreseen = region.predict(&step);
            let mut ratio = f64::NEG_INFINITY;
            if let Some((next, found)) = self.better_trial(method, metric, &step, (region, foreseen)) {
                ratio = found;
                if Region::accepts(ratio) && self.take(method, next) {
                    region.grow(ratio, step.length);
                    return Ok(true);
                }
            }
            region.shrink(if Region::accepts(ratio) { f64::NEG_INFINITY } else { ratio }, step.length);
        }
    }

    /// Moves to a trial; false if it has no derivatives.
    fn take(&mut self, method: &mut Method<'_>, to: Trial) -> bool {
        // The problem may have been evaluated at another point since.
        let values = method.problem.evaluate(&method.v(&to.y));
        match values.and_then(|values| Ok((values, method.problem.linearise()?))) {
            Ok((values, linear)) => {
                method.barrier.step(&method.y, &to.y);
                (method.y, method.values, method.linear) = (to.y, values, linear);
                true
            }
            Err(error) => {
                self.fail(error);
                false
            }
        }
    }

    /// The trial of a step or, if it is better, of the step corrected for the curvature of the constraints; and the decrease of φ relative to the
    /// prediction. `None` if the step leads to a point without values.
    fn better_trial(
        &mut self,
        method: &mut Method<'_>,
        metric: Metric<'_>,
        step: &Step,
        (region, foreseen): (&Region, f64),
    ) -> Option<(Trial, f64)> {
        let phi = |method: &Method<'_>, y: &[f64], values: &Values, c: &DVector<f64>| {
            method.pair(y, values).value + region.penalty * c.norm()
        };
        let here = phi(method, &method.y, &method.values, &method.residuals(&method.y, &method.values).flat());
        let ratio = |method: &Method<'_>, to: &Trial| Region::ratio(here, phi(method, &to.y, &to.values, &to.c), foreseen);
        let mut best = self.trial_of(method, &step.p, metric.1)?;
        let mut found = ratio(method, &best);
        let (mut p, mut c) = (step.p.clone(), best.c.clone());
        for _ in 0..CORRECTIONS {
            if Region::accepts(found) || c.is_empty() {
                break;
            }
            p += method.plane(metric).least_change(&c);
            let d = p.component_mul(metric.1);
            if method.barrier.most(TO_BOUND, &method.y, &vec![0.0; d.len()], d.as_slice()) < 1.0 {
                break;
            }
            let Some(other) = self.trial_of(method, &p, metric.1) else { break };
            let (of_other, left) = (ratio(method, &other), other.c.norm() / c.norm());
            c.clone_from(&other.c);
            if of_other > found {
                (best, found) = (other, of_other);
            }
            if left.is_nan() || left > TAKEN_BACK {
                break;
            }
        }
        Some((best, found))
    }

    fn trial_of(&mut self, method: &mut Method<'_>, p: &DVector<f64>, scales: &DVector<f64>) -> Option<Trial> {
        let mut y: Vec<f64> = method.y.iter().zip(p.iter().zip(scales)).map(|(y, (p, scale))| y + p * scale).collect();
        method.barrier.keep_inside(&method.y, &mut y);
        match method.problem.evaluate(&method.v(&y)) {
            Ok(values) => {
                let c = method.residuals(&y, &values).flat();
                (values.cost + c.norm()).is_finite().then_some(Trial { y, values, c })
            }
            Err(error) => {
                self.fail(error);
                None
            }
        }
    }
}

impl<'p> Method<'p> {
    fn plane<'a>(&'a self, (newton, scales): Metric<'a>) -> TangentPlane<'a, 'p> {
        TangentPlane { method: self, newton, scales }
    }

    /// The step of Newton's method if the Hessian is convex along the constraints and if the step is within the radius and the bounds.
    fn newton_step(
        &self,
        kkt: &Kkt,
        plane: &TangentPlane<'_, '_>,
        model: &Model<'_>,
        (hessian, radius): (&Hessian<'_>, f64),
    ) -> Option<Step> {
        let found = kkt.factors()?.step(self, &self.residuals(&self.y, &self.values));
        let p = plane.scaled(&found.y);
        let d = p.component_mul(plane.scales);
        let most = self.barrier.most(self.share(), &self.y, &vec![0.0; d.len()], d.as_slice());
        // False for NaN.
        let fits = p.norm() <= radius && most >= UNHINDERED;
        fits.then(|| {
            let p = p * most;
            let of_p = hessian.times(&p);
            model.complete(p, &of_p)
        })
    }

    /// True if the sum of squares of the violations is stationary.
    fn is_least_violated(&self) -> bool {
        let residuals = self.residuals(&self.y, &self.values);
        let (square, mut slope) = (residuals.flat().norm_squared(), vec![0.0; self.y.len()]);
        self.add_constraints(&residuals.into_multipliers(), &mut slope);
        let unit = self.barrier.unit;
        unit * self.barrier.stationarity(&self.y, &slope, unit) <= STATIONARY * square
    }
}
