//! Central differences with Ridders' extrapolation, which estimates its own error.

/// Estimates of an even higher order only amplify rounding.
const MOST_ORDERS: usize = 6;

/// dy/ds at s = 0 and an estimate of its error, for every component of y.
///
/// `along(s)` gives the perturbed argument x + s, as rounded, and y there. With D(h) = (y(h) − y(−h))/2h, Neville's tableau removes
/// the terms h², h⁴, …:  A_k(h/2) = A_{k−1}(h/2) + (A_{k−1}(h/2) − A_{k−1}(h))/(4ᵏ − 1). For each component the entry is taken that changes
/// least from its two parents; that change is the estimate. A point outside the function's domain only makes the first step shorter.
pub(crate) fn ridders(
    along: impl Fn(f64) -> (f64, Vec<f64>),
    step: f64,
    halvings: usize,
    rows: usize,
) -> (Vec<f64>, Vec<f64>) {
    let mut best = vec![f64::NAN; rows];
    let mut error = vec![f64::INFINITY; rows];
    let mut previous: Vec<Vec<f64>> = Vec::new();
    let mut h = step;
    for _ in 0..=halvings {
        let mut tableau = vec![central(&along, h)];
        for order in 1..=previous.len().min(MOST_ORDERS) {
            let factor = 4f64.powi(order as i32);
            let (finer, coarser) = (&tableau[order - 1], &previous[order - 1]);
            let next: Vec<f64> = finer.iter().zip(coarser).map(|(f, c)| f + (f - c) / (factor - 1.0)).collect();
            for i in 0..rows {
                let change = (next[i] - finer[i]).abs().max((next[i] - coarser[i]).abs());
                if change < error[i] {
                    (best[i], error[i]) = (next[i], change);
                }
            }
            tableau.push(next);
        }
        previous = tableau;
        h *= 0.5;
    }
    (best, error)
}

fn central(along: &impl Fn(f64) -> (f64, Vec<f64>), h: f64) -> Vec<f64> {
    let ((right, above), (left, below)) = (along(h), along(-h));
    above.iter().zip(&below).map(|(a, b)| (a - b) / (right - left)).collect()
}
