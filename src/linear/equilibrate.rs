//! Scaling of the rows and columns of a matrix, so that ranks do not depend on the units of its entries.

use nalgebra::DMatrix;

/// The number of alternations between rows and columns; the influence of the units decreases rapidly with each.
const TURNS: usize = 12;

/// Divides rows and columns alternately by their norms until all norms are about 1.
///
/// At convergence, the result is the same for R A C with any diagonal R and C, that is, for any units of rows and columns.
pub(crate) fn equilibrate(matrix: &mut DMatrix<f64>) {
    for _ in 0..TURNS {
        for mut row in matrix.row_iter_mut() {
            let norm = row.norm();
            if norm > 0.0 {
                row /= norm;
            }
        }
        for mut column in matrix.column_iter_mut() {
            let norm = column.norm();
            if norm > 0.0 {
                column /= norm;
            }
        }
    }
}
