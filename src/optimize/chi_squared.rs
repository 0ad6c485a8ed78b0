//! The χ² distribution: probabilities of sums of squares of normal numbers.
//!
//! ```text
//!   P(χ² ≤ c) = P(a, x),   P(χ² ≥ c) = Q(a, x) = 1 − P(a, x),   a = degrees of freedom/2,   x = c/2
//!   P(a, x) = e^−x x^a/Γ(a + 1) (1 + x/(a + 1) + x²/((a + 1)(a + 2)) + …)
//!   Q(a, x) = e^−x x^a/Γ(a) · 1/(x + 1 − a − 1(1 − a)/(x + 3 − a − 2(2 − a)/(x + 5 − a − …)))
//! ```

use std::f64::consts::PI;

/// Series and fractions end with this relative accuracy, or after so many terms.
const ACCURACY: f64 = 1e-14;
const TERMS: usize = 100_000;

/// Probabilities of a χ² that is at most, and at least, `chi`, for this number of degrees of freedom, at least 1.
pub(super) fn tails(chi: f64, degrees: usize) -> [f64; 2] {
    let (a, x) = (0.5 * degrees as f64, 0.5 * chi);
    if x <= 0.0 {
        return [0.0, 1.0];
    }
    if x.is_infinite() {
        return [1.0, 0.0];
    }
    // e^−x x^a/Γ(a).
    let front = (a * x.ln() - x - ln_gamma_of_half(degrees)).exp();
    if x < a + 1.0 {
        let lower = (front / a * series(a, x)).min(1.0);
        [lower, 1.0 - lower]
    } else {
        let upper = (front * fraction(a, x)).min(1.0);
        [1.0 - upper, upper]
    }
}

/// ln Γ(k/2), from Γ(z + 1) = z Γ(z), Γ(1) = 1 and Γ(1/2) = √π.
fn ln_gamma_of_half(k: usize) -> f64 {
    let (first, begin) = if k.is_multiple_of(2) { (1.0, 0.0) } else { (0.5, 0.5 * PI.ln()) };
    begin + (0..(k - 1) / 2).map(|j| (first + j as f64).ln()).sum::<f64>()
}

fn series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for n in 1..TERMS {
        term *= x / (a + n as f64);
        sum += term;
        if term <= ACCURACY * sum {
            break;
        }
    }
    sum
}

/// The continued fraction, by the algorithm of Lentz.
fn fraction(a: f64, x: f64) -> f64 {
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1.0 / f64::MIN_POSITIVE, 1.0 / b);
    let mut value = d;
    for n in 1..TERMS {
        let n = n as f64;
        let numerator = -n * (n - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        value *= d * c;
        if (d * c - 1.0).abs() <= ACCURACY {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_two_degrees_are_exponentials_and_others_those_of_tables() {
        for chi in [1e-3, 0.5, 1.0, 3.0, 4.0, 10.0, 60.0] {
            let [lower, upper] = tails(chi, 2);
            let (own, exact) = (if chi < 4.0 { 1.0 - lower } else { upper }, (-0.5f64 * chi).exp());
            assert!((own - exact).abs() < 1e-13 * exact && (lower + upper - 1.0).abs() < 1e-15, "{chi}");
            // Four degrees: (1 + x) e^−x.
            let (own, exact) = (tails(chi, 4)[1], (1.0 + 0.5 * chi) * exact);
            assert!((own - exact).abs() < 1e-13, "{chi}: {own} {exact}");
        }
        // Five percent points of printed tables.
        for (chi, degrees) in [(3.841, 1), (11.070, 5), (18.307, 10), (124.342, 100)] {
            assert!((tails(chi, degrees)[1] - 0.05).abs() < 2e-5, "{degrees}");
        }
        assert!(tails(506.0, 237)[1] < 1e-20 && tails(100.0, 237)[0] < 1e-12);
        // Near a normal distribution with the mean k and the variance 2 k.
        let half = tails(1e5, 100_000)[1];
        assert!((half - 0.5).abs() < 1e-3, "{half}");
        assert_eq!((tails(0.0, 3), tails(f64::INFINITY, 3)), ([0.0, 1.0], [1.0, 0.0]));
    }
}
