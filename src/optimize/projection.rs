//! [`Projection`]: the constraints with a dense Jacobian.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::trust_region::{Linearised, least_residual};

/// A row of length 1 is independent if its distance from the span of the others exceeds this.
const OWN: f64 = 1e-11;

/// The Jacobian of the constraints in scaled variables, and Q R = Âᵀ of its independent rows, scaled to length 1.
///
/// The rows are factorised, not Â Âᵀ: an equality and a slack next to its bound may differ by less than the square root of rounding.
pub(super) struct Projection {
    pub(super) a: DMatrix<f64>,
    /// Reciprocal lengths of the rows.
    inverse: DVector<f64>,
    /// The row of each column of Q R.
    rows: Vec<usize>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
}

impl Projection {
    pub(super) fn new(jacobian: &DMatrix<f64>, scales: &[f64]) -> Self {
        let mut a = jacobian.clone();
        a.column_iter_mut().zip(scales).for_each(|(mut column, scale)| column *= *scale);
        let inverse = |length: f64| if length > 0.0 { 1.0 / length } else { 0.0 };
        let inverse = DVector::from_iterator(a.nrows(), a.row_iter().map(|row| inverse(row.norm())));
        let mut columns = a.transpose();
        columns.column_iter_mut().zip(&inverse).for_each(|(mut column, inverse)| column *= *inverse);
        let mut rows = RowDVector::from_fn(a.nrows(), |_, j| j);
        let factors = columns.col_piv_qr();
        factors.p().permute_columns(&mut rows);
        let (q, r) = (factors.q(), factors.r());
        let rank = (0..r.nrows()).take_while(|&k| r[(k, k)].abs() > OWN).count();
        let (q, r) = (q.columns(0, rank).into_owned(), r.view((0, 0), (rank, rank)).into_owned());
        Projection { a, inverse, rows: rows.iter().copied().take(rank).collect(), q, r }
    }

    /// The multipliers w that minimise ‖ĝ + Âᵀw‖.
    pub(super) fn multipliers(&self, gradient: &DVector<f64>) -> DVector<f64> {
        let mut w = self.q.tr_mul(gradient);
        // None of its pivots is zero.
        let _ = self.r.solve_upper_triangular_mut(&mut w);
        let mut all = DVector::zeros(self.a.nrows());
        self.rows.iter().zip(&w).for_each(|(&j, w)| all[j] = -w * self.inverse[j]);
        all
    }
}

impl Linearised for Projection {
    fn rank(&self) -> usize {
        self.rows.len()
    }

    fn size(&self) -> f64 {
        self.a.norm()
    }

    fn times(&self, p: &DVector<f64>) -> DVector<f64> {
        &self.a * p
    }

    fn times_transposed(&self, c: &DVector<f64>) -> DVector<f64> {
        self.a.tr_mul(c)
    }

    fn least_change(&self, c: &DVector<f64>) -> DVector<f64> {
        let mut z = DVector::from_iterator(self.rank(), self.rows.iter().map(|&j| -c[j] * self.inverse[j]));
        let _ = self.r.tr_solve_upper_triangular_mut(&mut z);
        let change = &self.q * z;
        least_residual(self, c, change)
    }

    /// Projected twice because of rounding.
    fn project(&self, r: &DVector<f64>) -> DVector<f64> {
        let once = |r: &DVector<f64>| r - &self.q * self.q.tr_mul(r);
        if self.a.nrows() == 0 { r.clone() } else { once(&once(r)) }
    }
}
