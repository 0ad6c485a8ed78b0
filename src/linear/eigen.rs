//! Eigenvalues of small symmetric matrices.

use nalgebra::{DMatrix, Dyn, SymmetricEigen};

/// Eigenvalues of a symmetric matrix whose entries are of order one; `None` if it is empty or not finite.
pub(crate) fn eigen(mut matrix: DMatrix<f64>) -> Option<SymmetricEigen<f64, Dyn>> {
    // nalgebra panics for an empty matrix, and a decomposition that contains NaN is meaningless.
    if matrix.is_empty() || !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    // If squares of entries underflow, the iteration may not terminate.
    matrix.iter_mut().filter(|x| x.abs() < 1e-100).for_each(|x| *x = 0.0);
    let iterations = 100 * matrix.nrows();
    SymmetricEigen::try_new(matrix, f64::EPSILON, iterations)
}
