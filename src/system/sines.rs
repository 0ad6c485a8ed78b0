//! Constraints that are sums of q_i, sin q_i and cos q_i: most planar joints, and nothing to differentiate at run time.
//!
//! Tracing finds them when the scene is compiled; their coefficients are read off by dual numbers once per set of design variables. With
//! Φ_j = … + α sin q + β cos q for one coordinate q, v = q̇, and A = Σ_j σ_j α_j, B = Σ_j σ_j β_j over its equations,
//!
//! ```text
//!   Φ_q = α cos q − β sin q            (dΦ/dt)_q = −v (α sin q + β cos q)
//!   𝓛_v += A cos q − B sin q =: s      𝓛_vq = 𝓛_qv = −(A sin q + B cos q) =: s′       𝓛_q += v s′       𝓛_qq = −v s
//! ```
//!
//! The plain formulas hold these expressions to account in the tests.

use super::batch::{Covector, Rows};
use crate::sincos::sin_cos;

/// α sin q + β cos q in one equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    pub coordinate: usize,
    pub equation: usize,
    pub sine: f64,
    pub cosine: f64,
}

/// One coordinate with all its equations.
#[derive(Clone, Debug)]
struct Angle {
    coordinate: usize,
    /// The place of its velocity in the solver's order.
    position: usize,
    /// Where K_vv of the coordinate is stored.
    diagonal: usize,
    terms: std::ops::Range<usize>,
}

/// One equation of an angle.
#[derive(Clone, Debug)]
struct Term {
    equation: usize,
    /// The place of its multiplier in the solver's order.
    position: usize,
    /// Where K_σv and K_vσ are stored.
    below: usize,
    beside: usize,
    sine: f64,
    cosine: f64,
}

/// All sinusoidal constraints of a scene, by coordinate.
#[derive(Clone, Debug, Default)]
pub struct Sines {
    angles: Vec<Angle>,
    terms: Vec<Term>,
}

/// What is kept of an angle at a node: v and, of the sums over its equations, s and s′.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    sin: f64,
    cos: f64,
    v: f64,
    s: f64,
    s_prime: f64,
}

/// The length of a state among the blocks.
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
        -at.v * (self.sine * at.sin + self.cosine * at.cos)
    }
}

/// Where the unknowns and the entries of K are stored; unknown n + j is the multiplier of equation j.
pub struct Places<P, S> {
    pub n: usize,
    pub position: P,
    pub slot: S,
}

impl Sines {
    /// Sorts waves by coordinate.
    pub fn new<P: Fn(usize) -> usize, S: Fn(usize, usize) -> usize>(mut waves: Vec<Wave>, places: &Places<P, S>) -> Self {
        waves.sort_by_key(|wave| (wave.coordinate, wave.equation));
        let mut sines = Sines::default();
        for run in waves.chunk_by(|a, b| a.coordinate == b.coordinate) {
            let (coordinate, first) = (run[0].coordinate, sines.terms.len());
            sines.terms.extend(run.iter().map(|wave| {
                let row = places.n + wave.equation;
                Term {
                    equation: wave.equation,
                    position: (places.position)(row),
                    below: (places.slot)(row, coordinate),
                    beside: (places.slot)(coordinate, row),
                    sine: wave.sine,
                    cosine: wave.cosine,
                }
            }));
            sines.angles.push(Angle {
                coordinate,
                position: (places.position)(coordinate),
                diagonal: (places.slot)(coordinate, coordinate),
                terms: first..sines.terms.len(),
            });
        }
        sines
    }

    /// Takes over coefficients for other design variables; the waves are those of `new`, in any order.
    pub fn set_coefficients(&mut self, waves: &mut [Wave]) {
        waves.sort_by_key(|wave| (wave.coordinate, wave.equation));
        for (term, wave) in self.terms.iter_mut().zip(waves) {
            (term.sine, term.cosine) = (wave.sine, wave.cosine);
        }
    }

    /// The number of angles.
    pub fn angles(&self) -> usize {
        self.angles.len()
    }

    /// The length of what is kept of a node.
    pub fn block_len(&self) -> usize {
        STATE * self.angles.len()
    }

    fn each<'a>(&'a self, blocks: &'a [f64]) -> impl Iterator<Item = (&'a Angle, &'a [Term], State)> {
        let states = blocks.as_chunks::<STATE>().0.iter().map(State::of);
        self.angles.iter().zip(states).map(|(angle, state)| (angle, &self.terms[angle.terms.clone()], state))
    }

    /// Subtracts the nonlinear part of r_v = 𝓛_v − h 𝓛_q and r_σ = dΦ/dt, with q = q₋ + h (v₋ + v) and (v, σ) in the solver's order.
    pub fn subtract_residual(&self, start_q: &[f64], h: f64, x: &[f64], r: &mut [f64], blocks: &mut [f64]) {
        let r = &mut r[..x.len()];
        for (angle, block) in self.angles.iter().zip(blocks.as_chunks_mut::<STATE>().0) {
            let v = x[angle.position];
            let (sin, cos) = sin_cos(start_q[angle.coordinate] + h * v);
            let (v_sin, v_cos) = (v * sin, v * cos);
            let (mut a, mut b) = (0.0, 0.0);
            for term in &self.terms[angle.terms.clone()] {
                let sigma = x[term.position];
                a += sigma * term.sine;
                b += sigma * term.cosine;
                r[term.position] -= term.sine * v_cos - term.cosine * v_sin;
            }
            let (s, s_prime) = (a * cos - b * sin, -(a * sin + b * cos));
            r[angle.position] -= s - h * v * s_prime;
            *block = [sin, cos, v, s, s_prime];
        }
    }

    /// Adds 𝓛_q.
    pub fn add_force(&self, blocks: &[f64], force: &mut [f64]) {
        for (angle, _, at) in self.each(blocks) {
            force[angle.coordinate] += at.v * at.s_prime;
        }
    }

    /// Adds K(h): h² v s on the diagonal, Φ_q ± h (dΦ/dt)_q beside it.
    pub fn scatter(&self, blocks: &[f64], h: f64, values: &mut [f64]) {
        for (angle, terms, at) in self.each(blocks) {
            values[angle.diagonal] += h * h * at.v * at.s;
            for term in terms {
                let (phi_q, h_phi_dot_q) = (term.phi_q(&at), h * term.phi_dot_q(&at));
                values[term.below] += phi_q + h_phi_dot_q;
                values[term.beside] += phi_q - h_phi_dot_q;
            }
        }
    }

    /// Adds the adjoint rows (see [`tangent::pull_back`](super::tangent::pull_back)).
    pub fn pull_back(&self, blocks: &[f64], with: &Covector, rows: &mut Rows) {
        for (angle, terms, at) in self.each(blocks) {
            let i = angle.coordinate;
            let (c, d) = (with.c[i], with.d[i]);
            let (mut row_v, mut row_q) = (at.s_prime * d, at.s_prime * c - at.v * at.s * d);
            for term in terms {
                let (phi_q, phi_dot_q, e) = (term.phi_q(&at), term.phi_dot_q(&at), with.e[term.equation]);
                row_v += phi_q * e;
                row_q += phi_dot_q * e;
                rows.sigma[term.equation] += phi_q * c + phi_dot_q * d;
            }
            rows.v[i] += row_v;
            rows.q[i] += row_q;
        }
    }
}
