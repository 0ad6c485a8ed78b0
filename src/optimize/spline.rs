//! Cubic B-splines with clamped ends and equidistant knots.

/// The first of the four coefficients that contribute at the relative position `share`, and their weights, which add up to 1 (Cox and de Boor).
pub(super) fn cubic(share: f64, coefficients: usize) -> (usize, [f64; 4]) {
    let spans = coefficients - 3;
    let x = share.clamp(0.0, 1.0) * spans as f64;
    let first = (x as usize).min(spans - 1);
    // Knots 0, 0, 0, 0, 1, 2, …, with four equal ones at the end, too.
    let knot = |i: usize| i.saturating_sub(3).min(spans) as f64;
    let (left, right) = (|k: usize| x - knot(first + 4 - k), |k: usize| knot(first + 3 + k) - x);
    let mut weights = [1.0, 0.0, 0.0, 0.0];
    for degree in 1..=3 {
        let mut saved = 0.0;
        for (r, weight) in weights[..degree].iter_mut().enumerate() {
            let share = *weight / (right(r + 1) + left(degree - r));
            *weight = saved + right(r + 1) * share;
            saved = left(degree - r) * share;
        }
        weights[degree] = saved;
    }
    (first, weights)
}

#[cfg(test)]
mod tests {
    use super::cubic;

    fn value(share: f64, coefficients: &[f64]) -> f64 {
        let (first, weights) = cubic(share, coefficients.len());
        weights.iter().zip(&coefficients[first..]).map(|(w, c)| w * c).sum()
    }

    #[test]
    fn ends_are_kept_and_straight_lines_and_cubics_are_splines() {
        let coefficients = [2.0, -1.0, 0.5, 3.0, 1.0, -4.0, 7.0];
        assert_eq!((value(0.0, &coefficients), value(1.0, &coefficients)), (2.0, 7.0));
        for k in 0..=40 {
            let x = f64::from(k) / 40.0;
            assert!((cubic(x, 9).1.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            // Coefficients that are the means of three consecutive knots reproduce the line itself.
            let line = [0.0, 1.0, 3.0, 6.0, 9.0, 12.0, 14.0, 15.0].map(|sum| sum / 15.0);
            assert!((value(x, &line) - x).abs() < 1e-15);
            // Four coefficients form a Bézier curve; for x³ only the last one is not zero.
            assert!((value(x, &[0.0, 0.0, 0.0, 1.0]) - x.powi(3)).abs() < 1e-15);
        }
    }
}
