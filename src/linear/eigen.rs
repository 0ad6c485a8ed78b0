//! Eigenvalues of small matrices.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, Dyn, Schur, SymmetricEigen};

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

/// Eigenvalues of a square matrix, those with the largest real parts first; `None` if it is not finite.
pub(crate) fn eigenvalues(mut matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if matrix.is_empty() {
        return Some(Vec::new());
    }
    // Balancing does not end if squares of entries overflow.
    if !matrix.iter().all(|x| x.abs() < 1e100) {
        return None;
    }
    matrix.iter_mut().filter(|x| x.abs() < 1e-100).for_each(|x| *x = 0.0);
    balance_parlett_reinsch(&mut matrix);
    let iterations = 100 * matrix.nrows();
    let mut found = Schur::try_new(matrix, f64::EPSILON, iterations)?.complex_eigenvalues().as_slice().to_vec();
    found.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    found.iter().all(|s| s.re.is_finite() && s.im.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_of_a_badly_scaled_matrix_are_exact() {
        // (s² + 1) (s − 2) with states in units that differ by 1e12.
        let companion = DMatrix::from_row_slice(3, 3, &[0.0, 1e12, 0.0, 0.0, 0.0, 1e-3, 2e-9, -1e3, 2.0]);
        let found = eigenvalues(companion).expect("eigenvalues");
        let expected = [Complex::new(2.0, 0.0), Complex::new(0.0, 1.0), Complex::new(0.0, -1.0)];
        found.iter().zip(&expected).for_each(|(found, expected)| assert!((found - expected).norm() < 1e-13, "{found}"));
        assert_eq!(eigenvalues(DMatrix::zeros(0, 0)), Some(Vec::new()));
        assert_eq!(eigenvalues(DMatrix::from_element(2, 2, f64::NAN)), None);
    }
}
