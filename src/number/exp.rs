//! The exponential of several numbers side by side.
//!
//! x = n ln 2 + r with |r| ≤ ½ ln 2. The first of two parts of ln 2 has so few digits that n times it is exact. Then
//! eʳ = 1 + r + r c/(2 − c) with c = r − r² p(r²), to about one unit in the last place (p's coefficients are those of fdlibm's `e_exp.c`).
//! For |x| > 700, where 2ⁿ may not be a normal number, and for NaN, the standard library computes the result.

// Coefficients as in their source.
#![expect(clippy::excessive_precision)]

use std::f64::consts::LOG2_E;

use super::lanes::{minus_product, plus_product, polynomial};
use super::sincos::ROUND;

/// ln 2 to 32 bits, and the remainder.
const LN_2_HIGH: f64 = 6.931_471_803_691_238_164_90e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_700_02e-10;
const MOST: f64 = 700.0;

/// eˣ of several numbers, without branches as long as all of them are moderate.
#[inline]
pub(crate) fn exp_lanes<const L: usize>(x: &[f64; L]) -> [f64; L] {
    // A single number is computed faster from a table.
    if L == 1 || x.iter().any(|x| x.abs() > MOST || x.is_nan()) {
        return x.map(f64::exp);
    }
    // A loop that the compiler vectorises.
    let mut powers = [0.0; L];
    for (power, x) in powers.iter_mut().zip(x) {
        *power = exp_moderate(*x);
    }
    powers
}

#[inline(always)]
fn exp_moderate(x: f64) -> f64 {
    let shifted = plus_product(ROUND, x, LOG2_E);
    let n = shifted - ROUND;
    let (high, low) = (minus_product(x, n, LN_2_HIGH), n * LN_2_LOW);
    let r = high - low;
    let z = r * r;
    let p = [
        1.666_666_666_666_660_190_37e-1,
        -2.777_777_777_701_559_338_42e-3,
        6.613_756_321_437_934_361_17e-5,
        -1.653_390_220_546_525_153_90e-6,
        4.138_136_797_057_238_460_39e-8,
    ];
    let c = minus_product(r, z, polynomial(z, p));
    // n is in the lowest bits of the sum; with the bias it becomes the exponent.
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    (1.0 - ((low - r * c / (2.0 - c)) - high)) * power
}

#[cfg(test)]
mod tests {
    use super::exp_lanes;

    #[test]
    fn agrees_with_the_standard_library_to_rounding() {
        let mut x = -710.0f64;
        while x < 712.0 {
            let numbers = [x, -x, x * 1e-3, x * 1e-9];
            for (x, y) in numbers.iter().zip(exp_lanes(&numbers)) {
                let exp = x.exp();
                assert!(y == exp || (y - exp).abs() <= 2.3e-16 * exp, "{x}: {y} {exp}");
            }
            x += 0.0137;
        }
        assert_eq!(exp_lanes(&[0.0, -0.0]), [1.0; 2]);
        let [a, b, c, d] = exp_lanes(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0]);
        assert!(a.is_nan() && [b, c, d] == [f64::INFINITY, 0.0, 1f64.exp()]);
    }
}
