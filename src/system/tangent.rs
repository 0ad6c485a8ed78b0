//! From an element's second derivatives to the tangent matrix K of a step, and to adjoint products.
//!
//! With D± = (∂_v ± h ∂_q, ∂_σ), the tangent matrix of DESIGN's reduced step is K(h) = D₋ D₊ᵀ 𝓛 − h D₊ᵀ Q:
//!
//! ```text
//!   K_vv = 𝓛_vv + h 𝓛_vq − h (𝓛_qv + Q_v) − h² (𝓛_qq + Q_q)
//!   K_vσ = Φ_qᵀ − h (dΦ/dt)_qᵀ          K_σv = Φ_q + h (dΦ/dt)_q          K_σσ = 0
//! ```
//!
//! What comes from 𝓛 obeys K(−h) = K(h)ᵀ. The blocks of an element lie one after the other, by rows (see [`Jet::blocks`](super::jet::Jet::blocks)).

use super::batch::{Covector, StateRows};
use super::jet::ElementKind;

/// The blocks of one element with `a` active coordinates, by name.
struct Blocks<'a> {
    form: ElementKind,
    a: usize,
    squares: [&'a [f64]; 3],
    phi_q: &'a [f64],
    phi_dot_q: &'a [f64],
}

impl<'a> Blocks<'a> {
    fn new(form: ElementKind, a: usize, m: usize, blocks: &'a [f64]) -> Self {
        let square = |k: usize| if k < form.squares() { &blocks[k * a * a..(k + 1) * a * a] } else { &[][..] };
        let rest = &blocks[form.squares() * a * a..];
        let (phi_q, phi_dot_q) = rest.split_at(rest.len().min(m * a));
        Blocks { form, a, squares: [square(0), square(1), square(2)], phi_q, phi_dot_q }
    }

    /// K_vv, entry (i, j).
    fn k_vv(&self, h: f64, i: usize, j: usize) -> f64 {
        let [first, second, third] = self.squares;
        let (ij, ji) = (i * self.a + j, j * self.a + i);
        match self.form {
            ElementKind::Kinetic => first[ij] + h * (second[ij] - second[ji]) - h * h * third[ij],
            ElementKind::Potential => -h * h * first[ij],
            ElementKind::Applied => -h * first[ij] - h * h * second[ij],
            // σᵀΦ_qq is symmetric: h (𝓛_vq − 𝓛_qv) cancels.
            ElementKind::Holonomic => -h * h * second[ij],
        }
    }

    /// Rows i of (𝓛_vvᵀ c + (𝓛_qv + Q_v)ᵀ d) and of (𝓛_vqᵀ c + (𝓛_qq + Q_q)ᵀ d): the part with column j of the blocks.
    fn rows(&self, i: usize, j: usize, c: f64, d: f64) -> (f64, f64) {
        let [first, second, third] = self.squares;
        let (ij, ji) = (i * self.a + j, j * self.a + i);
        match self.form {
            ElementKind::Kinetic => (first[ji] * c + second[ij] * d, second[ji] * c + third[ji] * d),
            ElementKind::Potential => (0.0, first[ji] * d),
            ElementKind::Applied => (first[ji] * d, second[ji] * d),
            ElementKind::Holonomic => (first[ij] * d, first[ji] * c + second[ji] * d),
        }
    }
}

/// Adds an element's entries of K(h) at its slots: (v, v) by rows, then for each multiplier (σ, v) and (v, σ).
pub fn scatter(form: ElementKind, blocks: &[f64], a: usize, m: usize, slots: &[u32], h: f64, values: &mut [f64]) {
    let blocks = Blocks::new(form, a, m, blocks);
    let (square, coupling) = slots.split_at(a * a);
    for (k, &slot) in square.iter().enumerate() {
        values[slot as usize] += blocks.k_vv(h, k / a, k % a);
    }
    if blocks.phi_q.is_empty() {
        return;
    }
    let rows = blocks.phi_q.chunks_exact(a).zip(blocks.phi_dot_q.chunks_exact(a));
    for ((phi_q, phi_dot_q), slots) in rows.zip(coupling.chunks_exact(2 * a)) {
        let (below, beside) = slots.split_at(a);
        for k in 0..a {
            values[below[k] as usize] += phi_q[k] + h * phi_dot_q[k];
            values[beside[k] as usize] += phi_q[k] - h * phi_dot_q[k];
        }
    }
}

/// Adds to `rows` what an element contributes to the adjoint equations ∂v, ∂q and ∂σ:
///
/// ```text
///   v: 𝓛_vvᵀ c + (𝓛_qv + Q_v)ᵀ d + Φ_qᵀ e,   q: 𝓛_vqᵀ c + (𝓛_qq + Q_q)ᵀ d + (dΦ/dt)_qᵀ e,   σ: Φ_q c + (dΦ/dt)_q d
/// ```
pub fn pull_back(
    form: ElementKind,
    blocks: &[f64],
    active: &[usize],
    sigma: &[usize],
    with: &Covector,
    rows: &mut StateRows,
) {
    let a = active.len();
    let blocks = Blocks::new(form, a, sigma.len(), blocks);
    for (i, &row) in active.iter().enumerate() {
        for (j, &column) in active.iter().enumerate() {
            let (v, q) = blocks.rows(i, j, with.c[column], with.d[column]);
            rows.v[row] += v;
            rows.q[row] += q;
        }
    }
    if blocks.phi_q.is_empty() {
        return;
    }
    for ((phi_q, phi_dot_q), j) in
        blocks.phi_q.chunks_exact(a).zip(blocks.phi_dot_q.chunks_exact(a)).zip(sigma.iter().copied())
    {
        for (k, &i) in active.iter().enumerate() {
            rows.v[i] += phi_q[k] * with.e[j];
            rows.q[i] += phi_dot_q[k] * with.e[j];
            rows.sigma[j] += phi_q[k] * with.c[i] + phi_dot_q[k] * with.d[i];
        }
    }
}
