//! Rows of Φ_q that vanish up to rounding: no velocity changes the distance of two points from a plane in which both move.

use super::formula::Entry;

/// An entry is rounding below this fraction of the largest in its column, and so is a column below this number.
const ROUNDING: f64 = 1e-12;

/// Sets the entries of rows to zero that consist of rounding, in a matrix with n columns and m rows. A row with NaN is kept.
pub(super) fn clear_rounding_rows(entries: &mut [Entry], (n, m): (usize, usize)) {
    let (mut largest, mut is_rounding) = (vec![0.0f64; n], vec![true; m]);
    entries.iter().for_each(|e| largest[e.col] = largest[e.col].max(e.value.abs()));
    largest.iter_mut().filter(|largest| **largest <= ROUNDING).for_each(|largest| *largest = 1.0);
    entries.iter().for_each(|e| is_rounding[e.row] &= e.value.abs() <= ROUNDING * largest[e.col]);
    entries.iter_mut().filter(|e| is_rounding[e.row]).for_each(|e| e.value = 0.0);
}
