//! Constraints that are sums of multiples of q_i, sin q_i and cos q_i. Most planar joints are of this form; nothing is differentiated at run time.
//!
//! They are detected in the graphs when the scene is compiled; their coefficients are computed once per set of design variables. With
//! Φ_j = … + α sin q + β cos q for one coordinate q, v = q̇, and A = Σ_j σ_j α_j, B = Σ_j σ_j β_j over the equations of q,
//!
//! ```text
//!   Φ_q = α cos q − β sin q            (dΦ/dt)_q = −v (α sin q + β cos q)
//!   𝓛_v += A cos q − B sin q =: s      𝓛_vq = 𝓛_qv = −(A sin q + B cos q) =: s′       𝓛_q += v s′       𝓛_qq = −v s
//! ```
//!
//! The tests compare these expressions with the plain formulas.

use super::products::Entries;
use crate::number::{Known, minus_product, plus_product};
use crate::system::cost::CostRows;
use crate::system::formula::{Block, Covector, NodeView};

/// α sin q + β cos q in one equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinusoidalTerm {
    pub coordinate: usize,
    pub equation: usize,
    pub sine: f64,
    pub cosine: f64,
}

// Indices have 32 bits, so that the data of long chains stay in the first-level cache.

/// A coordinate and its data in all equations that contain its sine or cosine.
#[derive(Clone, Debug)]
struct Angle {
    coordinate: u32,
    /// The position of its velocity in the solver's order.
    position: u32,
    /// The slot of K_vv of the coordinate.
    diagonal: u32,
    /// The number of terms.
    terms: u32,
    /// Sine and cosine known from the current step.
    known: Known,
}

/// The term of an angle in one equation.
#[derive(Clone, Debug)]
struct Term {
    equation: u32,
    /// The position of the equation's multiplier in the solver's order.
    position: u32,
    /// The slots of K_σv and K_vσ.
    below: u32,
    beside: u32,
    sine: f64,
    cosine: f64,
}

/// All sinusoidal constraints of a scene, sorted by coordinate: the terms of the first angle, those of the second, …
#[derive(Clone, Debug, Default)]
pub struct Sines {
    angles: Vec<Angle>,
    terms: Vec<Term>,
}

/// Stored state of an angle at a node: sine, cosine, v, and the sums s and s′ over its equations.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    sin: f64,
    cos: f64,
    v: f64,
    s: f64,
    s_prime: f64,
}

/// The length of a state in the blocks.
const STATE: usize = 5;

impl State {
    fn of(block: &[f64; STATE]) -> Self {
        let [sin, cos, v, s, s_prime] = *block;
        State { sin, cos, v, s, s_prime }
    }
}

impl Term {
    /// Φ_q.
    #[inline]
    fn phi_q(&self, at: &State) -> f64 {
        self.sine * at.cos - self.cosine * at.sin
    }

    /// (dΦ/dt)_q.
    #[inline]
    fn phi_dot_q(&self, at: &State) -> f64 {
        -(self.sine * (at.v * at.sin) + self.cosine * (at.v * at.cos))
    }
}

/// Splits off the terms of an angle, which come first in `later`.
#[inline(always)]
fn take<'a>(later: &mut &'a [Term], angle: &Angle) -> &'a [Term] {
    let (own, rest) = later.split_at(angle.terms as usize);
    *later = rest;
    own
}

/// A = Σ x_j α_j and B = Σ x_j β_j over the terms of an angle.
#[inline(always)]
fn sums(terms: &[Term], x: &[f64]) -> [f64; 2] {
    terms.iter().fold([0.0; 2], |[a, b], term| {
        let x = x[term.equation as usize];
        [a + x * term.sine, b + x * term.cosine]
    })
}

/// The positions of the unknowns and the slots of the entries of K; unknown n + j is the multiplier of equation j.
pub struct Places<P, S> {
    pub n: usize,
    pub position: P,
    pub slot: S,
}

impl Sines {
    /// Sorts the terms by coordinate.
    pub fn new<P: Fn(usize) -> usize, S: Fn(usize, usize) -> usize>(
        mut waves: Vec<SinusoidalTerm>,
        places: &Places<P, S>,
    ) -> Self {
        waves.sort_by_key(|wave| (wave.coordinate, wave.equation));
        let mut sines = Sines::default();
        for run in waves.chunk_by(|a, b| a.coordinate == b.coordinate) {
            let coordinate = run[0].coordinate;
            let (position, slot) = (|unknown| (places.position)(unknown) as u32, |row, col| (places.slot)(row, col) as u32);
            sines.terms.extend(run.iter().map(|wave| {
                let row = places.n + wave.equation;
                Term {
                    equation: wave.equation as u32,
                    position: position(row),
                    below: slot(row, coordinate),
                    beside: slot(coordinate, row),
                    sine: wave.sine,
                    cosine: wave.cosine,
                }
            }));
            sines.angles.push(Angle {
                coordinate: coordinate as u32,
                position: position(coordinate),
                diagonal: slot(coordinate, coordinate),
                terms: run.len() as u32,
                known: Known::NONE,
            });
        }
        sines
    }

    /// Sets the coefficients for other design variables; the terms are those given to `new`, in any order.
    pub fn set_coefficients(&mut self, waves: &mut [SinusoidalTerm]) {
        waves.sort_by_key(|wave| (wave.coordinate, wave.equation));
        for (term, wave) in self.terms.iter_mut().zip(waves) {
            (term.sine, term.cosine) = (wave.sine, wave.cosine);
        }
    }

    /// The coordinates whose sines and cosines occur.
    pub fn coordinates(&self) -> impl Iterator<Item = usize> + '_ {
        self.angles.iter().map(|angle| angle.coordinate as usize)
    }

    /// The number of angles.
    pub fn angles(&self) -> usize {
        self.angles.len()
    }

    /// The length of the states of all angles at a node.
    pub fn block_len(&self) -> usize {
        STATE * self.angles.len()
    }

    fn states<'a>(&'a self, blocks: &'a [f64]) -> impl Iterator<Item = (&'a Angle, &'a [Term], State)> {
        let states = blocks.as_chunks::<STATE>().0.iter().map(State::of);
        let mut later = &self.terms[..];
        self.angles.iter().zip(states).map(move |(angle, state)| (angle, take(&mut later, angle), state))
    }

    /// Clears the stored sines and cosines, so that a step does not depend on earlier computations.
    pub fn forget(&mut self) {
        self.angles.iter_mut().for_each(|angle| angle.known = Known::NONE);
    }

    /// Subtracts the nonlinear part of r_v = 𝓛_v − h 𝓛_q and r_σ = dΦ/dt, with q = q₋ + h (v₋ + v) and (v, σ) in the solver's order.
    pub fn subtract_residual(&mut self, start_q: &[f64], h: f64, x: &[f64], r: &mut [f64], blocks: &mut [f64]) {
        let (r, mut later) = (&mut r[..x.len()], &self.terms[..]);
        for (angle, block) in self.angles.iter_mut().zip(blocks.as_chunks_mut::<STATE>().0) {
            let position = angle.position as usize;
            let v = x[position];
            let (sin, cos) = angle.known.sin_cos(start_q[angle.coordinate as usize] + h * v);
            let (v_sin, v_cos) = (v * sin, v * cos);
            let (mut a, mut b) = (0.0, 0.0);
            for term in take(&mut later, angle) {
                let position = term.position as usize;
                let sigma = x[position];
                a = plus_product(a, sigma, term.sine);
                b = plus_product(b, sigma, term.cosine);
                r[position] = plus_product(minus_product(r[position], term.sine, v_cos), term.cosine, v_sin);
            }
            let (s, s_prime) = (a * cos - b * sin, -(a * sin + b * cos));
            r[position] -= s - h * v * s_prime;
            *block = [sin, cos, v, s, s_prime];
        }
    }

    /// Adds the nonlinear part of Φ.
    pub fn add_phi(&self, blocks: &[f64], phi: &mut [f64]) {
        for (_, terms, at) in self.states(blocks) {
            terms.iter().for_each(|term| phi[term.equation as usize] += term.sine * at.sin + term.cosine * at.cos);
        }
    }

    /// Adds K(h): h² v s on the diagonal, and off the diagonal, with θ = h v,
    ///
    /// ```text
    ///   Φ_q ± h (dΦ/dt)_q = α (cos q ∓ θ sin q) − β (sin q ± θ cos q)
    /// ```
    pub fn scatter(&self, blocks: &[f64], h: f64, values: &mut [f64]) {
        for (angle, terms, at) in self.states(blocks) {
            let theta = h * at.v;
            values[angle.diagonal as usize] += h * theta * at.s;
            let (below_cos, below_sin) = (at.cos - theta * at.sin, at.sin + theta * at.cos);
            let (beside_cos, beside_sin) = (at.cos + theta * at.sin, at.sin - theta * at.cos);
            for term in terms {
                let (below, beside) = (term.below as usize, term.beside as usize);
                values[below] = minus_product(plus_product(values[below], term.sine, below_cos), term.cosine, below_sin);
                values[beside] = minus_product(plus_product(values[beside], term.sine, beside_cos), term.cosine, beside_sin);
            }
        }
    }

    /// Adds the derivatives, with respect to the state, of the change of ψ = c·𝓛_v + d·𝓛_q + e·dΦ/dt along a direction. Let ŝ and ŝ′ be s and s′ with
    /// e in place of σ, and let ṡ and ṡ′ be s and s′ with the σ of the direction. Then
    ///
    /// ```text
    ///   ψ_q = c s′ − d v s + v ŝ′      ψ_v = d s′ + ŝ      ψ_σ = c Φ_q + d (dΦ/dt)_q
    /// ```
    pub fn pull_back_along(&self, blocks: &[f64], along: &NodeView<f64>, with: &Covector, rows: &mut CostRows) {
        for (angle, terms, at) in self.states(blocks) {
            let i = angle.coordinate as usize;
            let (q, v, c, d) = (along.q[i], along.v[i], with.c[i], with.d[i]);
            // The change of ψ_σ = α of_sine + β of_cosine.
            let of_sine = -c * at.sin * q - d * (v * at.sin + at.v * at.cos * q);
            let of_cosine = -c * at.cos * q - d * (v * at.cos - at.v * at.sin * q);
            for term in terms {
                rows.sigma[term.equation as usize] += term.sine * of_sine + term.cosine * of_cosine;
            }
            let both = |[a, b]: [f64; 2]| [a * at.cos - b * at.sin, -(a * at.sin + b * at.cos)];
            let [s, s_prime] = both(sums(terms, along.sigma));
            let [s_of_e, s_prime_of_e] = both(sums(terms, with.e));
            let of_c = s_prime - at.s * q;
            rows.q[i] += c * of_c - d * (v * at.s + at.v * (at.s_prime * q + s)) + v * s_prime_of_e - at.v * s_of_e * q;
            rows.v[i] += d * of_c + s_prime_of_e * q;
        }
    }
}

impl Entries for Sines {
    #[inline(always)]
    fn each(&self, blocks: &[f64], mut visit: impl FnMut(Block, [usize; 2], f64)) {
        for (angle, terms, at) in self.states(blocks) {
            let i = angle.coordinate as usize;
            visit(Block::PhiQq, [i, i], at.s_prime);
            visit(Block::PhiDotQq, [i, i], -at.v * at.s);
            for term in terms {
                let equation = term.equation as usize;
                visit(Block::PhiQ, [equation, i], term.phi_q(&at));
                visit(Block::PhiDotQ, [equation, i], term.phi_dot_q(&at));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two angles in three equations, and one state for each angle.
    fn sample() -> (Sines, [f64; 2 * STATE]) {
        let wave = |coordinate, equation, sine, cosine| SinusoidalTerm { coordinate, equation, sine, cosine };
        let waves = vec![wave(2, 1, 0.3, -0.4), wave(0, 0, 0.5, 0.7), wave(2, 0, -0.2, 0.9), wave(0, 2, 0.0, 1.1)];
        let places = Places { n: 3, position: |unknown| 5 - unknown, slot: |row, col| 6 * row + col };
        (Sines::new(waves, &places), [0.6, 0.8, 1.3, 0.2, -0.7, -0.28, 0.96, -0.4, 1.9, 0.35])
    }

    #[test]
    fn entries_of_the_tangent_matrix_are_those_of_the_formulas() {
        let (sines, blocks) = sample();
        let h = 0.37;
        let mut values = [0.0; 36];
        sines.scatter(&blocks, h, &mut values);
        for (angle, terms, at) in sines.states(&blocks) {
            let i = angle.coordinate as usize;
            assert!((values[7 * i] - h * h * at.v * at.s).abs() < 1e-15);
            for term in terms {
                let row = 3 + term.equation as usize;
                let (phi_q, h_phi_dot_q) = (term.phi_q(&at), h * term.phi_dot_q(&at));
                assert!((values[6 * row + i] - (phi_q + h_phi_dot_q)).abs() < 1e-15);
                assert!((values[6 * i + row] - (phi_q - h_phi_dot_q)).abs() < 1e-15);
            }
        }
    }
}
