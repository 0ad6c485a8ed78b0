//! [`TangentPlane`]: the linearised constraints of a problem in stages, in variables p = D⁻¹ d scaled with their distances from bounds.

use nalgebra::{DMatrix, DVector};

use super::super::trust_region::{Linearised, least_residual};
use super::method::Method;
use super::newton::{Kkt, Newton};
use super::problem::{Multipliers, Residuals};

/// The constraints at the current point, and the factors of their KKT matrix with the Hessian (D/unit)⁻².
pub(super) struct TangentPlane<'a, 'p> {
    pub method: &'a Method<'p>,
    pub newton: &'a Newton<'a>,
    /// D.
    pub scales: &'a DVector<f64>,
}

impl Method<'_> {
    /// The scale of each entry of y; 0 for entries that cannot move.
    pub(super) fn scales(&self) -> DVector<f64> {
        let (mut scales, shape) = (self.barrier.scales(&self.y, self.barrier.unit), self.problem.shape());
        (0..shape.states).filter(|i| !shape.of_whole.contains(i)).for_each(|i| scales[i] = 0.0);
        scales.into()
    }

    /// The matrices of all stages with the Hessian (D/unit)⁻², whose entries are at least 1: small ones would be rounding beside the weight of rows.
    pub(super) fn metric(&self, scales: &DVector<f64>) -> Kkt {
        let zeros = self.problem.shape().bounds.iter().map(|of| DMatrix::zeros(of.len(), of.len())).collect();
        let unit = self.barrier.unit;
        self.kkt_of(zeros, scales.iter().map(|scale| if *scale > 0.0 { (unit / scale).powi(2) } else { 1.0 }).collect())
    }

    fn no_residuals(&self) -> Residuals {
        Residuals::of(Multipliers::zeros(self.problem.shape()))
    }

    fn as_multipliers(&self, c: &DVector<f64>) -> Multipliers {
        let mut all = Multipliers::zeros(self.problem.shape());
        all.set(c.as_slice());
        all
    }
}

impl TangentPlane<'_, '_> {
    /// D⁻¹ d; 0 for entries that cannot move.
    pub(super) fn scaled(&self, d: &[f64]) -> DVector<f64> {
        let all = d.iter().zip(self.scales).map(|(d, scale)| if *scale > 0.0 { d / scale } else { 0.0 });
        DVector::from_iterator(d.len(), all)
    }

    /// The multipliers w that minimise ‖ĝ + Âᵀw‖ for the gradient of the barrier function.
    pub(super) fn multipliers(&self) -> Multipliers {
        self.newton.solve(self.method, &self.method.gradient_of_value(), &self.method.no_residuals()).multipliers
    }
}

impl Linearised for TangentPlane<'_, '_> {
    fn rank(&self) -> usize {
        self.method.multipliers.all().count()
    }

    fn size(&self) -> f64 {
        let Method { linear, first, .. } = self.method;
        let columns = linear.iter().zip(first).flat_map(|(of, first)| {
            let both = of.dynamics.column_iter().zip(of.rows.column_iter());
            both.enumerate().map(move |(i, (x, y))| (first + i, x.norm_squared() + y.norm_squared()))
        });
        // At least the entries −1 of the next states and of the slacks.
        let others = self.scales.norm_squared();
        (columns.map(|(i, square)| square * self.scales[i].powi(2)).sum::<f64>() + others).sqrt()
    }

    fn times(&self, p: &DVector<f64>) -> DVector<f64> {
        self.method.changes(p.component_mul(self.scales).as_slice()).flat()
    }

    fn times_transposed(&self, c: &DVector<f64>) -> DVector<f64> {
        let mut gradient = vec![0.0; self.method.y.len()];
        self.method.add_constraints(&self.method.as_multipliers(c), &mut gradient);
        DVector::from_vec(gradient).component_mul(self.scales)
    }

    fn least_change(&self, c: &DVector<f64>) -> DVector<f64> {
        let residuals = Residuals::of(self.method.as_multipliers(c));
        let step = self.newton.solve(self.method, &vec![0.0; self.method.y.len()], &residuals);
        least_residual(self, c, self.scaled(&step.y))
    }

    fn project(&self, r: &DVector<f64>) -> DVector<f64> {
        let step = self.newton.solve(self.method, self.scaled(r.as_slice()).as_slice(), &self.method.no_residuals());
        self.scaled(&step.y) * -self.method.barrier.unit.powi(2)
    }
}
