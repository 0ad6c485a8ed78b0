//! Products of short vectors that are subtracted in place.

use crate::number::minus_product;

/// y := y − factor·x.
#[inline(always)]
pub(super) fn subtract(factor: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = minus_product(*y, factor, *x);
    }
}

/// start − xᵀy; the last products are subtracted last, because they are available last.
#[inline(always)]
pub(super) fn minus_dot(start: f64, x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).fold(start, |sum, (x, y)| minus_product(sum, *x, *y))
}

/// target −= (products of each line of `outer` with each line of `inner`), the latter varying fastest;
/// the lines have s entries.
#[inline(always)]
pub(super) fn subtract_products(s: usize, mut target: &mut [f64], outer: &[f64], inner: &[f64]) {
    for p in outer.chunks_exact(s) {
        let (line, more) = target.split_at_mut(inner.len() / s);
        for (entry, q) in line.iter_mut().zip(inner.chunks_exact(s)) {
            *entry = minus_dot(*entry, p, q);
        }
        target = more;
    }
}
