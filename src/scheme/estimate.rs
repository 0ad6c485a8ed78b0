//! Estimate of the local error of a step.
//!
//! ```text
//!   with embedded weights b̂      δ = Δt Σ_s (a_Ss − b̂_s) ẋ_s
//!   without                      δ = (x_{n+1} − x^) / (3 + 3/r),     x^ = x_n + ½ Δt ((2 + r) ẋ_n − r ẋ_{n−1}),     r = Δt/Δt₋
//!   at the first step            δ = x_{n+1} − x_n − Δt ẋ_n
//! ```
//!
//! The second formula is the difference from the explicit Adams–Bashforth extrapolation; to leading order, it is the local error −Δt³ x‴/12.

use super::Scheme;

impl Scheme {
    /// The power of Δt with which the estimate decreases.
    pub(crate) fn estimate_order(&self) -> usize {
        let other = if self.embedded.is_empty() { 2 } else { self.embedded_order };
        self.order.min(other) + 1
    }
}

/// Writes δ for x with the rates `rate(s)` at the stages 0 … S. `before`: Δt₋ and ẋ_{n−1} of the previous step, used without embedded weights.
pub(crate) fn local_error<'a>(
    scheme: &Scheme,
    dt: f64,
    rate: impl Fn(usize) -> &'a [f64],
    before: Option<(f64, &[f64])>,
    into: &mut [f64],
) {
    into.fill(0.0);
    let mut add = |factor: f64, rate: &[f64]| into.iter_mut().zip(rate).for_each(|(sum, rate)| *sum += factor * rate);
    if !scheme.embedded.is_empty() {
        for (s, embedded) in scheme.embedded.iter().enumerate() {
            add(dt * (scheme.weight(s) - embedded), rate(s));
        }
        return;
    }
    let Some((dt_before, rate_before)) = before else {
        (0..=scheme.stages()).for_each(|s| add(dt * scheme.weight(s), rate(s)));
        add(-dt, rate(0));
        return;
    };
    let r = dt / dt_before;
    let share = dt / (3.0 + 3.0 / r);
    (0..=scheme.stages()).for_each(|s| add(share * scheme.weight(s), rate(s)));
    add(-0.5 * share * (2.0 + r), rate(0));
    add(0.5 * share * r, rate_before);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_for_polynomials_are_the_errors_of_the_step() {
        // x = t³ from t = 0.3 on, and its rates 3 t².
        let (t, dt, dt_before) = (0.3, 0.2, 0.15);
        let rate = |t: f64| [3.0 * t * t];
        let rates = [rate(t), rate(t + dt)];
        let mut delta = [0.0];
        local_error(&Scheme::TRAPEZOIDAL, dt, |s| &rates[s][..], Some((dt_before, &rate(t - dt_before))), &mut delta);
        let step = 0.5 * dt * (rates[0][0] + rates[1][0]);
        let exact = (t + dt).powi(3) - t.powi(3);
        assert!((delta[0] - (step - exact)).abs() < 1e-15, "{} {}", delta[0], step - exact);
    }
}
