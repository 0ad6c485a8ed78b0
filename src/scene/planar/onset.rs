//! The normal force of contacts and stops as a function of the depth: a power with a kink, or with a smooth onset.

use crate::Scalar;

/// The normal force N of a contact or a stop, from the depth δ, its rate and [k, c, w].
///
/// Without a width, N = k max(δ, 0)ⁿ max(1 + c dδ/dt, 0). With a width w, the power is rounded over 0 < δ < w and the damping factor over
/// 0 < 1 + c dδ/dt < ½, so that N has continuous second derivatives ([`rounded_power`]).
pub(super) fn normal_force<S: Scalar>(is_smooth: bool, n: f64, [depth, rate]: [S; 2], [k, c, w]: [S; 3]) -> S {
    let damping = S::one() + c * rate;
    match is_smooth {
        true => k * w.powf(n) * rounded_power(depth / w, n) * rounded_power(damping * 2.0, 1.0) * 0.5,
        false => k * depth.max(S::zero()).powf(n) * damping.max(S::zero()),
    }
}

/// max(x, 0)ⁿ, n ≥ 1, rounded over the unit interval: xⁿ t² (1 + 2 r + 3 r²) with t = min(x, 1) and r = 1 − t. The first and second derivatives of
/// the factor vanish at t = 1, those of the product at x = 0.
fn rounded_power<S: Scalar>(x: S, n: f64) -> S {
    // At 0 the constant is selected, so that the power has no infinite derivative there.
    let x = S::zero().max(x);
    let t = x.min(S::one());
    let r = S::one() - t;
    // The factor of t alone is multiplied first, so that programs recognise that its derivatives vanish.
    t * t * (r * (r * 3.0 + 2.0) + 1.0) * x.powf(n)
}
