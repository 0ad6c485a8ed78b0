//! Norms and sums in four independent chains, which the processor computes in parallel; products that it may fuse with sums; and numbers
//! that are kept out of vectors.

use std::sync::atomic::{Ordering, compiler_fence};

/// The larger of two numbers, in a single instruction; `f64::max` also handles NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// True if the target processor multiplies and adds in one instruction, rounded once.
const IS_FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));

/// c − a b, rounded once if the target processor does so.
#[inline(always)]
pub(crate) fn minus_product(c: f64, a: f64, b: f64) -> f64 {
    if IS_FUSED { (-a).mul_add(b, c) } else { c - a * b }
}

/// c + a b, rounded once if the target processor does so.
#[inline(always)]
pub(crate) fn plus_product(c: f64, a: f64, b: f64) -> f64 {
    if IS_FUSED { a.mul_add(b, c) } else { c + a * b }
}

/// c₀ + c₁ z + c₂ z² + … by Horner's rule.
#[inline(always)]
pub(super) fn polynomial<const N: usize>(z: f64, coefficients: [f64; N]) -> f64 {
    coefficients.into_iter().rev().reduce(|sum, c| plus_product(c, z, sum)).unwrap_or(0.0)
}

/// The maximum norm; NaN is ignored.
pub(crate) fn largest(x: &[f64]) -> f64 {
    let (chunks, rest) = x.as_chunks::<4>();
    let mut lanes = [0.0; 4];
    for chunk in chunks {
        for (lane, x) in lanes.iter_mut().zip(chunk) {
            *lane = larger(*lane, x.abs());
        }
    }
    lanes.iter().chain(rest).fold(0.0, |size, x| larger(size, x.abs()))
}

/// True if no entry is infinite or NaN.
pub(crate) fn all_finite(x: &[f64]) -> bool {
    let (chunks, rest) = x.as_chunks::<4>();
    let mut lanes = [0.0; 4];
    for chunk in chunks {
        // 0 · x is 0 for finite numbers and NaN for all others.
        for (lane, x) in lanes.iter_mut().zip(chunk) {
            *lane += x * 0.0;
        }
    }
    rest.iter().fold(total(lanes), |sum, x| sum + x * 0.0) == 0.0
}

/// Visits the entries of two lists in pairs, four at a time: half of the time of a short loop is the loop itself.
#[inline(always)]
pub(crate) fn by_fours<X, Y>(x: &[X], y: &[Y], mut each: impl FnMut(&X, &Y)) {
    debug_assert_eq!(x.len(), y.len());
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<4>(), y.as_chunks::<4>());
    for ([x0, x1, x2, x3], [y0, y1, y2, y3]) in x.iter().zip(y) {
        each(x0, y0);
        each(x1, y1);
        each(x2, y2);
        each(x3, y3);
    }
    x_rest.iter().zip(y_rest).for_each(|(x, y)| each(x, y));
}

/// y_i := x at index `places[i]`, four at a time.
#[inline]
pub(crate) fn take(x: &[f64], places: &[usize], y: &mut [f64]) {
    let ((places, places_rest), (y, y_rest)) = (places.as_chunks::<4>(), y.as_chunks_mut::<4>());
    y.iter_mut().zip(places).for_each(|(y, places)| *y = places.map(|place| x[place]));
    y_rest.iter_mut().zip(places_rest).for_each(|(y, &place)| *y = x[place]);
}

/// x += y, in a function whose arguments are known not to overlap.
#[inline]
pub(crate) fn add(x: &mut [f64], y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += y);
}

/// The scalar product; the vectors have the same length.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<4>(), y[..x.len()].as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (x, y) in x.iter().zip(y) {
        for k in 0..4 {
            sums[k] = plus_product(sums[k], x[k], y[k]);
        }
    }
    total(sums) + x_rest.iter().zip(y_rest).fold(0.0, |sum, (x, y)| plus_product(sum, *x, *y))
}

/// Adds xᵀ(a y + b z) to four partial sums; the vectors have the same length.
#[inline(always)]
pub(crate) fn add_dot(x: &[f64], (a, y): (f64, &[f64]), (b, z): (f64, &[f64]), sums: &mut [f64; 4]) {
    let (y, z) = (&y[..x.len()], &z[..x.len()]);
    let ((x, x_rest), (y, y_rest), (z, z_rest)) = (x.as_chunks::<4>(), y.as_chunks::<4>(), z.as_chunks::<4>());
    for (x, (y, z)) in x.iter().zip(y.iter().zip(z)) {
        for k in 0..4 {
            sums[k] = plus_product(sums[k], x[k], plus_product(a * y[k], b, z[k]));
        }
    }
    for ((sum, x), (y, z)) in sums.iter_mut().zip(x_rest).zip(y_rest.iter().zip(z_rest)) {
        *sum = plus_product(*sum, *x, plus_product(a * y, b, *z));
    }
}

/// The total of partial sums, in the order in which registers hold their halves.
#[inline(always)]
pub(crate) fn total(sums: [f64; 4]) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// Keeps the compiler from combining the number just read or written with the next one in a vector.
///
/// For solves with few unknowns, which read numbers written a moment ago: a load of a vector whose numbers were written one by one waits
/// until all are stored, and vectors of two or three take more shuffles than they save (3 % of the gradient of a cart with three links,
/// 8 % if it is built for AVX-512).
#[inline(always)]
pub(crate) fn singly() {
    compiler_fence(Ordering::SeqCst);
}

/// Copies number by number between slices of the same length.
#[inline(always)]
pub(crate) fn copy_singly(from: &[f64], to: &mut [f64]) {
    debug_assert_eq!(from.len(), to.len(), "numbers to copy");
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
        singly();
    }
}

#[cfg(test)]
mod tests {
    use super::{add_dot, all_finite, by_fours, copy_singly, dot, largest, take, total};

    #[test]
    fn chains_agree_with_plain_loops_for_every_length() {
        for len in 0..11 {
            let x: Vec<f64> = (0..len).map(|k| f64::from(k * 7 % 5) - 2.5).collect();
            let y: Vec<f64> = (0..len).map(f64::from).collect();
            assert_eq!(largest(&x), x.iter().fold(0.0, |a: f64, b| a.max(b.abs())));
            assert_eq!(dot(&x, &y), x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>());
            let mut sums = [1.0, 2.0, 3.0, 4.0];
            add_dot(&x, (0.5, &y), (2.0, &x), &mut sums);
            assert_eq!(total(sums), 10.0 + x.iter().zip(&y).map(|(x, y)| x * (0.5 * y + 2.0 * x)).sum::<f64>());
            assert!(all_finite(&x));
            let mut pairs = Vec::new();
            by_fours(&x, &y, |x, y| pairs.push((*x, *y)));
            assert!(pairs.into_iter().eq(x.iter().copied().zip(y.iter().copied())));
            let (places, mut taken) = ((0..x.len()).rev().collect::<Vec<_>>(), vec![f64::NAN; x.len()]);
            take(&x, &places, &mut taken);
            assert!(taken.iter().eq(x.iter().rev()));
            copy_singly(&x, &mut taken);
            assert_eq!(taken, x);
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!((0..x.len()).all(|k| {
                    let mut x = x.clone();
                    x[k] = bad;
                    !all_finite(&x)
                }));
            }
        }
    }
}
