//! [`Fit`]: the result of a least-squares fit.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use super::Outcome;
use super::norm::norm;

/// Singular values below this fraction of the largest are zero. A variable is undetermined if its squared component along them exceeds `UNSEEN`.
const SINGULAR: f64 = 1e-13;
const UNSEEN: f64 = 1e-6;

/// Result of a fit, with the accuracy of its variables.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The outcome; its value is ½‖r‖².
    pub outcome: Outcome,
    /// The Jacobian ∂r/∂x at the solution, for the residuals that are not free.
    pub jacobian: DMatrix<f64>,
}

/// The outcome, χ² with its degrees of freedom, and the root mean square of the residuals.
impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (chi, freedom, mean) = (self.chi_squared(), self.degrees_of_freedom(), self.root_mean_square());
        write!(f, "{}; χ² {chi:e} with {freedom} degrees of freedom, root mean square of residuals {mean:e}", self.outcome)
    }
}

impl Fit {
    /// χ² = ‖r‖², the sum of squares of the residuals. With weights 1/σ, where σ is the standard deviation of a reading, χ² of a correct
    /// model is about the number of [`degrees_of_freedom`](Self::degrees_of_freedom), with a standard deviation of √2 times the square root
    /// of this number; a much larger value indicates a wrong model or a local minimum.
    pub fn chi_squared(&self) -> f64 {
        2.0 * self.outcome.value
    }

    /// The number of residuals minus that of variables; 0 if there are more variables.
    pub fn degrees_of_freedom(&self) -> usize {
        self.jacobian.nrows().saturating_sub(self.jacobian.ncols())
    }

    /// The root mean square of all residuals: about 1 for a correct model with weights 1/σ.
    pub fn root_mean_square(&self) -> f64 {
        (self.chi_squared() / self.jacobian.nrows() as f64).sqrt()
    }

    /// The root mean square of the residuals of some outputs, given by their indices ([`Output::index`](crate::Output::index)), for example
    /// those of one sensor.
    ///
    /// # Panics
    /// If an index is too large.
    pub fn root_mean_square_of(&self, constraints: &[usize]) -> f64 {
        // For least squares the multipliers are the residuals.
        let residuals = Vec::from_iter(constraints.iter().map(|&j| self.outcome.multipliers[j]));
        norm(&residuals) / (residuals.len() as f64).sqrt()
    }

    /// Covariance of the variables, s² (AᵀA)⁻¹ with s² = ‖r‖²/(residuals − variables), if the residuals are noise of one variance.
    /// Variables at bounds count as free.
    ///
    /// `None` if there are not more residuals than variables, or if the residuals do not determine all variables
    /// ([`undetermined`](Self::undetermined)).
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        self.root().map(|root| root.tr_mul(&root))
    }

    /// A matrix R with the covariance RᵀR; the lengths of its columns are the standard errors.
    fn root(&self) -> Option<DMatrix<f64>> {
        let freedom = Some(self.degrees_of_freedom()).filter(|freedom| *freedom > 0)?;
        if self.jacobian.ncols() == 0 {
            return Some(DMatrix::zeros(0, 0));
        }
        let (values, v, lengths) = self.directions();
        if values.iter().any(|s| *s <= SINGULAR * values.amax()) {
            return None;
        }
        let deviation = (self.chi_squared() / freedom as f64).sqrt();
        Some(DMatrix::from_fn(v.nrows(), v.ncols(), |i, j| deviation / lengths[j] * (v[(i, j)] / values[i])))
    }

    /// The variables that the residuals do not determine: those without effect, and those whose effects are linearly dependent.
    /// [`Problem::variable_name`](super::Problem::variable_name) returns their names. If one of them is fixed, or if residuals are added, the
    /// others may have standard errors.
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

    /// Singular values and Vᵀ of the Jacobian with columns of length 1, and their original lengths. AᵀA would square the condition number.
    fn directions(&self) -> (DVector<f64>, DMatrix<f64>, Vec<f64>) {
        let lengths: Vec<f64> = self.jacobian.column_iter().map(|column| norm(column.as_slice())).collect();
        let mut jacobian = self.jacobian.clone();
        jacobian.column_iter_mut().zip(&lengths).for_each(|(mut column, length)| column /= length.max(f64::MIN_POSITIVE));
        let svd = jacobian.svd(false, true);
        (svd.singular_values, svd.v_t.unwrap_or_default(), lengths)
    }

    /// Standard errors of the variables: square roots of the diagonal of the covariance.
    pub fn standard_errors(&self) -> Option<Vec<f64>> {
        self.root().map(|root| root.column_iter().map(|column| norm(column.as_slice())).collect())
    }
}
