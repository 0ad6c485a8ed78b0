//! Scaling rows and columns of a matrix, so that ranks do not depend on the units of its entries.

use nalgebra::DMatrix;

/// How often rows and columns take turns; each turn roughly squares what is left of the units.
const TURNS: usize = 12;

/// Divides rows and columns by their norms in turns until all are about 1.
///
/// The result is the same for R A C with any diagonal R and C, so whatever the units of rows and columns are.
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
