//! [`Fit`]: what least squares found.

use nalgebra::{DMatrix, DVector};

use super::Outcome;
use super::norm::norm;

/// Singular values below this share of the largest are none; what of a variable is beyond the others, squared, more than rounding.
const SINGULAR: f64 = 1e-13;
const UNSEEN: f64 = 1e-6;

/// Where a fit ended, and how well its variables are known.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The point, whose value is ½‖r‖².
    pub outcome: Outcome,
    /// ∂r/∂x there, of the residuals that are asked for anything.
    pub jacobian: DMatrix<f64>,
}

impl Fit {
    /// s² (AᵀA)⁻¹ with s² = ‖r‖²/(residuals − variables): the covariance of the variables if residuals differ by noise of one size alone. Variables that a
    /// bound holds are taken for free.
    ///
    /// None without more residuals than variables, and if the residuals do not determine all variables ([`undetermined`](Self::undetermined)).
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        self.root().map(|root| root.tr_mul(&root))
    }

    /// Whose square is the covariance, and lengths of whose columns are the standard errors.
    fn root(&self) -> Option<DMatrix<f64>> {
        let (m, n) = self.jacobian.shape();
        let freedom = m.checked_sub(n).filter(|freedom| *freedom > 0)?;
        if n == 0 {
            return Some(DMatrix::zeros(0, 0));
        }
        let (values, v, lengths) = self.directions();
        if values.iter().any(|s| *s <= SINGULAR * values.amax()) {
            return None;
        }
        let deviation = (2.0 * self.outcome.value / freedom as f64).sqrt();
        Some(DMatrix::from_fn(v.nrows(), v.ncols(), |i, j| deviation / lengths[j] * (v[(i, j)] / values[i])))
    }

    /// The variables that the residuals do not determine: such without any effect, and such whose effects are those of others, too. Their names are those of
    /// the problem ([`Problem::variable_name`](super::Problem::variable_name)); with one of them fixed, or more residuals, the others may have standard errors.
    pub fn undetermined(&self) -> Vec<usize> {
        let (m, n) = self.jacobian.shape();
        if m == 0 || n == 0 {
            return (0..n).collect();
        }
        let (values, v, _) = self.directions();
        let is_seen = |k: usize| values[k] > SINGULAR * values.amax();
        let seen = |i: usize| (0..values.len()).filter(|&k| is_seen(k)).map(|k| v[(k, i)].powi(2)).sum::<f64>();
        (0..n).filter(|&i| 1.0 - seen(i) > UNSEEN).collect()
    }

    /// Singular values and vᵀ of the Jacobian with columns of length 1, and their lengths: AᵀA would square the condition, and units are no condition.
    fn directions(&self) -> (DVector<f64>, DMatrix<f64>, Vec<f64>) {
        let lengths: Vec<f64> = self.jacobian.column_iter().map(|column| norm(column.as_slice())).collect();
        let mut jacobian = self.jacobian.clone();
        jacobian.column_iter_mut().zip(&lengths).for_each(|(mut column, length)| column /= length.max(f64::MIN_POSITIVE));
        let svd = jacobian.svd(false, true);
        (svd.singular_values, svd.v_t.unwrap_or_default(), lengths)
    }

    /// The standard errors of the variables: roots of the diagonal of the covariance.
    pub fn standard_errors(&self) -> Option<Vec<f64>> {
        self.root().map(|root| root.column_iter().map(|column| norm(column.as_slice())).collect())
    }
}
