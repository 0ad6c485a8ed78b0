//! Powers, roots and arcsines at the ends of their domains, where the closed forms of their derivatives are 0 · ∞.
//!
//! A derivative that exists is returned (x^1.5 has the slope 0 at 0). One that does not exist is infinite, or NaN if its factor vanishes
//! too, as for √(x² + y²) at the origin. A number without derivatives has none afterwards either.

use num_dual::DualNum;

/// √x at x = 0.
///
/// arcosh(1 + x) has the same value and the same limits of all derivatives there: 0, ∞, −∞, …
pub(crate) fn sqrt_of_zero<T: DualNum<Primitive = f64> + Copy>(x: &T) -> T {
    (*x + T::one()).acosh()
}

/// xⁿ at x = 0 for a non-integer n > 0: the derivatives of lower order vanish, those of higher order are infinite.
pub(crate) fn power_of_zero<T: DualNum<Primitive = f64> + Copy>(x: &T, n: f64) -> T {
    if n < 1.0 {
        return sqrt_of_zero(x);
    }
    // Infinite multiples of xᵏ have exactly these derivatives (x √x would yield 0 · ∞); the vanishing ones are zero, not absent.
    let order = n.ceil() as i32;
    let infinite = (order..=T::NDERIV as i32).map(|k| x.powi(k) * f64::MAX * f64::MAX * f64::MAX);
    infinite.fold(x.powi(order), |sum, term| sum + term)
}

/// xⁿ for an integer n if xⁿ⁻³, which num-dual computes, is out of range.
pub(crate) fn powi_out_of_range<T: DualNum<Primitive = f64> + Copy>(x: &T, re: f64, n: i32) -> T {
    if re == 0.0 || re.is_infinite() {
        return x.recip().powi(n.saturating_neg());
    }
    // In two halves, since the value may vanish although its derivatives do not.
    (*x / re).powi(n) * re.powi(n / 2) * re.powi(n - n / 2)
}

/// xⁿ for a real n and x > 0 if xⁿ⁻³, which num-dual computes, is out of range.
pub(crate) fn powf_out_of_range<T: DualNum<Primitive = f64> + Copy>(x: &T, re: f64, n: f64) -> T {
    (*x / re).powf(n) * re.powf(0.5 * n) * re.powf(0.5 * n)
}

/// True if xⁿ and the lowest power that num-dual computes for this many derivatives neither vanish nor overflow. Numbers of moderate
/// size are recognised without computing powers.
#[inline]
pub(crate) fn is_in_range(re: f64, n: f64, derivatives: usize) -> bool {
    let lowest = n - 3.0 * derivatives as f64;
    let is_moderate = (1e-15..1e15).contains(&re.abs()) && n.abs().max(lowest.abs()) <= 20.0;
    is_moderate || [n, lowest].into_iter().all(|n| re.abs().powf(n) != 0.0 && re.abs().powf(n).is_finite())
}
