//! Central differences with Ridders' extrapolation, which estimates its own error.

/// Maximum number of extrapolations; estimates of higher order only amplify rounding.
const MOST_ORDERS: usize = 6;
/// Number of steps before the extrapolation may stop.
const FEWEST: usize = 3;
/// Rounding error of a value, relative to it.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// dy/ds at s = 0 and an estimate of its error, for every component of y.
///
/// `along(s)` returns s as rounded (or x + s) and y there. With D(h) = (y(h) − y(−h))/2h, Neville's tableau removes the terms
/// h², h⁴, …:  A_k(h/2) = A_{k−1}(h/2) + (A_{k−1}(h/2) − A_{k−1}(h))/(4ᵏ − 1). For each component, the result is the entry that differs
/// least from its two parents; its error estimate is this difference or the rounding error of D(h), whichever is larger. If a first
/// step leaves the function's domain, shorter ones are used. Stops early when every estimate is below `enough` relative to its
/// derivative.
pub(crate) fn ridders(
    along: impl Fn(f64) -> (f64, Vec<f64>),
    (step, halvings): (f64, usize),
    enough: f64,
    rows: usize,
) -> (Vec<f64>, Vec<f64>) {
    let mut best = vec![f64::NAN; rows];
    let mut error = vec![f64::INFINITY; rows];
    let mut previous: Vec<Vec<f64>> = Vec::new();
    let mut h = step;
    for _ in 0..=halvings {
        let (first, rounding) = central(&along, h);
        let mut tableau = vec![first];
        for order in 1..=previous.len().min(MOST_ORDERS) {
            let factor = 4f64.powi(order as i32);
            let (finer, coarser) = (&tableau[order - 1], &previous[order - 1]);
            let next: Vec<f64> = finer.iter().zip(coarser).map(|(f, c)| f + (f - c) / (factor - 1.0)).collect();
            for i in 0..rows {
                let change = (next[i] - finer[i]).abs().max((next[i] - coarser[i]).abs());
                // NaN must not count as small.
                let change = if change.is_nan() { f64::INFINITY } else { change.max(rounding[i]) };
                if change < error[i] {
                    (best[i], error[i]) = (next[i], change);
                }
            }
            tableau.push(next);
        }
        previous = tableau;
        if previous.len() > FEWEST && best.iter().zip(&error).all(|(x, e)| *e <= enough * x.abs()) {
            break;
        }
        h *= 0.5;
    }
    (best, error)
}

/// D(h) and its rounding error.
fn central(along: &impl Fn(f64) -> (f64, Vec<f64>), h: f64) -> (Vec<f64>, Vec<f64>) {
    let ((right, above), (left, below)) = (along(h), along(-h));
    let width = right - left;
    let pairs = || above.iter().zip(&below);
    let rounding = pairs().map(|(a, b)| ROUNDING * a.abs().max(b.abs()) / width.abs()).collect();
    (pairs().map(|(a, b)| (a - b) / width).collect(), rounding)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error must be within a few times its estimate, for smooth, steep and rounded functions alike.
    #[test]
    fn the_estimate_is_honest() {
        let x = 0.8f64;
        let along =
            |s: f64| (s, vec![(x + s).sin(), (30.0 * (x + s)).sin(), (x + s).exp() + 1e6, (x + s).powi(3) * 1e-12 + 5.0]);
        let exact = [x.cos(), 30.0 * (30.0 * x).cos(), x.exp(), 3e-12 * x * x];
        let (derivative, error) = ridders(along, (0.05, 12), 0.0, 4);
        for i in 0..4 {
            assert!((derivative[i] - exact[i]).abs() <= 10.0 * error[i], "{i}: {} ± {:.1e}", derivative[i], error[i]);
        }
        assert!(error[0] < 1e-11 && error[1] < 1e-8 && error[2] < 1e-7);
    }

    #[test]
    fn a_domain_that_ends_nearby_only_shortens_the_step() {
        let (derivative, error) = ridders(|s| (s, vec![(0.01 + s).sqrt()]), (0.05, 12), 0.0, 1);
        assert!((derivative[0] - 5.0).abs() < 1e-8 && error[0] < 1e-7, "{derivative:?} {error:?}");
    }
}
