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
//! What is kept of a node is (sin q, cos q) of each such coordinate. The plain formulas hold these expressions to account in the tests.

use super::batch::{Covector, Pair, Rows, Sums};

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
    /// Where K_vv of the coordinate is stored.
    diagonal: usize,
    terms: std::ops::Range<usize>,
}

/// One equation of an angle.
#[derive(Clone, Debug)]
struct Term {
    equation: usize,
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

/// The sums over an angle's equations at a point.
struct State {
    sin: f64,
    cos: f64,
    v: f64,
    /// s and s′.
    s: f64,
    s_prime: f64,
}

impl Term {
    /// Φ_q.
    fn phi_q(&self, at: &State) -> f64 {
        self.sine * at.cos - self.cosine * at.sin
    }

    /// (dΦ/dt)_q.
    fn phi_dot_q(&self, at: &State) -> f64 {
        -at.v * (self.sine * at.sin + self.cosine * at.cos)
    }
}

impl Sines {
    /// Sorts waves by coordinate and notes where their entries of K are stored; unknown n + j is the multiplier of equation j.
    pub fn new(mut waves: Vec<Wave>, n: usize, slot: impl Fn(usize, usize) -> usize) -> Self {
        waves.sort_by_key(|wave| (wave.coordinate, wave.equation));
        let mut sines = Sines::default();
        for run in waves.chunk_by(|a, b| a.coordinate == b.coordinate) {
            let (coordinate, first) = (run[0].coordinate, sines.terms.len());
            sines.terms.extend(run.iter().map(|wave| {
                let row = n + wave.equation;
                Term {
                    equation: wave.equation,
                    below: slot(row, coordinate),
                    beside: slot(coordinate, row),
                    sine: wave.sine,
                    cosine: wave.cosine,
                }
            }));
            sines.angles.push(Angle { coordinate, diagonal: slot(coordinate, coordinate), terms: first..sines.terms.len() });
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
        2 * self.angles.len()
    }

    fn state(&self, angle: &Angle, block: &[f64; 2], v: &[f64], sigma: &[f64]) -> State {
        let [sin, cos] = *block;
        let (mut a, mut b) = (0.0, 0.0);
        for term in &self.terms[angle.terms.clone()] {
            a += sigma[term.equation] * term.sine;
            b += sigma[term.equation] * term.cosine;
        }
        State { sin, cos, v: v[angle.coordinate], s: a * cos - b * sin, s_prime: -(a * sin + b * cos) }
    }

    /// Adds to 𝓛_v, 𝓛_q and dΦ/dt, and writes (sin q, cos q).
    pub fn evaluate(&self, q: &[f64], v: &[f64], sigma: &[f64], sums: &mut Sums<f64>, blocks: &mut [f64]) {
        for (angle, block) in self.angles.iter().zip(blocks.as_chunks_mut::<2>().0) {
            let (sin, cos) = q[angle.coordinate].sin_cos();
            *block = [sin, cos];
            let at = self.state(angle, block, v, sigma);
            sums.l_v[angle.coordinate] += at.s;
            sums.force[angle.coordinate] += at.v * at.s_prime;
            for term in &self.terms[angle.terms.clone()] {
                sums.phi_dot[term.equation] += term.phi_q(&at) * at.v;
            }
        }
    }

    /// Adds K(h): h² v s on the diagonal, Φ_q ± h (dΦ/dt)_q beside it.
    pub fn scatter(&self, blocks: &[f64], v: &[f64], sigma: &[f64], h: f64, values: &mut [f64]) {
        for (angle, block) in self.angles.iter().zip(blocks.as_chunks::<2>().0) {
            let at = self.state(angle, block, v, sigma);
            values[angle.diagonal] += h * h * at.v * at.s;
            for term in &self.terms[angle.terms.clone()] {
                let (phi_q, h_phi_dot_q) = (term.phi_q(&at), h * term.phi_dot_q(&at));
                values[term.below] += phi_q + h_phi_dot_q;
                values[term.beside] += phi_q - h_phi_dot_q;
            }
        }
    }

    /// Adds the product of these entries of K(h) with x.
    pub fn multiply(&self, blocks: &[f64], v: &[f64], sigma: &[f64], h: f64, x: &Pair, y: &mut Pair) {
        for (angle, block) in self.angles.iter().zip(blocks.as_chunks::<2>().0) {
            let at = self.state(angle, block, v, sigma);
            let own = x.v[angle.coordinate];
            let mut sum = h * h * at.v * at.s * own;
            for term in &self.terms[angle.terms.clone()] {
                let (phi_q, h_phi_dot_q) = (term.phi_q(&at), h * term.phi_dot_q(&at));
                y.sigma[term.equation] += (phi_q + h_phi_dot_q) * own;
                sum += (phi_q - h_phi_dot_q) * x.sigma[term.equation];
            }
            y.v[angle.coordinate] += sum;
        }
    }

    /// Adds the adjoint rows (see [`tangent::pull_back`](super::tangent::pull_back)).
    pub fn pull_back(&self, blocks: &[f64], v: &[f64], sigma: &[f64], with: &Covector, rows: &mut Rows) {
        for (angle, block) in self.angles.iter().zip(blocks.as_chunks::<2>().0) {
            let at = self.state(angle, block, v, sigma);
            let i = angle.coordinate;
            let (c, d) = (with.c[i], with.d[i]);
            let (mut row_v, mut row_q) = (at.s_prime * d, at.s_prime * c - at.v * at.s * d);
            for term in &self.terms[angle.terms.clone()] {
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
