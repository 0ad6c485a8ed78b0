//! Types in which a hand-derived block may be given.

use nalgebra::{DMatrix, Dim, RawStorage};

/// A matrix given as an array of rows, a nalgebra matrix or vector, a list, or a number.
pub trait Matrix {
    /// The matrix as a nalgebra matrix.
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

impl<R: Dim, C: Dim, S: RawStorage<f64, R, C>> Matrix for nalgebra::Matrix<f64, R, C, S> {
    fn dense(self) -> DMatrix<f64> {
        DMatrix::from_iterator(self.nrows(), self.ncols(), self.iter().copied())
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

/// The matrix, transposed if a row is expected and a column was given or vice versa.
pub(crate) fn fitting(matrix: DMatrix<f64>, rows: usize, columns: usize) -> DMatrix<f64> {
    let turned = matrix.shape() == (columns, rows) && (rows == 1 || columns == 1);
    if turned { matrix.transpose() } else { matrix }
}
