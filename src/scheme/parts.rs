//! The known part of a stage, and its transpose: the contributions of the adjoint variables of later stages.

use super::Scheme;
use crate::number::Real;

/// x̄ = x_n + Δt Σ_{j<s} a_sj ẋ_j, from x and its rate at node n and from the rates at the stages 1 … s − 1.
#[inline]
pub(crate) fn known_part<'a, R: Real>(
    (scheme, s): (&Scheme, usize),
    dt: R,
    (x, rate): (&[R], &[R]),
    later: impl Fn(usize) -> &'a [R],
    into: &mut [R],
) {
    let (n, first) = (into.len(), dt * scheme.a(s, 0));
    let (x, rate) = (&x[..n], &rate[..n]);
    for k in 0..n {
        into[k] = x[k] + first * rate[k];
    }
    for j in 1..s {
        let factor = dt * scheme.a(s, j);
        into.iter_mut().zip(later(j)).for_each(|(into, rate)| *into += factor * *rate);
    }
}

/// The adjoint variables of a stage: a and b of x_s = …, c of p* = 𝓛_v, d of g = 𝓛_q + Q, and e of dΦ/dt = 0.
#[derive(Clone, Default)]
pub(crate) struct StageAdjoint {
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) c: Vec<f64>,
    pub(crate) d: Vec<f64>,
    pub(crate) e: Vec<f64>,
}

impl StageAdjoint {
    pub(crate) fn clear(&mut self) {
        [&mut self.a, &mut self.b, &mut self.c, &mut self.d, &mut self.e].into_iter().for_each(|list| list.fill(0.0));
    }
}

/// Contributions of the adjoint variables of later stages to the equations of a stage: A, B, Σ e_r for compliances, α and β.
///
/// α is `factor` A + `alpha`: with one stage it is a multiple of A, and no sum is needed.
pub(crate) struct Carried {
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) e: Vec<f64>,
    pub(crate) factor: f64,
    pub(crate) alpha: Vec<f64>,
    pub(crate) beta: Vec<f64>,
}

impl Carried {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        let zeros = || vec![0.0; n];
        Carried { a: zeros(), b: zeros(), e: vec![0.0; m], factor: 0.0, alpha: zeros(), beta: zeros() }
    }

    pub(crate) fn clear(&mut self) {
        [&mut self.a, &mut self.b, &mut self.e, &mut self.alpha, &mut self.beta].into_iter().for_each(|list| list.fill(0.0));
        self.factor = 0.0;
    }

    pub(crate) fn copy_from(&mut self, other: &Carried) {
        self.clear();
        self.add_multiple(1.0, other);
    }

    /// Adds a multiple of the contributions at the same place.
    pub(crate) fn add_multiple(&mut self, factor: f64, other: &Carried) {
        let Carried { a, b, e, alpha, beta, .. } = self;
        let pairs = [(a, &other.a), (b, &other.b), (e, &other.e), (alpha, &other.alpha), (beta, &other.beta)];
        pairs.into_iter().for_each(|(own, other)| add(own, factor, other));
        self.factor = other.factor;
    }

    /// Moves the adjoint variables of the only stage of a step here; they are not needed there any more.
    #[inline]
    fn take(&mut self, only: &mut StageAdjoint, factor: f64) {
        std::mem::swap(&mut self.a, &mut only.a);
        std::mem::swap(&mut self.b, &mut only.b);
        std::mem::swap(&mut self.e, &mut only.e);
        self.factor = factor;
    }

    // A separate function: it is not needed with one stage.
    #[inline(never)]
    fn sum(&mut self, (scheme, s): (&Scheme, usize), dt: f64, stages: &[StageAdjoint]) {
        self.clear();
        for r in s + 1..=scheme.stages() {
            let (stage, factor) = (&stages[r - 1], dt * scheme.a(r, s));
            add(&mut self.alpha, factor, &stage.a);
            add(&mut self.beta, factor, &stage.b);
            if s == 0 {
                add(&mut self.a, 1.0, &stage.a);
                add(&mut self.b, 1.0, &stage.b);
                add(&mut self.e, 1.0, &stage.e);
            }
        }
    }

    /// α and β of coordinate k.
    #[inline]
    pub(crate) fn alpha_and_beta(&self, k: usize) -> (f64, f64) {
        (self.factor * self.a[k] + self.alpha[k], self.factor * self.b[k] + self.beta[k])
    }
}

/// Contributions of the stages s + 1 … S, with the adjoint variables `stages`, to stage s of a step of length Δt. For s = 0 they belong to the node
/// at which the step begins; `stages` is not needed afterwards.
#[inline]
pub(crate) fn carried_part((scheme, s): (&Scheme, usize), dt: f64, stages: &mut [StageAdjoint], into: &mut Carried) {
    match stages {
        [only] => into.take(only, dt * scheme.a(1, 0)),
        _ => into.sum((scheme, s), dt, stages),
    }
}

fn add(sum: &mut [f64], factor: f64, x: &[f64]) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares Σ_s (a_s, x̄_s) over a step, computed with the known part, with the same sum computed with the carried part.
    #[test]
    fn the_carried_part_is_the_transpose_of_the_known_part() {
        for scheme in Scheme::ALL {
            let (stages, dt) = (scheme.stages(), 0.37);
            let number = |k: usize| [(1.0 + k as f64).sin()];
            let rates: Vec<_> = (0..=stages).map(number).collect();
            let number = |k: usize| vec![(1.0 + k as f64).sin()];
            let adjoint = |s: usize| StageAdjoint { a: number(10 + s), b: number(10 + s), ..StageAdjoint::default() };
            let mut adjoints: Vec<StageAdjoint> = (1..=stages).map(adjoint).collect();
            let x = [0.7];
            let mut known = [0.0];
            let by_known: f64 = (1..=stages)
                .map(|s| {
                    known_part((&scheme, s), dt, (&x, &rates[0]), |j| &rates[j][..], &mut known);
                    adjoints[s - 1].a[0] * known[0]
                })
                .sum();
            let mut carried = Carried::new(1, 0);
            let mut by_carried = 0.0;
            for s in (0..stages).rev() {
                carried_part((&scheme, s), dt, &mut adjoints, &mut carried);
                by_carried += carried.alpha_and_beta(0).0 * rates[s][0] + if s == 0 { carried.a[0] * x[0] } else { 0.0 };
            }
            assert!((by_known - by_carried).abs() < 1e-14, "{}: {by_known} {by_carried}", scheme.name);
        }
    }
}
