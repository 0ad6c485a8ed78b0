//! The known part of a stage, and its transpose: what the adjoint variables of later stages carry back to one.

use super::Scheme;
use crate::number::Real;

/// x̄ = x_n + Δt Σ_{j<s} a_sj ẋ_j, with the rate at node n and those of later stages.
#[inline]
pub(crate) fn known_part<'a, R: Real>(
    (scheme, s): (&Scheme, usize),
    dt: R,
    (x, rate): (&[R], &[R]),
    later: impl Fn(usize) -> &'a [R],
    into: &mut [R],
) {
    let first = dt * scheme.a(s, 0);
    into.iter_mut().zip(x.iter().zip(rate)).for_each(|(into, (x, rate))| *into = *x + first * *rate);
    for j in 1..s {
        let factor = dt * scheme.a(s, j);
        into.iter_mut().zip(later(j)).for_each(|(into, rate)| *into += factor * *rate);
    }
}

/// What adjoint variables of later stages add to the equations of a stage: A, B, α, β, and Σ e_r for compliances.
pub(crate) struct Carried {
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) alpha: Vec<f64>,
    pub(crate) beta: Vec<f64>,
    pub(crate) e: Vec<f64>,
    /// Whether e is asked for.
    pub(crate) with_compliance: bool,
}

impl Carried {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        let zeros = || vec![0.0; n];
        Carried { a: zeros(), b: zeros(), alpha: zeros(), beta: zeros(), e: vec![0.0; m], with_compliance: false }
    }

    pub(crate) fn clear(&mut self) {
        [&mut self.a, &mut self.b, &mut self.alpha, &mut self.beta, &mut self.e].into_iter().for_each(|list| list.fill(0.0));
    }
}

/// What the stages after stage s of a step of length Δt carry back to it (s = 0: to the node at which the step begins); `stage(r)` has a_r, b_r and e_r.
#[inline]
pub(crate) fn carried_part<'a>(
    (scheme, s): (&Scheme, usize),
    dt: f64,
    stage: impl Fn(usize) -> (&'a [f64], &'a [f64], &'a [f64]),
    into: &mut Carried,
) {
    if scheme.inner() > 0 {
        into.clear();
        for r in s + 1..=scheme.stages() {
            let ((a, b, e), factor) = (stage(r), dt * scheme.a(r, s));
            add(&mut into.alpha, factor, a);
            add(&mut into.beta, factor, b);
            if s == 0 {
                add(&mut into.a, 1.0, a);
                add(&mut into.b, 1.0, b);
                add(&mut into.e, 1.0, e);
            }
        }
        return;
    }
    // One stage: nothing is summed.
    let ((a, b, e), factor) = (stage(1), dt * scheme.a(1, 0));
    copy_both(&mut into.a, &mut into.alpha, factor, a);
    copy_both(&mut into.b, &mut into.beta, factor, b);
    if into.with_compliance {
        into.e.copy_from_slice(e);
    }
}

/// x, and a multiple of it.
#[inline(never)]
fn copy_both(once: &mut [f64], scaled: &mut [f64], factor: f64, x: &[f64]) {
    let (once, scaled) = (&mut once[..x.len()], &mut scaled[..x.len()]);
    for (k, x) in x.iter().enumerate() {
        once[k] = *x;
        scaled[k] = factor * x;
    }
}

fn add(sum: &mut [f64], factor: f64, x: &[f64]) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ_s (a_s, x̄_s) over a step, with the rates as variables: both sides of the transpose.
    #[test]
    fn the_carried_part_is_the_transpose_of_the_known_part() {
        for scheme in Scheme::ALL {
            let (stages, dt) = (scheme.stages(), 0.37);
            let number = |k: usize| [(1.0 + k as f64).sin()];
            let rates: Vec<_> = (0..=stages).map(number).collect();
            let adjoint: Vec<_> = (10..=10 + stages).map(number).collect();
            let x = [0.7];
            let mut known = [0.0];
            let by_known: f64 = (1..=stages)
                .map(|s| {
                    known_part((&scheme, s), dt, (&x, &rates[0]), |j| &rates[j][..], &mut known);
                    adjoint[s][0] * known[0]
                })
                .sum();
            let mut carried = Carried::new(1, 0);
            let mut by_carried = 0.0;
            for (s, rate) in rates.iter().enumerate().take(stages) {
                carried_part((&scheme, s), dt, |r| (&adjoint[r][..], &adjoint[r][..], &[]), &mut carried);
                by_carried += carried.alpha[0] * rate[0] + carried.a[0] * x[0];
            }
            assert!((by_known - by_carried).abs() < 1e-14, "{}: {by_known} {by_carried}", scheme.name);
        }
    }
}
