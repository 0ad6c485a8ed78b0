//! [`Sizes`]: how long what a problem is given must be.

use nalgebra::DMatrix;

use crate::Error;

/// The numbers of variables and of constraints.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    pub(super) variables: usize,
    pub(super) constraints: usize,
}

impl Sizes {
    /// # Errors
    /// Another number of variables.
    pub(super) fn point(self, x: &[f64]) -> Result<(), Error> {
        check("the variables of a point", x.len(), self.variables)
    }

    /// # Errors
    /// Other numbers of variables or constraints.
    pub(super) fn values(self, x: &[f64], c: &[f64]) -> Result<(), Error> {
        self.point(x)?;
        check("the values of constraints", c.len(), self.constraints)
    }

    /// # Errors
    /// Other numbers of weights or derivatives.
    pub(super) fn gradient(self, c_weights: &[f64], gradient: &[f64]) -> Result<(), Error> {
        check("the weights of constraints", c_weights.len(), self.constraints)?;
        check("the gradient, of an entry for each variable", gradient.len(), self.variables)
    }

    /// # Errors
    /// Rows that there are not, a matrix of another shape.
    pub(super) fn jacobian(self, rows: &[usize], jacobian: &DMatrix<f64>) -> Result<(), Error> {
        if let Some(row) = rows.iter().find(|row| **row >= self.constraints) {
            let (what, must_be) = ("a row of the Jacobian".to_string(), "less than the number of constraints");
            return Err(Error::Parameter { what, value: *row as f64, must_be });
        }
        check("the rows of the Jacobian, one for each that is asked for", jacobian.nrows(), rows.len())?;
        check("the columns of the Jacobian, one for each variable", jacobian.ncols(), self.variables)
    }

    /// # Errors
    /// Other numbers of variables or constraints.
    pub(super) fn push_forward(self, direction: &[f64], change: &[f64]) -> Result<(), Error> {
        check("the direction, of an entry for each variable", direction.len(), self.variables)?;
        check("the changes of constraints", change.len(), self.constraints)
    }

    /// # Errors
    /// Another number of variables.
    pub(super) fn product(self, direction: &[f64], product: &[f64]) -> Result<(), Error> {
        check("the direction, of an entry for each variable", direction.len(), self.variables)?;
        check("the product, of an entry for each variable", product.len(), self.variables)
    }
}

pub(super) fn check(what: &'static str, found: usize, expected: usize) -> Result<(), Error> {
    if found == expected { Ok(()) } else { Err(Error::Size { what, expected, found }) }
}
