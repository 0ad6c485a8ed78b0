//! GMRES (Y. Saad and M. H. Schultz, 1986): solves A x = b by products with A alone, for A close to a matrix whose factors are known.

use crate::number::dot;

/// Solves A x = b until the residual is at most `tolerance` times |b|, or until `most` products were computed; A and b are preconditioned.
pub(crate) fn gmres(b: &[f64], tolerance: f64, most: usize, mut product: impl FnMut(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let norm = |x: &[f64]| dot(x, x).sqrt();
    let size = norm(b);
    let mut x = vec![0.0; b.len()];
    if size == 0.0 || !size.is_finite() {
        return x;
    }
    let mut basis: Vec<Vec<f64>> = vec![b.iter().map(|b| b / size).collect()];
    // The triangle R of the least-squares problem by columns, the rotations that produced it, and its right-hand side.
    let (mut triangle, mut rotations, mut right): (Vec<Vec<f64>>, Vec<[f64; 2]>, Vec<f64>) = (vec![], vec![], vec![size]);
    for k in 0..most.min(b.len()) {
        let mut next = product(&basis[k]);
        let mut column = vec![0.0; k + 1];
        // Two passes make the vector orthogonal to rounding error.
        for _ in 0..2 {
            for (entry, direction) in column.iter_mut().zip(&basis) {
                let along = dot(&next, direction);
                *entry += along;
                next.iter_mut().zip(direction).for_each(|(next, direction)| *next -= along * direction);
            }
        }
        let below = norm(&next);
        for (i, [cos, sin]) in rotations.iter().enumerate() {
            (column[i], column[i + 1]) = (cos * column[i] + sin * column[i + 1], cos * column[i + 1] - sin * column[i]);
        }
        let length = column[k].hypot(below);
        if length == 0.0 || !length.is_finite() {
            break;
        }
        let [cos, sin] = [column[k] / length, below / length];
        column[k] = length;
        let last = right[k];
        right[k] = cos * last;
        right.push(-sin * last);
        rotations.push([cos, sin]);
        triangle.push(column);
        if right[k + 1].abs() <= tolerance * size || below == 0.0 {
            break;
        }
        next.iter_mut().for_each(|next| *next /= below);
        basis.push(next);
    }
    let mut weights = right;
    for k in (0..triangle.len()).rev() {
        weights[k] /= triangle[k][k];
        let weight = weights[k];
        weights[..k].iter_mut().zip(&triangle[k]).for_each(|(earlier, entry)| *earlier -= weight * entry);
    }
    for (weight, direction) in weights.iter().zip(&basis).take(triangle.len()) {
        x.iter_mut().zip(direction).for_each(|(x, direction)| *x += weight * direction);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::gmres;

    #[test]
    fn a_full_matrix_takes_as_many_products_as_it_has_rows() {
        let entry = |i: usize, j: usize| ((7 * i * j + 3 * j + i + 1) as f64).sin() + if i == j { 4.0 } else { 0.0 };
        let solution: Vec<f64> = (0..9).map(|i| (i as f64).cos()).collect();
        let product = |x: &[f64]| (0..9).map(|i| (0..9).map(|j| entry(i, j) * x[j]).sum()).collect::<Vec<f64>>();
        let mut count = 0;
        let found = gmres(&product(&solution), 1e-14, 50, |x| {
            count += 1;
            product(x)
        });
        assert!(found.iter().zip(&solution).all(|(x, y)| (x - y).abs() < 1e-12), "{found:?}");
        assert_eq!(count, 9);
    }

    #[test]
    fn a_matrix_that_differs_from_one_by_rank_two_takes_three_products() {
        let product = |x: &[f64]| {
            let (a, b) = (x[0] + x[3], x[1] - 2.0 * x[4]);
            x.iter().enumerate().map(|(i, x)| x + 5.0 * a * i as f64 - b).collect::<Vec<f64>>()
        };
        let mut count = 0;
        let right = [1.0, -0.5, 2.0, 0.3, 0.1, 4.0];
        let found = gmres(&right, 1e-14, 50, |x| {
            count += 1;
            product(x)
        });
        assert!(product(&found).iter().zip(&right).all(|(x, y)| (x - y).abs() < 1e-13));
        assert_eq!(count, 3);
    }
}
