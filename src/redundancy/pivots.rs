//! Independent rows and columns of a matrix.

use nalgebra::DMatrix;

/// Entries below this fraction of the largest entry of the matrix are zero.
const ZERO: f64 = 1e-10;

/// Rows and columns of a regular part of a matrix that is as large as its rank, by elimination with complete pivoting.
pub(crate) fn pivots(mut matrix: DMatrix<f64>) -> Vec<[usize; 2]> {
    let (least, mut found) = (ZERO * matrix.amax(), Vec::new());
    if matrix.is_empty() || !least.is_finite() {
        return found;
    }
    loop {
        let (row, column) = matrix.iamax_full();
        let pivot = matrix[(row, column)];
        if pivot.abs() <= least || pivot == 0.0 {
            return found;
        }
        found.push([row, column]);
        let (of_column, of_row) = (matrix.column(column) / pivot, matrix.row(row).into_owned());
        matrix -= of_column * of_row;
        matrix.fill_row(row, 0.0);
        matrix.fill_column(column, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_part_has_the_rank_of_the_matrix() {
        let matrix = DMatrix::from_row_slice(4, 3, &[1.0, 2.0, 0.0, 2.0, 4.0, 0.0, 0.0, 1.0, 5.0, 1.0, 3.0, 5.0]);
        let found = pivots(matrix.clone());
        assert_eq!(found.len(), 2);
        let part = DMatrix::from_fn(2, 2, |i, j| matrix[(found[i][0], found[j][1])]);
        assert!(part.determinant().abs() > 1.0);
        assert!(pivots(DMatrix::zeros(2, 2)).is_empty() && pivots(DMatrix::zeros(0, 2)).is_empty());
    }
}
