//! [`Near`]: a problem in stages whose cost is the distance from a point.

use nalgebra::{DMatrix, DVector};

use super::super::problem::Interval;
use super::problem::{Counts, Linear, Multipliers, Shape, Staged, Values};
use crate::Error;

/// The weight of a quantity of the whole motion, where all other variables together have the weight 1: a duration or a design variable that could
/// change freely would, in the linearised constraints, replace most of what controls must do.
const OF_WHOLE: f64 = 100.0;

/// The problem with the constraints of another one and the cost ½ Σ (v − v̄)ᵀ W (v − v̄), where W weights variables, not copies of them.
///
/// Only fixed variables and quantities of the whole motion keep their bounds: far from feasible points, controls run into theirs, where steps become short.
pub(super) struct Near<'p> {
    of: &'p mut dyn Staged,
    shape: Shape,
    /// v̄.
    centre: Vec<DVector<f64>>,
    /// The diagonal of W.
    weights: Vec<DVector<f64>>,
    /// v − v̄ at the last evaluated point.
    difference: Vec<DVector<f64>>,
}

impl<'p> Near<'p> {
    pub(super) fn new(of: &'p mut dyn Staged, centre: &[DVector<f64>]) -> Self {
        let mut shape = of.shape().clone();
        let mut weights = shape.shifted.clone();
        let count = weights.iter().map(|of| of.sum()).sum::<f64>();
        weights.iter_mut().for_each(|of| *of /= count);
        let whole = shape.of_whole.clone();
        whole.iter().for_each(|&i| weights[0][i] = OF_WHOLE);
        for (k, bounds) in shape.bounds.iter_mut().enumerate() {
            let is_kept = |i: usize, of: &Interval| of.is_equality() || k == 0 && whole.contains(&i);
            let dropped = bounds.iter_mut().enumerate().filter(|(i, of)| !is_kept(*i, of));
            dropped.for_each(|(_, of)| *of = Interval::FREE);
        }
        Near { of, shape, centre: centre.to_vec(), weights, difference: Vec::new() }
    }
}

impl Staged for Near<'_> {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn counts(&self) -> Counts {
        self.of.counts()
    }

    fn is_halved(&self) -> bool {
        self.of.is_halved()
    }

    fn x(&self, v: &[DVector<f64>]) -> Vec<f64> {
        self.of.x(v)
    }

    fn evaluate(&mut self, v: &[DVector<f64>]) -> Result<Values, Error> {
        self.difference = v.iter().zip(&self.centre).map(|(v, centre)| v - centre).collect();
        let squares = self.difference.iter().zip(&self.weights).map(|(d, weights)| d.component_mul(d).dot(weights));
        let cost = 0.5 * squares.sum::<f64>();
        Ok(Values { cost, ..self.of.evaluate(v)? })
    }

    fn linearise(&mut self) -> Result<Vec<Linear>, Error> {
        let mut all = self.of.linearise()?;
        for (of, (d, weights)) in all.iter_mut().zip(self.difference.iter().zip(&self.weights)) {
            of.gradient = d.component_mul(weights);
        }
        Ok(all)
    }

    fn hessians(&mut self, cost: f64, multipliers: &Multipliers) -> Result<Vec<DMatrix<f64>>, Error> {
        let mut all = self.of.hessians(0.0, multipliers)?;
        for (hessian, weights) in all.iter_mut().zip(&self.weights) {
            weights.iter().enumerate().for_each(|(i, weight)| hessian[(i, i)] += cost * weight);
        }
        Ok(all)
    }
}
