//! [`Problem`]: an optimisation problem.

use nalgebra::DMatrix;

use crate::{Error, Warning};

/// Bounds closer than this relative distance count as an equality: a hundredth of the distance between them would be lost to rounding.
const NO_ROOM: f64 = 100.0 * f64::EPSILON;

/// An interval of allowed values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower bound; −∞ if there is none.
    pub least: f64,
    /// Upper bound; ∞ if there is none.
    pub most: f64,
}

impl Interval {
    /// The interval of all values.
    pub const FREE: Interval = Interval { least: f64::NEG_INFINITY, most: f64::INFINITY };
    /// The interval that contains only zero.
    pub const ZERO: Interval = Interval { least: 0.0, most: 0.0 };

    /// The interval that contains only this value.
    pub const fn equal(value: f64) -> Self {
        Interval { least: value, most: value }
    }

    /// The interval from `least` to `most`.
    pub const fn new(least: f64, most: f64) -> Self {
        Interval { least, most }
    }

    /// The interval of values up to `most`.
    pub const fn at_most(most: f64) -> Self {
        Interval { most, ..Interval::FREE }
    }

    /// The interval of values from `least` on.
    pub const fn at_least(least: f64) -> Self {
        Interval { least, ..Interval::FREE }
    }

    /// Returns the number in the interval that is nearest to x.
    pub fn nearest(&self, x: f64) -> f64 {
        // Not `clamp`, which panics if the bounds are NaN or in the wrong order.
        x.max(self.least).min(self.most)
    }

    /// The signed distance of x from the interval: x minus the nearest value of the interval.
    pub fn excess(&self, x: f64) -> f64 {
        x - self.nearest(x)
    }

    /// The distance of x from the interval.
    pub fn violation(&self, x: f64) -> f64 {
        self.excess(x).abs()
    }

    /// True if rounding leaves no room between the bounds.
    pub(super) fn is_equality(&self) -> bool {
        self.most <= self.least + NO_ROOM * self.least.abs()
    }

    /// The bound at which x is held if a function with the derivative g is minimised; `None` if x can move.
    pub(super) fn holds(&self, x: f64, g: f64) -> Option<f64> {
        match x {
            _ if x <= self.least && g > 0.0 => Some(self.least),
            _ if x >= self.most && g < 0.0 => Some(self.most),
            _ => None,
        }
    }

    /// # Errors
    /// Bounds that exclude every value, or that are NaN.
    pub(super) fn check(&self, what: impl Fn() -> String) -> Result<(), Error> {
        let Interval { least, most } = *self;
        let refused = |what, value, must_be| Err(Error::Parameter { what, value, must_be });
        if least.is_nan() || least == f64::INFINITY {
            return refused(format!("the lower bound of {}", what()), least, "a number, or -inf for none");
        }
        if most.is_nan() || most == f64::NEG_INFINITY {
            return refused(format!("the upper bound of {}", what()), most, "a number, or inf for none");
        }
        if least > most {
            let what = format!("the upper bound of {}, whose lower bound is {least},", what());
            return refused(what, most, "at least the lower bound");
        }
        Ok(())
    }
}

/// The largest distance of c from its intervals.
pub(super) fn largest_violation(intervals: &[Interval], c: &[f64]) -> f64 {
    intervals.iter().zip(c).fold(0.0, |most: f64, (of, c)| most.max(of.violation(*c)))
}

/// An optimisation problem: minimise f(x) subject to l ≤ x ≤ u and l_c ≤ c(x) ≤ u_c.
///
/// It can be solved by the methods of this module or by any other optimiser:
///
/// ```
/// use hamiltonian_adjoint::Error;
/// use hamiltonian_adjoint::optimize::{Interval, Options, Problem, augmented_lagrangian, silent};
///
/// /// The point on the line x + y = 2 that is nearest to (3, 0).
/// struct Nearest([f64; 2]);
/// impl Problem for Nearest {
///     fn variables(&self) -> usize {
///         2
///     }
///     fn constraints(&self) -> Vec<Interval> {
///         vec![Interval::ZERO]
///     }
///     fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
///         self.0.copy_from_slice(x);
///         c[0] = x[0] + x[1] - 2.0;
///         Ok((x[0] - 3.0).powi(2) + x[1] * x[1])
///     }
///     fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
///         let [x, y] = self.0;
///         gradient[0] = f * 2.0 * (x - 3.0) + c[0];
///         gradient[1] = f * 2.0 * y + c[0];
///         Ok(())
///     }
/// }
///
/// let outcome = augmented_lagrangian(&mut Nearest([0.0; 2]), &[0.0, 0.0], &Options::default(), &mut silent)?;
/// assert!((outcome.x[0] - 2.5).abs() < 1e-7 && (outcome.multipliers[0] - 1.0).abs() < 1e-6);
/// # Ok::<(), Error>(())
/// ```
pub trait Problem {
    /// The number of variables x.
    fn variables(&self) -> usize;

    /// The bounds l ≤ x ≤ u, one interval for each variable.
    fn bounds(&self) -> Vec<Interval> {
        vec![Interval::FREE; self.variables()]
    }

    /// Intervals of the constraints, or residuals, c(x). Default: none.
    fn constraints(&self) -> Vec<Interval> {
        Vec::new()
    }

    /// Name of a variable in messages.
    fn variable_name(&self, i: usize) -> String {
        format!("x{i}")
    }

    /// Name of a constraint in messages, with its kind.
    fn constraint_name(&self, j: usize) -> String {
        format!("constraint {j}")
    }

    /// True if constraint j is the deviation of a motion from a reading, divided by the known standard deviation of the reading.
    /// [`levenberg_marquardt`](super::levenberg_marquardt) tests the sum of squares of such residuals ([`Warning::Misfit`]). Default: false.
    fn is_reading(&self, j: usize) -> bool {
        let _ = j;
        false
    }

    /// Computes f(x), and c(x) into `c`.
    ///
    /// # Errors
    /// A point without a value, for example a motion that cannot be computed. Methods treat its value as infinite and continue.
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error>;

    /// Warnings of the last successful evaluation, for example halved steps. Default: none.
    fn warnings(&self) -> Vec<Warning> {
        Vec::new()
    }

    /// True if steps were halved in the last evaluation.
    fn is_halved(&self) -> bool {
        self.warnings().iter().any(|warning| matches!(warning, Warning::HalvedSteps { .. }))
    }

    /// The gradient of f_weight f(x) + c_weightsᵀ c(x) at the last evaluated x.
    ///
    /// # Errors
    /// A point without a gradient.
    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error>;

    /// The given rows of ∂c/∂x at the last evaluated x. Compute a gradient again before the next product.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        let (mut weights, mut row) = (vec![0.0; self.constraints().len()], vec![0.0; self.variables()]);
        for (k, &j) in rows.iter().enumerate() {
            weights[j] = 1.0;
            self.gradient(0.0, &weights, &mut row)?;
            weights[j] = 0.0;
            set_row(jacobian, k, &row);
        }
        Ok(())
    }

    /// Work of computing the Jacobian of these constraints row by row, and column by column with [`push_forward`](Self::push_forward), in a
    /// common unit; methods choose the way with less work. Default: the numbers of rows and of variables.
    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        [rows.len(), self.variables()]
    }

    /// The derivative of c(x) along a direction at the last evaluated x.
    ///
    /// # Errors
    /// [`Error::NoSecondDerivatives`] if the problem does not provide it; the Jacobian is then computed from gradients.
    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        let _ = (direction, change);
        Err(Error::NoSecondDerivatives { of: "this problem, which does not implement `Problem::push_forward`".into() })
    }

    /// The Gauss–Newton product Jᵀ J d at the last evaluated x, with the Jacobian J of the residuals c(x). This call replaces the gradient
    /// that was computed last by Jᵀ (J d).
    ///
    /// # Errors
    /// As [`push_forward`](Self::push_forward) and [`gradient`](Self::gradient).
    fn gauss_newton_product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let mut change = vec![0.0; self.constraints().len()];
        self.push_forward(direction, &mut change)?;
        self.gradient(0.0, &change, product)
    }

    /// Estimated errors of c(x) at the last evaluated x that a discretisation causes: c of the continuous problem minus c.
    /// [`levenberg_marquardt`](super::levenberg_marquardt) includes them in standard errors. Default: `None`, not known.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    fn grid_errors(&self) -> Result<Option<Vec<f64>>, Error> {
        Ok(None)
    }

    /// The Hessian of the function whose gradient was computed last, at the same x, times a direction. Only
    /// [`interior_point`](super::interior_point()) uses it.
    ///
    /// # Errors
    /// A problem without second derivatives, which is the default.
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let _ = (direction, product);
        Err(Error::NoSecondDerivatives { of: "this problem, which does not implement `Problem::product`".into() })
    }
}

pub(super) fn set_row(matrix: &mut DMatrix<f64>, k: usize, row: &[f64]) {
    matrix.row_mut(k).iter_mut().zip(row).for_each(|(a, x)| *a = *x);
}
