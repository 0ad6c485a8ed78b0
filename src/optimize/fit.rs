//! [`Fit`]: what least squares found.

use std::fmt;

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

/// The outcome, χ² with its degrees of freedom, and the root mean square of the residuals.
impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (chi, freedom, mean) = (self.chi_squared(), self.degrees_of_freedom(), self.root_mean_square());
        write!(f, "{}; χ² {chi:e} with {freedom} degrees of freedom, root mean square of residuals {mean:e}", self.outcome)
    }
}

impl Fit {
    /// χ² = ‖r‖², the sum of squares of the residuals. Where each is divided by the standard deviation of its reading (weight 1/σ), a model that fits has a χ²
    /// of about the [`degrees_of_freedom`](Self::degrees_of_freedom), ± √2 times their root; a much larger one tells that the model, or a local minimum, does
    /// not explain the readings.
    pub fn chi_squared(&self) -> f64 {
        2.0 * self.outcome.value
    }

    /// The number of residuals less that of variables; 0 if there are more variables.
    pub fn degrees_of_freedom(&self) -> usize {
        self.jacobian.nrows().saturating_sub(self.jacobian.ncols())
    }

    /// The root mean square of all residuals: of readings divided by their standard deviations about 1 if the model fits.
    pub fn root_mean_square(&self) -> f64 {
        (self.chi_squared() / self.jacobian.nrows() as f64).sqrt()
    }

    /// The root mean square of the residuals of some constraints, by their numbers ([`Output::index`](crate::Output::index)), such as those of one signal.
    ///
    /// # Panics
    /// If there are fewer constraints.
    pub fn root_mean_square_of(&self, constraints: &[usize]) -> f64 {
        // Of least squares the multipliers are the residuals.
        let residuals = Vec::from_iter(constraints.iter().map(|&j| self.outcome.multipliers[j]));
        norm(&residuals) / (residuals.len() as f64).sqrt()
    }

    /// s² (AᵀA)⁻¹ with s² = ‖r‖²/(residuals − variables): the covariance of the variables if residuals differ by noise of one size alone. Variables that a
    /// bound holds are taken for free.
    ///
    /// None without more residuals than variables, and if the residuals do not determine all variables ([`undetermined`](Self::undetermined)).
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        self.root().map(|root| root.tr_mul(&root))
    }

    /// Whose square is the covariance, and lengths of whose columns are the standard errors.
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
