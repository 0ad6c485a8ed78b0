//! [`Fit`]: the result of a least-squares fit.

use std::fmt;

use nalgebra::{DMatrix, DVector, Dyn, SVD};

use super::chi_squared::tails;
use super::norm::norm;
use super::outcome::significant;
use super::{Outcome, Reason};
use crate::Warning;

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
    /// Estimated errors of these residuals that the grid causes: residuals of the continuous motion minus r, from the motion with halved steps. `None`
    /// if they are not known ([`Problem::grid_errors`](super::Problem::grid_errors)): for composed grids, for [`MultipleShooting`](super::MultipleShooting), if
    /// there is no motion with halved steps, or if there are not more residuals than variables.
    pub grid_errors: Option<DVector<f64>>,
}

/// The reason and the counts of the outcome, χ² with its degrees of freedom, and the root mean square of the residuals.
impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [chi, mean] = [self.chi_squared(), self.root_mean_square()].map(|x| significant(x, 4));
        let freedom = self.degrees_of_freedom();
        let degrees = if freedom == 1 { "degree" } else { "degrees" };
        self.outcome
            .describe(f, &format!("χ² {chi} with {freedom} {degrees} of freedom, root mean square of residuals {mean}"))
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

    /// Covariance of the variables, s² (AᵀA)⁻¹ + δ δᵀ with s² = ‖r‖²/(residuals − variables), if the residuals are noise of one variance and the grid
    /// shifts the variables by δ ([`grid_shifts`](Self::grid_shifts); 0 if they are not known). Variables at bounds count as free.
    ///
    /// `None` if there are not more residuals than variables, or if the residuals do not determine all variables
    /// ([`undetermined`](Self::undetermined)).
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        self.root(self.scatter()?).map(|root| root.tr_mul(&root))
    }

    /// s = ‖r‖/√(residuals − variables), the standard deviation of the residuals; `None` if there are not more residuals than variables.
    fn scatter(&self) -> Option<f64> {
        let freedom = Some(self.degrees_of_freedom()).filter(|freedom| *freedom > 0)?;
        Some((self.chi_squared() / freedom as f64).sqrt())
    }

    /// Estimated changes of the variables if the steps became infinitely short: −(AᵀA)⁻¹Aᵀe, a Gauss–Newton step with the
    /// [`grid_errors`](Self::grid_errors) e. The variables plus these changes are those of the continuous motion, with an error of higher order.
    ///
    /// `None` if the errors of the grid are not known, or if the residuals do not determine all variables.
    pub fn grid_shifts(&self) -> Option<Vec<f64>> {
        let errors = self.grid_errors.as_ref()?;
        let (svd, lengths) = self.determined()?;
        let step = svd.solve(errors, 0.0).ok()?;
        Some(step.iter().zip(&lengths).map(|(step, length)| -step / length).collect())
    }

    /// A matrix R with the covariance RᵀR for residuals of a standard deviation; the lengths of its columns are the standard errors.
    fn root(&self, deviation: f64) -> Option<DMatrix<f64>> {
        let root = self.root_of_noise(deviation)?;
        Some(match self.grid_shifts() {
            Some(shifts) => DMatrix::from_fn(root.nrows() + 1, root.ncols(), |i, j| *root.get((i, j)).unwrap_or(&shifts[j])),
            None => root,
        })
    }

    /// The part of this matrix that comes from the noise of the residuals.
    fn root_of_noise(&self, deviation: f64) -> Option<DMatrix<f64>> {
        if self.jacobian.ncols() == 0 {
            return Some(DMatrix::zeros(0, 0));
        }
        let (SVD { singular_values: values, v_t, .. }, lengths) = self.determined()?;
        let v = v_t?;
        Some(DMatrix::from_fn(v.nrows(), v.ncols(), |i, j| deviation / lengths[j] * (v[(i, j)] / values[i])))
    }

    /// A warning if the grid shifts variables by more than a share of the standard errors that follow from noise: the one it shifts most.
    pub(super) fn warning(&self, name: impl Fn(usize) -> String) -> Option<Warning> {
        let (shifts, noise) = (self.grid_shifts()?, lengths(&self.root_of_noise(self.scatter()?)?));
        let all = shifts.into_iter().zip(noise).enumerate();
        let (i, (shift, noise)) = all
            .filter(|(_, (shift, noise))| shift.abs() > Warning::GRID_SHIFT * noise)
            .max_by(|(_, (a, of_a)), (_, (b, of_b))| (a / of_a).abs().total_cmp(&(b / of_b).abs()))?;
        Some(Warning::GridShift { variable: name(i), shift, noise })
    }

    /// A warning if χ² of residuals that are those of readings is improbable. Without the estimated errors e of the grid, the residuals are
    /// r + e + A δ; of both sums of squares the more probable one counts.
    pub(super) fn misfit(&self, residuals: &DVector<f64>) -> Option<Warning> {
        let is_minimum = matches!(self.outcome.reason, Reason::Stationary | Reason::NoLowerValue);
        let degrees_of_freedom = Some(self.degrees_of_freedom()).filter(|degrees| is_minimum && *degrees > 0)?;
        let chi_squared = self.chi_squared();
        let of_motion = match (&self.grid_errors, self.grid_shifts()) {
            (Some(errors), Some(shifts)) => (residuals + errors + &self.jacobian * DVector::from_vec(shifts)).norm_squared(),
            _ => chi_squared,
        };
        let [[lower, upper], of_motion] = [chi_squared, of_motion].map(|chi| tails(chi, degrees_of_freedom));
        let probability = lower.max(of_motion[0]).min(upper.max(of_motion[1]));
        (probability < Warning::MISFIT).then_some(Warning::Misfit { chi_squared, degrees_of_freedom, probability })
    }

    /// The variables that the residuals do not determine: those without effect, and those whose effects are linearly dependent.
    /// [`Problem::variable_name`](super::Problem::variable_name) returns their names. If one of them is fixed, or if residuals are added, the
    /// others may have standard errors.
    pub fn undetermined(&self) -> Vec<usize> {
        let (m, n) = self.jacobian.shape();
        if m == 0 || n == 0 {
            return (0..n).collect();
        }
        let (SVD { singular_values: values, v_t, .. }, _) = self.directions();
        let v = v_t.unwrap_or_default();
        let is_seen = |k: usize| values[k] > SINGULAR * values.amax();
        let seen = |i: usize| (0..values.len()).filter(|&k| is_seen(k)).map(|k| v[(k, i)].powi(2)).sum::<f64>();
        (0..n).filter(|&i| 1.0 - seen(i) > UNSEEN).collect()
    }

    /// The Jacobian with columns of length 1, decomposed, and their original lengths. AᵀA would square the condition number.
    fn directions(&self) -> (SVD<f64, Dyn, Dyn>, Vec<f64>) {
        let lengths = lengths(&self.jacobian);
        let mut jacobian = self.jacobian.clone();
        jacobian.column_iter_mut().zip(&lengths).for_each(|(mut column, length)| column /= length.max(f64::MIN_POSITIVE));
        (jacobian.svd(true, true), lengths)
    }

    /// As [`directions`](Self::directions); `None` if the residuals do not determine all variables, or if there are none.
    fn determined(&self) -> Option<(SVD<f64, Dyn, Dyn>, Vec<f64>)> {
        let (m, n) = self.jacobian.shape();
        let found = (0 < n && n <= m).then(|| self.directions())?;
        let values = &found.0.singular_values;
        values.iter().all(|s| *s > SINGULAR * values.amax()).then_some(found)
    }

    /// Standard errors of the variables: square roots of the diagonal of the covariance. They include the shift that the grid causes, and
    /// [`Warning::GridShift`] says where it matters.
    pub fn standard_errors(&self) -> Option<Vec<f64>> {
        self.root(self.scatter()?).map(|root| lengths(&root))
    }

    /// Standard errors of the variables if the standard deviation of every residual is 1, because the weights are 1/σ with the known standard deviations σ
    /// of the readings: √diag((AᵀA)⁻¹ + δ δᵀ). They need only as many residuals as variables, and do not scatter with χ².
    pub fn absolute_errors(&self) -> Option<Vec<f64>> {
        self.root(1.0).map(|root| lengths(&root))
    }
}

/// The lengths of the columns.
fn lengths(of: &DMatrix<f64>) -> Vec<f64> {
    of.column_iter().map(|column| norm(column.as_slice())).collect()
}
