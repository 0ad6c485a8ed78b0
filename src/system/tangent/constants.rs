//! The part of the mechanics whose derivatives are constant: constant masses, linear joints, springs, dampers and actuators.
//!
//! This part is evaluated once per run. Every step uses it in the form of sparse matrices:
//!
//! ```text
//!   𝓛_v += A_vv v + A_vq q + Φ_qᵀσ + a_v      𝓛_q + Q += A_qv v + A_qq q + Q_u u + a_q      dΦ/dt += Φ_q v
//! ```

use super::sinusoidal_constraints::SinusoidalTerm;
use crate::system::formula::{Block, BlockEntry, Covector, Entry, NodeView, Positions, StateRows, Sums};
use crate::system::{Given, KnownPart};

/// Constant derivatives of all elements, in the scene's numbering.
#[derive(Clone, Debug, Default)]
pub struct Constants {
    pub vv: Vec<Entry>,
    pub vq: Vec<Entry>,
    pub qv: Vec<Entry>,
    pub qq: Vec<Entry>,
    pub phi_q: Vec<Entry>,
    pub q_u: Vec<Entry>,
    /// The coefficients of sinusoidal constraints. The constraints vary along the motion, but the coefficients do not.
    pub waves: Vec<SinusoidalTerm>,
    l_v: Vec<f64>,
    force: Vec<f64>,
}

impl Constants {
    pub fn new(n: usize) -> Self {
        Constants { l_v: vec![0.0; n], force: vec![0.0; n], ..Constants::default() }
    }

    /// Adds an entry, with row and column in the scene's numbering.
    pub fn add(&mut self, entry: &BlockEntry, [row, col]: [usize; 2], value: f64) {
        let list = match entry.block {
            Block::Vv => &mut self.vv,
            Block::Vq => {
                put(&mut self.qv, col, row, value);
                &mut self.vq
            }
            Block::ForceV => &mut self.qv,
            Block::Qq | Block::ForceQ => &mut self.qq,
            Block::PhiQ => &mut self.phi_q,
            // A constraint that has these blocks is not constant.
            Block::PhiQq | Block::PhiDotQq | Block::PhiDotQ => return,
        };
        put(list, row, col, value);
        if entry.mirrored {
            put(list, col, row, value);
        }
    }

    pub fn add_first(&mut self, q: &[usize], l_v: &[f64], force: &[f64]) {
        for (k, &i) in q.iter().enumerate() {
            self.l_v[i] += l_v[k];
            self.force[i] += force[k];
        }
    }

    pub fn add_control(&mut self, coordinate: usize, channel: usize, value: f64) {
        put(&mut self.q_u, coordinate, channel, value);
    }

    pub fn add_phi_q(&mut self, entry: Entry) {
        put(&mut self.phi_q, entry.row, entry.col, entry.value);
    }

    fn lists_mut(&mut self) -> [&mut Vec<Entry>; 6] {
        [&mut self.vv, &mut self.vq, &mut self.qv, &mut self.qq, &mut self.phi_q, &mut self.q_u]
    }

    /// Clears the lists but keeps their memory.
    pub fn clear(&mut self) {
        self.lists_mut().into_iter().for_each(Vec::clear);
        self.waves.clear();
        self.l_v.fill(0.0);
        self.force.fill(0.0);
    }

    /// Sums the entries at equal places.
    pub fn compress(&mut self) {
        for list in self.lists_mut() {
            list.sort_by_key(|e| (e.row, e.col));
            list.dedup_by(|later, first| {
                let same = (later.row, later.col) == (first.row, first.col);
                if same {
                    first.value += later.value;
                }
                same
            });
        }
    }

    /// Writes the negative of r_v = 𝓛_v − h (𝓛_q + Q) − (p*₋ + h g₋) and r_σ = dΦ/dt at v = 0, σ = 0 (q = q₋ + h v₋), without the varying part,
    /// in the solver's order.
    pub(crate) fn step_constants(&self, from: &KnownPart, given: Given, positions: &Positions, r: &mut [f64]) {
        let h = from.h;
        r.fill(0.0);
        let terms = self.l_v.iter().zip(&self.force).zip(from.p_star);
        for (((l_v, force), start), &position) in terms.zip(&positions.v) {
            r[position] = start - l_v + h * force;
        }
        let mut add = |matrix: &[Entry], x: &[f64], factor: f64| {
            matrix.iter().for_each(|e| r[positions.v[e.row]] += factor * e.value * x[e.col]);
        };
        add(&self.vq, from.q, -1.0);
        add(&self.qq, from.q, h);
        add(&self.q_u, given.u, h);
    }

    /// Writes the constant part of 𝓛_v.
    pub fn l_v(&self, at: &NodeView<f64>, l_v: &mut [f64]) {
        l_v.copy_from_slice(&self.l_v);
        multiply(&self.vv, at.v, l_v);
        multiply(&self.vq, at.q, l_v);
        multiply_transposed(&self.phi_q, at.sigma, l_v);
    }

    /// Writes the constant part of dΦ/dt.
    pub fn phi_dot(&self, at: &NodeView<f64>, phi_dot: &mut [f64]) {
        phi_dot.fill(0.0);
        multiply(&self.phi_q, at.v, phi_dot);
    }

    /// Writes the constant part of 𝓛_q + Q.
    pub fn force(&self, q: &[f64], v: &[f64], u: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&self.force);
        multiply(&self.qv, v, force);
        multiply(&self.qq, q, force);
        multiply(&self.q_u, u, force);
    }

    /// The constant part of K(h) as (row, column, power of h, value); unknowns are numbered v, then σ.
    pub fn tangent(&self) -> impl Iterator<Item = (usize, usize, usize, f64)> {
        let n = self.l_v.len();
        let mechanics = [(&self.vv, 0, 1.0), (&self.vq, 1, 1.0), (&self.qv, 1, -1.0), (&self.qq, 2, -1.0)];
        let of = |(list, power, sign)| (list as &Vec<Entry>).iter().map(move |e| (e.row, e.col, power, sign * e.value));
        let both = move |e: &Entry| [(n + e.row, e.col, 0, e.value), (e.col, n + e.row, 0, e.value)];
        mechanics.into_iter().flat_map(of).chain(self.phi_q.iter().flat_map(both))
    }

    /// Whether all constant derivatives are finite.
    pub fn are_finite(&self) -> bool {
        let lists = [&self.vv, &self.vq, &self.qv, &self.qq, &self.phi_q, &self.q_u];
        let waves = self.waves.iter().all(|wave| wave.sine.is_finite() && wave.cosine.is_finite());
        let values = lists.into_iter().flatten().map(|e| e.value).chain(self.l_v.iter().chain(&self.force).copied());
        waves && values.into_iter().all(f64::is_finite)
    }

    /// Subtracts the constant part of row ∂v + h ∂q for c = e = 0 (see [`block`](crate::system::formula::block)), in the solver's order.
    pub fn subtract_force_rows(&self, h: f64, d: &[f64], positions: &Positions, right: &mut [f64]) {
        let mut subtract = |matrix: &[Entry], factor: f64| {
            matrix.iter().for_each(|e| right[positions.v[e.col]] -= factor * e.value * d[e.row]);
        };
        subtract(&self.qv, 1.0);
        subtract(&self.qq, h);
    }

    /// Subtracts the constant part of the adjoint row ∂q.
    pub fn subtract_row_q(&self, with: &Covector, row_q: &mut [f64]) {
        let mut subtract = |matrix: &[Entry], x: &[f64]| matrix.iter().for_each(|e| row_q[e.col] -= e.value * x[e.row]);
        subtract(&self.vq, with.c);
        subtract(&self.qq, with.d);
    }

    /// Adds the constant part of all adjoint rows.
    pub fn pull_back(&self, with: &Covector, rows: &mut StateRows) {
        multiply_transposed(&self.vv, with.c, &mut rows.v);
        multiply_transposed(&self.qv, with.d, &mut rows.v);
        multiply_transposed(&self.phi_q, with.e, &mut rows.v);
        multiply_transposed(&self.vq, with.c, &mut rows.q);
        multiply_transposed(&self.qq, with.d, &mut rows.q);
        multiply(&self.phi_q, with.c, &mut rows.sigma);
    }

    /// Adds the constant part of the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction of state and controls.
    pub fn push_forward(&self, along: &NodeView<f64>, sums: &mut Sums<f64>) {
        let [l_v, force, phi_dot] = sums.parts_mut();
        multiply(&self.vv, along.v, l_v);
        multiply(&self.vq, along.q, l_v);
        multiply_transposed(&self.phi_q, along.sigma, l_v);
        multiply(&self.phi_q, along.v, phi_dot);
        multiply(&self.q_u, along.u, force);
        self.push_forward_to_force(along, force);
    }

    /// Adds the changes of 𝓛_q + Q alone along a direction of the state.
    pub fn push_forward_to_force(&self, along: &NodeView<f64>, force: &mut [f64]) {
        multiply(&self.qv, along.v, force);
        multiply(&self.qq, along.q, force);
    }

    /// Adds Q_uᵀ d.
    pub fn pull_back_controls(&self, d: &[f64], row_u: &mut [f64]) {
        multiply_transposed(&self.q_u, d, row_u);
    }
}

fn put(list: &mut Vec<Entry>, row: usize, col: usize, value: f64) {
    if value != 0.0 {
        list.push(Entry { row, col, value });
    }
}

fn multiply(matrix: &[Entry], x: &[f64], y: &mut [f64]) {
    for e in matrix {
        y[e.row] += x[e.col] * e.value;
    }
}

fn multiply_transposed(matrix: &[Entry], x: &[f64], y: &mut [f64]) {
    for e in matrix {
        y[e.col] += x[e.row] * e.value;
    }
}
