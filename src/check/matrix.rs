//! What a hand-derived block may be written as.

use nalgebra::{DMatrix, SMatrix};

/// A matrix in any of the usual ways: rows of an array, a nalgebra matrix or vector, a list, a number.
pub trait Matrix {
    /// The same as a nalgebra matrix.
    fn dense(self) -> DMatrix<f64>;
}

impl<const R: usize, const C: usize> Matrix for [[f64; C]; R] {
    fn dense(self) -> DMatrix<f64> {
        DMatrix::from_fn(R, C, |i, j| self[i][j])
    }
}

impl<const R: usize> Matrix for [f64; R] {
    fn dense(self) -> DMatrix<f64> {
        DMatrix::from_column_slice(R, 1, &self)
    }
}

impl<const R: usize, const C: usize> Matrix for SMatrix<f64, R, C> {
    fn dense(self) -> DMatrix<f64> {
        DMatrix::from_column_slice(R, C, self.as_slice())
    }
}

impl Matrix for DMatrix<f64> {
    fn dense(self) -> DMatrix<f64> {
        self
    }
}

impl Matrix for nalgebra::DVector<f64> {
    fn dense(self) -> DMatrix<f64> {
        DMatrix::from_column_slice(self.len(), 1, self.as_slice())
    }
}

impl Matrix for Vec<f64> {
    fn dense(self) -> DMatrix<f64> {
        DMatrix::from_vec(self.len(), 1, self)
    }
}

impl Matrix for f64 {
    fn dense(self) -> DMatrix<f64> {
        DMatrix::from_element(1, 1, self)
    }
}

/// A gradient written as a column is as good as a row.
pub(crate) fn fitting(matrix: DMatrix<f64>, rows: usize, columns: usize) -> DMatrix<f64> {
    let turned = matrix.shape() == (columns, rows) && (rows == 1 || columns == 1);
    if turned { matrix.transpose() } else { matrix }
}
