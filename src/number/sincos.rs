//! Sine and cosine together, inlined so that the angles of one iteration are computed in parallel.
//!
//! x = n π/2 + r with |r| ≤ π/4. The first of two parts of π/2 has so few digits that n times it is exact. Polynomials in r² with minimax
//! coefficients (those of fdlibm's `k_sin.c` and `k_cos.c`) are accurate to about one unit in the last place. For angles beyond 10⁵ rad
//! and values that are not finite, the standard library computes the result.

// Coefficients as in their source.
#![expect(clippy::excessive_precision)]

use std::f64::consts::FRAC_2_PI;

use super::lanes::{minus_product, plus_product, polynomial};

/// π/2 to 33 bits, and the remainder.
const FRAC_PI_2_HIGH: f64 = 1.570_796_326_734_125_614_17;
const FRAC_PI_2_LOW: f64 = 6.077_100_506_506_192_249_32e-11;
/// Adding and subtracting this number rounds to an integer, which is then in the lowest bits of the sum.
pub(super) const ROUND: f64 = 6_755_399_441_055_744.0;
const MOST: f64 = 1e5;

/// (sin x, cos x).
#[inline(always)]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() > MOST || x.is_nan() {
        return x.sin_cos();
    }
    let shifted = plus_product(ROUND, x, FRAC_2_PI);
    let n = shifted - ROUND;
    let r = reduced(x, n);
    let (sin, cos) = (sine(r), cosine(r));
    let quadrant = shifted.to_bits();
    let (s, c) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let negative = |yes: bool, x: f64| if yes { -x } else { x };
    (negative(quadrant & 2 != 0, s), negative((quadrant + 1) & 2 != 0, c))
}

/// (sin x, cos x) of several angles side by side, without branches as long as all of them are moderate.
#[inline]
pub(crate) fn sin_cos_lanes<const L: usize>(x: &[f64; L]) -> ([f64; L], [f64; L]) {
    let (mut sines, mut cosines) = ([0.0; L], [0.0; L]);
    if x.iter().any(|x| x.abs() > MOST || x.is_nan()) {
        for lane in 0..L {
            (sines[lane], cosines[lane]) = sin_cos(x[lane]);
        }
        return (sines, cosines);
    }
    for lane in 0..L {
        let shifted = plus_product(ROUND, x[lane], FRAC_2_PI);
        let n = shifted - ROUND;
        let r = reduced(x[lane], n);
        let (sin, cos, quadrant) = (sine(r).to_bits(), cosine(r).to_bits(), shifted.to_bits());
        // All bits set in odd quadrants, where the two change places.
        let swap = 0u64.wrapping_sub(quadrant & 1);
        let (s, c) = ((sin & !swap) | (cos & swap), (cos & !swap) | (sin & swap));
        sines[lane] = f64::from_bits(s ^ ((quadrant & 2) << 62));
        cosines[lane] = f64::from_bits(c ^ ((quadrant.wrapping_add(1) & 2) << 62));
    }
    (sines, cosines)
}

/// An angle with its sine and cosine, from which those of nearby angles follow: an iteration changes an angle only a little.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    angle: f64,
    sin: f64,
    cos: f64,
}

impl Known {
    /// No angle is near this one.
    pub(crate) const NONE: Known = Known { angle: f64::NAN, sin: 0.0, cos: 0.0 };
    /// For ε below this, the omitted terms of Taylor's series are below 1e-17.
    const NEAR: f64 = 1.0 / 256.0;

    /// (sin x, cos x) by the addition theorem for x = angle + ε with a small ε; otherwise computed directly, and x becomes the known angle.
    #[inline(always)]
    pub(crate) fn sin_cos(&mut self, x: f64) -> (f64, f64) {
        let turn = x - self.angle;
        // False for NaN.
        if turn.abs() <= Self::NEAR {
            let z = turn * turn;
            let sine = minus_product(turn, turn * z, minus_product(1.0 / 6.0, z, 1.0 / 120.0));
            let versine = z * minus_product(0.5, z, 1.0 / 24.0);
            let Known { sin, cos, .. } = *self;
            (sin + minus_product(cos * sine, sin, versine), cos - plus_product(sin * sine, cos, versine))
        } else {
            let (sin, cos) = sin_cos(x);
            *self = Known { angle: x, sin, cos };
            (sin, cos)
        }
    }
}

/// r = x − n π/2.
#[inline(always)]
fn reduced(x: f64, n: f64) -> f64 {
    minus_product(minus_product(x, n, FRAC_PI_2_HIGH), n, FRAC_PI_2_LOW)
}

/// sin r for |r| ≤ π/4.
#[inline(always)]
fn sine(r: f64) -> f64 {
    let z = r * r;
    let high = [
        8.333_333_333_322_489_461_24e-3,
        -1.984_126_982_985_794_931_34e-4,
        2.755_731_370_707_006_767_89e-6,
        -2.505_076_025_340_686_341_95e-8,
        1.589_690_995_211_550_102_21e-10,
    ];
    let sine = plus_product(r, z * r, plus_product(-1.666_666_666_666_663_243_48e-1, z, polynomial(z, high)));
    // The result has the sign of r, also of −0, which a sum loses.
    f64::from_bits(sine.to_bits() | (r.to_bits() & (1 << 63)))
}

/// cos r for |r| ≤ π/4; 1 − z/2 is split so that its rounding error is kept.
#[inline(always)]
fn cosine(r: f64) -> f64 {
    let z = r * r;
    let rest = [
        4.166_666_666_666_660_190_37e-2,
        -1.388_888_888_887_410_957_49e-3,
        2.480_158_728_947_672_941_78e-5,
        -2.755_731_435_139_066_330_35e-7,
        2.087_572_321_298_174_827_90e-9,
        -1.135_964_755_778_819_482_65e-11,
    ];
    let half = 0.5 * z;
    let main = 1.0 - half;
    main + plus_product((1.0 - main) - half, z * z, polynomial(z, rest))
}

#[cfg(test)]
mod tests {
    use super::{Known, sin_cos, sin_cos_lanes};

    #[test]
    fn angles_near_a_known_one_agree_to_rounding() {
        for k in -3000..3000 {
            let mut known = Known::NONE;
            let first = f64::from(k) * 0.0173;
            assert_eq!(known.sin_cos(first), sin_cos(first));
            for turn in [0.0, 1e-12, -3e-7, 2.1e-4, -0.003, 1.0 / 256.0, 0.004, -0.03, -0.5] {
                let x = first + turn;
                let ((s, c), (sin, cos)) = (known.sin_cos(x), x.sin_cos());
                assert!((s - sin).abs() <= 2.3e-16 && (c - cos).abs() <= 2.3e-16, "{x}: {s} {sin}, {c} {cos}");
                known = Known::NONE;
                known.sin_cos(first);
            }
        }
        let mut known = Known::NONE;
        assert!(known.sin_cos(f64::NAN).0.is_nan() && known.sin_cos(0.5) == sin_cos(0.5));
    }

    #[test]
    fn angles_side_by_side_are_those_one_by_one() {
        for k in -5000..5000 {
            let first = f64::from(k) * 0.0917;
            let x = [first, first + 1.3, -first, first * 1e-3];
            let (sines, cosines) = sin_cos_lanes(&x);
            x.iter().zip(sines.iter().zip(&cosines)).for_each(|(x, (s, c))| assert_eq!(sin_cos(*x), (*s, *c)));
        }
        assert!(sin_cos_lanes(&[f64::NAN, 0.5]).0[0].is_nan() && sin_cos_lanes(&[1e7]).0 == [1e7f64.sin()]);
    }

    #[test]
    fn agrees_with_the_standard_library_to_rounding() {
        let mut x = -1.1e5f64;
        while x < 1.1e5 {
            let ((s, c), (sin, cos)) = (sin_cos(x), x.sin_cos());
            assert!((s - sin).abs() <= 1.2e-16 && (c - cos).abs() <= 1.2e-16, "{x}: {s} {sin}, {c} {cos}");
            x += 0.731 + x.abs() * 1e-6;
        }
        for k in -40..40 {
            let x = f64::from(k) * std::f64::consts::FRAC_PI_4;
            for x in [x, x.next_up(), x.next_down(), x + 1e-9] {
                let ((s, c), (sin, cos)) = (sin_cos(x), x.sin_cos());
                assert!((s - sin).abs() <= 1.2e-16 && (c - cos).abs() <= 1.2e-16, "{x}: {s} {sin}, {c} {cos}");
            }
        }
        for x in [1e7, -3.3e8, 1e15] {
            assert_eq!(sin_cos(x), x.sin_cos());
        }
        for x in [f64::NAN, f64::INFINITY] {
            assert!(sin_cos(x).0.is_nan() && sin_cos(x).1.is_nan());
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
    }
}
