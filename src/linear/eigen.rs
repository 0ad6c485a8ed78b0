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

/// Shifts of a matrix relative to its size. Unshifted, small eigenvalues are the most accurate. But the entries that QR iterations set to zero are compared
/// with those of the diagonal, which are zero for masses that move freely; then the iterations converge only with a shift.
const SHIFTS: [f64; 4] = [0.0, 1.0, 0.37, 0.11];

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
    let (size, iterations) = (matrix.norm(), 100 * matrix.nrows());
    let mut found = SHIFTS.iter().find_map(|share| {
        let shift = share * size;
        let shifted = &matrix + DMatrix::from_diagonal_element(matrix.nrows(), matrix.ncols(), shift);
        let schur = Schur::try_new(shifted, f64::EPSILON, iterations)?;
        Some(schur.complex_eigenvalues().iter().map(|s| s - shift).collect::<Vec<_>>())
    })?;
    found.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    found.iter().all(|s| s.re.is_finite() && s.im.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Random;

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

    #[test]
    fn masses_with_few_springs_have_eigenvalues() {
        let mut random = Random::new(1);
        for case in 0..1000 {
            let n = 1 + case % 6;
            let mut a = DMatrix::zeros(2 * n, 2 * n);
            (0..n).for_each(|i| a[(i, n + i)] = 1.0);
            let pairs: Vec<[usize; 2]> = (0..n).flat_map(|i| (0..i).map(move |j| [i, j])).collect();
            for [i, j] in pairs {
                if random.uniform(0.0, 1.0) > 0.4 {
                    continue;
                }
                let damping = random.uniform(-1.0, 1.0).max(0.0);
                for (x, first) in [(random.uniform(0.0, 100.0), 0), (damping, n)] {
                    for (row, column, sign) in [(i, i, -1.0), (j, j, -1.0), (i, j, 1.0), (j, i, 1.0)] {
                        a[(n + row, first + column)] += sign * x;
                    }
                }
            }
            let (trace, size) = (a.trace(), a.norm());
            let found = eigenvalues(a).unwrap_or_else(|| panic!("{case}"));
            let sum: Complex<f64> = found.iter().sum();
            assert!((sum - trace).norm() < 1e-10 * size && found[0].re < 1e-4 * size, "{case}: {found:?}");
        }
    }
}
