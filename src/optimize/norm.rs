//! Norms of vectors of any magnitude, whose squares may overflow or underflow.

use crate::number::{dot, largest};

/// The power of two that is at most x and more than half of it, so that division by it is exact; 1 if there is none.
pub(super) fn magnitude(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    let power = f64::from_bits(x.to_bits() & EXPONENT);
    match x {
        0.0 => 1.0,
        _ if power.is_finite() => power.max(f64::MIN_POSITIVE),
        _ => 1.0,
    }
}

/// Square root of the sum of squares.
pub(super) fn norm(x: &[f64]) -> f64 {
    let unit = magnitude(largest(x));
    let parts: Vec<f64> = x.iter().map(|x| x / unit).collect();
    unit * dot(&parts, &parts).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_norm_of_any_size_is_exact() {
        for size in [1e-320, 1e-300, 1.0, 7.3, 1e160, 1e307] {
            let (unit, exact) = (magnitude(size), 5.0 * size);
            assert!(unit > 0.5 * size && unit <= size.max(f64::MIN_POSITIVE), "{size:e} {unit:e}");
            assert!((norm(&[3.0 * size, -4.0 * size]) - exact).abs() <= 1e-15 * exact + 1e-323, "{size:e}");
        }
        assert_eq!((magnitude(0.0), norm(&[]), norm(&[0.0; 5])), (1.0, 0.0, 0.0));
    }
}
