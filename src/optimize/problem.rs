//! [`Problem`]: what can be minimised.

use nalgebra::DMatrix;

use crate::{Error, Warning};

/// Bounds closer than this share of them are one: a hundredth of what is between them would be lost in rounding.
const NO_ROOM: f64 = 100.0 * f64::EPSILON;

/// The least and the greatest value that something may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// −∞ if there is none.
    pub least: f64,
    /// ∞ if there is none.
    pub most: f64,
}

impl Interval {
    /// Any value.
    pub const FREE: Interval = Interval { least: f64::NEG_INFINITY, most: f64::INFINITY };
    /// Equal to zero.
    pub const ZERO: Interval = Interval { least: 0.0, most: 0.0 };

    /// Equal to a value.
    pub const fn equal(value: f64) -> Self {
        Interval { least: value, most: value }
    }

    /// From `least` to `most`.
    pub const fn new(least: f64, most: f64) -> Self {
        Interval { least, most }
    }

    /// At most so much.
    pub const fn at_most(most: f64) -> Self {
        Interval { most, ..Interval::FREE }
    }

    /// At least so much.
    pub const fn at_least(least: f64) -> Self {
        Interval { least, ..Interval::FREE }
    }

    /// The value in it that is nearest to x.
    pub fn nearest(&self, x: f64) -> f64 {
        // Not `clamp`, which panics where the bounds are none.
        x.max(self.least).min(self.most)
    }

    /// x less the value in it that is nearest: what is to be taken back of it.
    pub fn excess(&self, x: f64) -> f64 {
        x - self.nearest(x)
    }

    /// How far x is outside.
    pub fn violation(&self, x: f64) -> f64 {
        self.excess(x).abs()
    }

    /// Whether rounding leaves no room between the bounds.
    pub(super) fn is_equality(&self) -> bool {
        self.most <= self.least + NO_ROOM * self.least.abs()
    }

    /// The bound at which x is held where a function is to fall whose derivative is g, if it is.
    pub(super) fn holds(&self, x: f64, g: f64) -> Option<f64> {
        match x {
            _ if x <= self.least && g > 0.0 => Some(self.least),
            _ if x >= self.most && g < 0.0 => Some(self.most),
            _ => None,
        }
    }

    /// # Errors
    /// Bounds that no value is between, or that are no numbers.
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
            let what = format!("the upper bound of {}, whose lower one is {least},", what());
            return refused(what, most, "no less than that");
        }
        Ok(())
    }
}

/// minimise f(x) subject to l ≤ x ≤ u and l_c ≤ c(x) ≤ u_c.
///
/// Any optimiser can be put on it, and any problem below the methods of this module:
///
/// ```
/// use hamiltonian_adjoint::Error;
/// use hamiltonian_adjoint::optimize::{Interval, Options, Problem, augmented_lagrangian, silent};
///
/// /// The point of the line x + y = 2 that is nearest to (3, 0).
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

    /// What the constraints, or residuals, c(x) must be; none unless it says so.
    fn constraints(&self) -> Vec<Interval> {
        Vec::new()
    }

    /// What a variable is called in messages.
    fn variable_name(&self, i: usize) -> String {
        format!("x{i}")
    }

    /// What a constraint is called in messages, with what it is.
    fn constraint_name(&self, j: usize) -> String {
        format!("constraint {j}")
    }

    /// f(x), and c(x) into `c`.
    ///
    /// # Errors
    /// A point that has no value, such as a motion that cannot be computed: methods take it for one with an infinite value, and go on.
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error>;

    /// What the last evaluation has to say although x has a value, such as that steps were halved; nothing unless it says so.
    fn warnings(&self) -> Vec<Warning> {
        Vec::new()
    }

    /// Whether steps were halved at the last evaluation.
    fn is_halved(&self) -> bool {
        self.warnings().iter().any(|warning| matches!(warning, Warning::HalvedSteps { .. }))
    }

    /// The gradient of f_weight f(x) + c_weightsᵀ c(x) at the x that was evaluated last.
    ///
    /// # Errors
    /// A point that has no gradient.
    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error>;

    /// These rows of ∂c/∂x at the x that was evaluated last, one below the other; a gradient must be asked for again before a product.
    ///
    /// # Errors
    /// Those of [`gradient`](Self::gradient).
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

    /// Work of the Jacobian of these constraints row by row, and column by column by [`push_forward`](Self::push_forward), in any common unit: methods
    /// use what costs less. Default: the number of rows, and that of variables.
    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        [rows.len(), self.variables()]
    }

    /// What c(x) changes by along a direction, at the x that was evaluated last.
    ///
    /// # Errors
    /// [`Error::NoSecondDerivatives`] where there is no such thing, and then of gradients.
    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        let _ = (direction, change);
        Err(Error::NoSecondDerivatives { of: "this problem, which does not implement `Problem::push_forward`".into() })
    }

    /// Jᵀ J d of the residuals c(x) with Jacobian J, at the x that was evaluated last: the Hessian of ½ ‖c‖² without the curvature of c (Gauss and
    /// Newton). Afterwards the gradient that was asked for last is Jᵀ (J d).
    ///
    /// # Errors
    /// Those of [`push_forward`](Self::push_forward) and [`gradient`](Self::gradient).
    fn gauss_newton_product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let mut change = vec![0.0; self.constraints().len()];
        self.push_forward(direction, &mut change)?;
        self.gradient(0.0, &change, product)
    }

    /// The Hessian of the function whose gradient was asked for last, at the same x, times a direction; only [`interior_point`](super::interior_point())
    /// asks for it.
    ///
    /// # Errors
    /// A problem without second derivatives, which is any that does not say how they are computed.
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let _ = (direction, product);
        Err(Error::NoSecondDerivatives { of: "this problem, which does not implement `Problem::product`".into() })
    }
}

pub(super) fn set_row(matrix: &mut DMatrix<f64>, k: usize, row: &[f64]) {
    matrix.row_mut(k).iter_mut().zip(row).for_each(|(a, x)| *a = *x);
}
