//! [`Sizes`]: checks of the lengths of vectors and matrices.

use nalgebra::DMatrix;

use crate::Error;
use crate::motion::check_size;

/// The numbers of variables and of constraints.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    pub(super) variables: usize,
    pub(super) constraints: usize,
}

impl Sizes {
    /// # Errors
    /// A wrong number of variables.
    pub(super) fn point(self, x: &[f64]) -> Result<(), Error> {
        check_size("the variables of a point", self.variables, x.len())
    }

    /// # Errors
    /// A wrong number of variables or constraints.
    pub(super) fn values(self, x: &[f64], c: &[f64]) -> Result<(), Error> {
        self.point(x)?;
        check_size("the values of constraints", self.constraints, c.len())
    }

    /// # Errors
    /// A wrong number of weights or derivatives.
    pub(super) fn gradient(self, c_weights: &[f64], gradient: &[f64]) -> Result<(), Error> {
        check_size("the weights of constraints", self.constraints, c_weights.len())?;
        check_size("the gradient, one entry for each variable", self.variables, gradient.len())
    }

    /// # Errors
    /// Rows that do not exist, or a matrix of wrong shape.
    pub(super) fn jacobian(self, rows: &[usize], jacobian: &DMatrix<f64>) -> Result<(), Error> {
        if let Some(row) = rows.iter().find(|row| **row >= self.constraints) {
            let (what, must_be) = ("a row of the Jacobian".to_string(), "less than the number of constraints");
            return Err(Error::Parameter { what, value: *row as f64, must_be });
        }
        check_size("the rows of the Jacobian, one for each given row number", rows.len(), jacobian.nrows())?;
        check_size("the columns of the Jacobian, one for each variable", self.variables, jacobian.ncols())
    }

    /// # Errors
    /// A wrong number of variables or constraints.
    pub(super) fn push_forward(self, direction: &[f64], change: &[f64]) -> Result<(), Error> {
        check_size("the direction, one entry for each variable", self.variables, direction.len())?;
        check_size("the changes of constraints", self.constraints, change.len())
    }

    /// # Errors
    /// A wrong number of variables.
    pub(super) fn product(self, direction: &[f64], product: &[f64]) -> Result<(), Error> {
        check_size("the direction, one entry for each variable", self.variables, direction.len())?;
        check_size("the product, one entry for each variable", self.variables, product.len())
    }
}
