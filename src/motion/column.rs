//! Columns of matrices as slices.

use nalgebra::DMatrix;

/// Column `i` as a slice.
pub(crate) fn column<R>(matrix: &DMatrix<R>, i: usize) -> &[R] {
    let rows = matrix.nrows();
    &matrix.as_slice()[i * rows..][..rows]
}

/// Column `i` as a slice, to be written.
pub(crate) fn column_mut<R>(matrix: &mut DMatrix<R>, i: usize) -> &mut [R] {
    let rows = matrix.nrows();
    &mut matrix.as_mut_slice()[i * rows..][..rows]
}
