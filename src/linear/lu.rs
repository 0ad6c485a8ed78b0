//! Dense LU factorisation of one node, with rows interchanged if a pivot loses digits: P D = L U.
//!
//! A pivot is judged by the magnitudes that were added up in it, not by the other entries of its column, which have other units. For the choice of
//! another row, units are inferred from the magnitudes added up in the diagonal entries (see [`choose_row`]).
//!
//! The pivot of a coordinate without inertia is of order h². It lost no digits, but it buries those of the constraints that determine the coordinate.
//! Nodes of fixed size are factorised in order first. If a pivot loses digits or buries those of others, they are factorised again with interchanges.
//! Nodes in which such a pivot leaves no trace choose the best row for every column. Their multipliers come first if these constraints cannot depend on
//! each other; then the best rows are chosen for them alone.
//!
//! D (s×s) is stored by columns and is overwritten by L (unit diagonal not stored) and U, with the
//! reciprocals of the pivots in place of the diagonal of U. All functions are inlined, so that a
//! constant `s` unrolls them. Nodes of other sizes are mostly sparse inside (a body's coordinates beside its own constraints):
//! products with a zero are skipped for these.

use super::eigen::eigen;
use super::products::{minus_dot, subtract};
use super::size::{Fixed, Free, Size};
use crate::number::minus_product;
use nalgebra::DMatrix;
use std::ops::Range;

/// Smallest accepted ratio of a pivot to the magnitudes that were added up in it.
const SMALLEST_PIVOT: f64 = 1e-13;
/// Largest loss of digits (ratio of the magnitudes added up in a pivot to the pivot) that is accepted without interchanging rows.
pub(super) const MOST_LOSS: f64 = 1e4;
/// Stored as the first interchange of a node without interchanges.
pub(super) const IN_ORDER: usize = usize::MAX;

/// When rows are interchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Interchanges {
    /// The first loss of digits is an error.
    Never,
    /// If a pivot loses digits or buries those of others, and in the first columns whenever the best pivot is in another row.
    IfNeeded {
        /// Number of these first columns.
        first: usize,
    },
}

/// A pivot that cancelled: its column in the node, its value and the sum of the magnitudes of its terms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cancelled {
    pub(super) column: usize,
    pub(super) pivot: f64,
    pub(super) scale: f64,
}

/// The matrices and records that a factorisation uses.
pub(super) struct Rows<'a> {
    /// D (s×s) by columns.
    pub(super) d: &'a mut [f64],
    /// Further columns, whose rows are interchanged with those of D.
    pub(super) u: &'a mut [f64],
    /// `swaps[k]` becomes the row that was exchanged with row k at step k.
    pub(super) swaps: &'a mut [usize],
    /// Magnitudes that were added to diagonal entry k before.
    pub(super) scale: &'a [f64],
    pub(super) interchanges: Interchanges,
    /// The steps between the first and the last interchange of rows, both included.
    pub(super) mixed: Range<usize>,
}

/// Factorises D in place and returns the largest ratio of the magnitudes added up in a pivot to the pivot.
///
/// The ratio does not depend on the units of the unknowns as long as rows are not interchanged.
///
/// # Errors
/// The first pivot that is not finite, that is too small compared with its magnitudes, or that loses digits while rows may not be interchanged.
#[inline(always)]
pub(super) fn factor<N: Size>(n: N, rows: &mut Rows<'_>) -> Result<f64, Cancelled> {
    let mut worst = 1.0;
    if N::FIXED {
        fixed_step::<N, 0>(n, rows, &mut worst)?;
        fixed_step::<N, 1>(n, rows, &mut worst)?;
        fixed_step::<N, 2>(n, rows, &mut worst)?;
        fixed_step::<N, 3>(n, rows, &mut worst)?;
        fixed_step::<N, 4>(n, rows, &mut worst)?;
        fixed_step::<N, 5>(n, rows, &mut worst)?;
        fixed_step::<N, 6>(n, rows, &mut worst)?;
        fixed_step::<N, 7>(n, rows, &mut worst)?;
    } else {
        for k in 0..n.get() {
            step(n, Free::new(k), rows, &mut worst)?;
        }
    }
    Ok(worst)
}

/// Performs step K if it exists; the optimiser does not unroll a loop over the steps by itself.
#[inline(always)]
fn fixed_step<N: Size, const K: usize>(n: N, rows: &mut Rows<'_>, worst: &mut f64) -> Result<(), Cancelled> {
    if K < n.get() { step(n, Fixed::<K>, rows, worst) } else { Ok(()) }
}

/// Eliminates column k.
#[inline(always)]
fn step<N: Size, K: Size>(n: N, k: K, rows: &mut Rows<'_>, worst: &mut f64) -> Result<(), Cancelled> {
    let (s, k) = (n.get(), k.get());
    let added = if rows.mixed.is_empty() { rows.scale[k] } else { added_by_others([k, k], rows) };
    let (mut scale, pivot) = (magnitude(s, k, rows, added), rows.d[k * s + k]);
    rows.swaps[k] = k;
    // False for a NaN.
    let keeps_digits = scale < MOST_LOSS * pivot.abs();
    let is_first = match rows.interchanges {
        Interchanges::IfNeeded { first } => k < first,
        Interchanges::Never if keeps_digits && !is_buried(added, scale - pivot.abs()) => false,
        Interchanges::Never => return Err(Cancelled { column: k, pivot, scale }),
    };
    if rows.interchanges != Interchanges::Never && (is_first || !keeps_digits || buries(s, k, rows)) {
        // A multiplier and a coordinate without inertia, which determine each other, have equal measures.
        let row = choose_row(s, k, rows, if is_first { 0.5 } else { 1.0 });
        if row != k {
            let added = added_by_others([row, k], rows);
            swap_rows(s, rows.d, k, row);
            swap_rows(s, rows.u, k, row);
            rows.swaps[k] = row;
            rows.mixed = if rows.mixed.is_empty() { k } else { rows.mixed.start }..k + 1;
            scale = magnitude(s, k, rows, added);
        }
    }
    let pivot = rows.d[k * s + k];
    let inverse = 1.0 / pivot;
    if !rows.mixed.is_empty() {
        scale += inherited(s, k, rows);
    }
    let ratio = scale * inverse.abs();
    if ratio.is_nan() || ratio * SMALLEST_PIVOT >= 1.0 {
        return Err(Cancelled { column: k, pivot, scale });
    }
    if ratio > *worst {
        *worst = ratio;
    }
    let Rows { d, .. } = rows;
    d[k * s + k] = inverse;
    for entry in &mut d[k * s + k + 1..(k + 1) * s] {
        *entry *= inverse;
    }
    let (head, tail) = d.split_at_mut((k + 1) * s);
    let column = &head[k * s..];
    for other in tail.chunks_exact_mut(s) {
        if N::FIXED || other[k] != 0.0 {
            subtract(other[k], &column[k + 1..], &mut other[k + 1..]);
        }
    }
    Ok(())
}

/// The magnitudes that were added up in pivot k, including those that other nodes added.
#[inline(always)]
fn magnitude(s: usize, k: usize, rows: &Rows<'_>, added: f64) -> f64 {
    let d = &rows.d;
    let summands: f64 = (0..k).map(|m| (d[m * s + k] * d[k * s + m]).abs()).sum();
    d[k * s + k].abs() + (summands + added)
}

/// The magnitudes added up in the diagonal entry of an unknown j whose equation gives another pivot k, as they were subtracted from that pivot.
///
/// In [λ ε; ε 1], where λ = O(ε²) is a difference of terms of order 1, an interchange gives the pivots ε and ε − λ/ε. Neither is small compared with the
/// terms of its own sum, but λ/ε has the rounding error of 1/ε.
#[cold]
#[inline(never)]
fn inherited(s: usize, k: usize, rows: &Rows<'_>) -> f64 {
    let j = equation(k, rows);
    if j < k { own_magnitude(s, k + 1, k, rows, f64::INFINITY) * (rows.d[j * s + j] * rows.d[k * s + j]).abs() } else { 0.0 }
}

/// True if the digits of the entry before an addition are lost in the added terms.
#[inline(always)]
pub(super) fn is_buried(before: f64, added: f64) -> bool {
    added > MOST_LOSS * before && before > 0.0
}

/// True if the elimination of column k buries another diagonal entry.
#[inline(never)]
fn buries(s: usize, k: usize, rows: &Rows<'_>) -> bool {
    let (d, pivot) = (&rows.d, rows.d[k * s + k].abs());
    (k + 1..s).any(|i| {
        let (own, subtracted) = (d[i * s + i].abs(), (d[k * s + i] * d[i * s + k]).abs());
        // What others added counts seldom.
        let added = || if rows.mixed.is_empty() { rows.scale[i] } else { added_by_others([i, i], rows) };
        subtracted > MOST_LOSS * pivot * own && is_buried(pivot * (own + added()), subtracted)
    })
}

/// The row, from k on, whose entry in column k is largest in a measure that does not depend on units.
///
/// An equation has the unit J divided by that of its unknown; m_j, the magnitudes added up in the diagonal entry of unknown j, has J divided by its
/// square. So |d_ik|/√m_j, where row i contains the equation of unknown j, has the same unit for all rows. If nothing was added up so far, as for a
/// constraint before its velocities are eliminated, m_j is replaced by the amount that eliminating them would add. Row k counts with a `share` of its
/// measure.
#[cold]
#[inline(never)]
fn choose_row(s: usize, k: usize, rows: &Rows<'_>, share: f64) -> usize {
    // The quality of row i, or a value below `least` if it is not larger.
    let quality = |i: usize, least: f64| {
        let entry = rows.d[k * s + i];
        let enough = coupled(entry, least);
        let size = match own_magnitude(s, k, i, rows, enough) {
            0.0 => {
                let others = (k..s).map(|m| (rows.d[m * s + i], own_magnitude(s, k, m, rows, f64::INFINITY)));
                others.filter(|(_, size)| *size > 0.0).map(|(entry, size)| coupled(entry, size)).sum()
            }
            size => size,
        };
        coupled(entry, size)
    };
    let first = (k, share * quality(k, 0.0));
    let others = (k + 1..s).filter(|i| rows.d[k * s + i] != 0.0);
    others.fold(first, |best, i| Some((i, quality(i, best.1))).filter(|other| other.1 > best.1).unwrap_or(best)).0
}

/// The magnitudes that other nodes added to entry (i, j), or a bound on them, √(m_j m_l), if row i contains the equation of another unknown l.
#[cold]
#[inline(never)]
fn added_by_others([i, j]: [usize; 2], rows: &Rows<'_>) -> f64 {
    (rows.scale[equation(i, rows)] * rows.scale[j]).sqrt()
}

/// x²/size; infinite for x ≠ 0 and size 0.
fn coupled(x: f64, size: f64) -> f64 {
    // An empty sum is −0.
    if x == 0.0 { 0.0 } else { (x * (x / size)).abs() }
}

/// The unknown whose equation is in row i now.
fn equation(i: usize, rows: &Rows<'_>) -> usize {
    let back = |i: usize, m: usize| match (i, rows.swaps[m]) {
        (i, row) if i == m => row,
        (i, row) if i == row => m,
        (i, _) => i,
    };
    rows.mixed.clone().rev().fold(i, back)
}

/// The magnitudes that were added up before step k in the diagonal entry of the unknown whose equation is in row i; fewer of them if they are `enough`.
fn own_magnitude(s: usize, k: usize, i: usize, rows: &Rows<'_>, enough: f64) -> f64 {
    let (d, j) = (&rows.d, equation(i, rows));
    // An eliminated column contains the factor, which must be multiplied by the pivot.
    let rest = if j < k { d[j * s + i] / d[j * s + j] } else { d[j * s + i] };
    let known = rest.abs() + rows.scale[j];
    if known >= enough {
        return known;
    }
    known + (0..j.min(k)).map(|m| (d[m * s + i] * d[j * s + m]).abs()).sum::<f64>()
}

/// Exchanges rows k < row; searching for `row` keeps the indices constant after unrolling.
#[inline(always)]
fn swap_rows(s: usize, columns: &mut [f64], k: usize, row: usize) {
    for i in k + 1..s {
        if i == row {
            for column in columns.chunks_exact_mut(s) {
                column.swap(k, i);
            }
        }
    }
}

/// The number of negative eigenvalues of a symmetric D, from its factors.
pub(super) fn negative_eigenvalues(factors: &[f64], swaps: &[usize]) -> usize {
    let s = swaps.len();
    if swaps.first() == Some(&IN_ORDER) || swaps.iter().enumerate().all(|(k, &row)| row == k) {
        // D = L diag(pivots) Lᵀ.
        return (0..s).filter(|k| factors[k * (s + 1)] < 0.0).count();
    }
    let lu = DMatrix::from_column_slice(s, s, factors);
    let (mut lower, mut upper) = (lu.lower_triangle(), lu.upper_triangle());
    lower.fill_diagonal(1.0);
    upper.set_diagonal(&lu.diagonal().map(f64::recip));
    let mut d = lower * upper;
    d.column_iter_mut().for_each(|mut column| permute_back(swaps, column.as_mut_slice()));
    // Scaled so that no entry exceeds 1, which does not change signs.
    let units: Vec<f64> = d.row_iter().map(|row| row.amax().sqrt().recip()).collect();
    let scaled = DMatrix::from_fn(s, s, |i, j| d[(i, j)] * units[i] * units[j]);
    eigen(scaled).map_or(0, |found| found.eigenvalues.iter().filter(|x| **x < 0.0).count())
}

/// y := P y.
#[inline(always)]
pub(super) fn permute(swaps: &[usize], y: &mut [f64]) {
    for (k, &row) in swaps.iter().enumerate() {
        if row != k {
            y.swap(k, row);
        }
    }
}

/// y := Pᵀ y.
#[inline(always)]
pub(super) fn permute_back(swaps: &[usize], y: &mut [f64]) {
    for (k, &row) in swaps.iter().enumerate().rev() {
        if row != k {
            y.swap(k, row);
        }
    }
}

/// y := L⁻¹ y.
#[inline(always)]
pub(super) fn solve_lower<N: Size>(n: N, lu: &[f64], y: &mut [f64]) {
    let s = n.get();
    let (lu, y) = (&lu[..s * s], &mut y[..s]);
    for (k, column) in lu.chunks_exact(s).enumerate() {
        let (head, tail) = y.split_at_mut(k + 1);
        if N::FIXED || head[k] != 0.0 {
            subtract(head[k], &column[k + 1..], tail);
        }
    }
}

/// y := U⁻¹ y.
#[inline(always)]
pub(super) fn solve_upper<N: Size>(n: N, lu: &[f64], y: &mut [f64]) {
    let s = n.get();
    let (lu, y) = (&lu[..s * s], &mut y[..s]);
    for (k, column) in lu.chunks_exact(s).enumerate().rev() {
        y[k] *= column[k];
        let (head, tail) = y.split_at_mut(k);
        subtract(tail[0], &column[..k], head);
    }
}

/// y := U⁻ᵀ y.
#[inline(always)]
pub(super) fn solve_upper_transposed<N: Size>(n: N, lu: &[f64], y: &mut [f64]) {
    let s = n.get();
    let (lu, y) = (&lu[..s * s], &mut y[..s]);
    let first = if N::FIXED { 0 } else { y.iter().position(|y| *y != 0.0).unwrap_or(s) };
    for (k, column) in lu.chunks_exact(s).enumerate().skip(first) {
        y[k] = minus_dot(y[k], &column[first..k], &y[first..k]) * column[k];
    }
}

/// y := L⁻ᵀ y.
#[inline(always)]
pub(super) fn solve_lower_transposed<N: Size>(n: N, lu: &[f64], y: &mut [f64]) {
    let s = n.get();
    let (lu, y) = (&lu[..s * s], &mut y[..s]);
    for (k, column) in lu.chunks_exact(s).enumerate().rev() {
        let known = column[k + 1..].iter().zip(&y[k + 1..]).rev();
        y[k] = known.fold(y[k], |sum, (l, y)| minus_product(sum, *l, *y));
    }
}
