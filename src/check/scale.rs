//! The natural size of each entry of a block, whatever the units of its rows and columns.

use nalgebra::DMatrix;

/// Rounds of balancing; the sizes need no more than a digit.
const ROUNDS: usize = 12;
const BALANCING_ROUNDS: usize = 60;

/// r_i c_j with |a_ij| ≤ r_i c_j and every row and column touching the bound, nearly.
///
/// Changing the unit of a row or a column changes its r or c alike, so errors relative to these sizes mean the same in metres and
/// in millimetres. Ruiz's equilibration alone has many solutions; which one it finds would depend on the units. So it begins where
/// the logarithms of all entries are balanced, which is unique. Rows and columns without any entry get `fallback_ij`.
pub(crate) fn sizes(a: &DMatrix<f64>, fallback: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let (rows, columns) = a.shape();
    let (mut r, mut c) = balanced(a);
    let entry = |r: &[f64], c: &[f64], i: usize, j: usize| a[(i, j)].abs() / (r[i] * c[j]);
    for _ in 0..ROUNDS {
        let row: Vec<f64> = (0..rows).map(|i| (0..columns).fold(0.0, |m: f64, j| m.max(entry(&r, &c, i, j)))).collect();
        let column: Vec<f64> = (0..columns).map(|j| (0..rows).fold(0.0, |m: f64, i| m.max(entry(&r, &c, i, j)))).collect();
        let grow =
            |x: &mut [f64], by: &[f64]| x.iter_mut().zip(by).filter(|(_, m)| **m > 0.0).for_each(|(x, m)| *x *= m.sqrt());
        grow(&mut r, &row);
        grow(&mut c, &column);
    }
    let empty_row = |i: usize| a.row(i).iter().all(|x| *x == 0.0);
    let empty_column = |j: usize| a.column(j).iter().all(|x| *x == 0.0);
    let (no_row, no_column): (Vec<bool>, Vec<bool>) =
        ((0..rows).map(empty_row).collect(), (0..columns).map(empty_column).collect());
    DMatrix::from_fn(rows, columns, |i, j| {
        if no_row[i] || no_column[j] { fallback(i, j) } else { (r[i] * c[j]).max(a[(i, j)].abs()) }
    })
}

/// r_i c_j ≈ |a_ij| in the least squares of the logarithms of all entries but zeros, by turns for r and c.
fn balanced(a: &DMatrix<f64>) -> (Vec<f64>, Vec<f64>) {
    let (rows, columns) = a.shape();
    let logarithms: Vec<(usize, usize, f64)> = (0..rows)
        .flat_map(|i| (0..columns).map(move |j| (i, j)))
        .filter(|&at| a[at] != 0.0 && a[at].is_finite())
        .map(|(i, j)| (i, j, a[(i, j)].abs().ln()))
        .collect();
    let (mut rho, mut gamma) = (vec![0.0; rows], vec![0.0; columns]);
    for _ in 0..BALANCING_ROUNDS {
        let row = logarithms.iter().map(|&(i, j, log)| (i, log - gamma[j]));
        rho = means(row, rows);
        let column = logarithms.iter().map(|&(i, j, log)| (j, log - rho[i]));
        gamma = means(column, columns);
    }
    let exponentials = |x: Vec<f64>| x.into_iter().map(f64::exp).collect();
    (exponentials(rho), exponentials(gamma))
}

/// The mean of the values with each index; zero where there are none.
fn means(values: impl Iterator<Item = (usize, f64)>, len: usize) -> Vec<f64> {
    let (mut sums, mut counts) = (vec![0.0; len], vec![0usize; len]);
    for (i, value) in values {
        sums[i] += value;
        counts[i] += 1;
    }
    sums.iter().zip(counts).map(|(sum, count)| sum / count.max(1) as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_follow_the_units() {
        let a = DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 0.3, -0.2, 2.0, 1.0]);
        let (row, column) = ([1e6, 1e-3], [1.0, 1e-6, 1e4]);
        let scaled = DMatrix::from_fn(2, 3, |i, j| a[(i, j)] * row[i] * column[j]);
        let (plain, scaled) = (sizes(&a, |_, _| 0.0), sizes(&scaled, |_, _| 0.0));
        for i in 0..2 {
            for j in 0..3 {
                let ratio = scaled[(i, j)] / (plain[(i, j)] * row[i] * column[j]);
                assert!((0.5..2.0).contains(&ratio), "{ratio}");
            }
        }
    }
}
