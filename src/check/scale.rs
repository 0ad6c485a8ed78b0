//! The natural size of each entry of a block, independent of the units of its rows and columns.

use nalgebra::DMatrix;

/// Number of equilibration and balancing rounds; one correct digit suffices.
const ROUNDS: usize = 12;
const BALANCING_ROUNDS: usize = 60;

/// Sizes r_i c_j ≥ |a_ij| that are nearly attained in every row and column.
///
/// Changing the unit of a row or a column changes its r or c alike, so errors relative to these sizes mean the same in metres and
/// in millimetres. Ruiz's equilibration has many solutions, and the one that it finds depends on its start. It therefore starts from a
/// unique one, which balances the logarithms of all entries. Rows and columns without nonzero entries get `fallback_ij`.
pub(crate) fn sizes(a: &DMatrix<f64>, fallback: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let (mut r, mut c) = balanced(a);
    for _ in 0..ROUNDS {
        let entries = a.map_with_location(|i, j, x| x.abs() / (r[i] * c[j]));
        let grow = |x: &mut f64, most: f64| *x *= if most > 0.0 { most.sqrt() } else { 1.0 };
        r.iter_mut().zip(entries.row_iter()).for_each(|(r, row)| grow(r, largest(row.iter())));
        c.iter_mut().zip(entries.column_iter()).for_each(|(c, column)| grow(c, largest(column.iter())));
    }
    let no_row: Vec<bool> = a.row_iter().map(|row| row.iter().all(|x| *x == 0.0)).collect();
    let no_column: Vec<bool> = a.column_iter().map(|column| column.iter().all(|x| *x == 0.0)).collect();
    a.map_with_location(|i, j, x| if no_row[i] || no_column[j] { fallback(i, j) } else { (r[i] * c[j]).max(x.abs()) })
}

fn largest<'a>(x: impl Iterator<Item = &'a f64>) -> f64 {
    x.fold(0.0, |most, x| most.max(*x))
}

/// Least-squares fit of r_i c_j to |a_ij| in the logarithms of all nonzero entries, alternating between r and c.
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

/// The mean of the values with each index; zero if there are none.
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
