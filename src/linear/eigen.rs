//! Eigenvalues of small symmetric matrices.

use nalgebra::{DMatrix, Dyn, SymmetricEigen};

/// Of a symmetric matrix of entries about one, unless it is empty or not finite.
pub(crate) fn eigen(mut matrix: DMatrix<f64>) -> Option<SymmetricEigen<f64, Dyn>> {
    // nalgebra panics at an empty matrix, and the decomposition of a NaN means nothing.
    if matrix.is_empty() || !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    // Entries whose squares underflow may keep its iteration from ending.
    matrix.iter_mut().filter(|x| x.abs() < 1e-100).for_each(|x| *x = 0.0);
    let iterations = 100 * matrix.nrows();
    SymmetricEigen::try_new(matrix, f64::EPSILON, iterations)
}
