//! The part of the mechanics whose derivatives are constant: constant masses, linear joints, springs, dampers and actuators.
//!
//! This part is evaluated once per run. Every step uses it in the form of sparse matrices:
//!
//! ```text
//!   𝓛_v += 𝓛_vv v + 𝓛_vq q + Φ_qᵀσ + a_v      𝓛_q + Q += (𝓛_vqᵀ + Q_v) v + (𝓛_qq + Q_q) q + Q_u u + a_q      dΦ/dt += Φ_q v
//! ```

use super::products::{Entries, Variable, of_force, row_q};
use super::sinusoidal_constraints::SinusoidalTerm;
use crate::system::formula::{Block, BlockEntry, Entry, NodeView, Positions};
use crate::system::{Given, KnownPart};

/// Constant derivatives of all elements, in the scene's numbering.
#[derive(Clone, Debug, Default)]
pub struct Constants {
    vv: Vec<Entry>,
    vq: Vec<Entry>,
    /// Q_v.
    force_v: Vec<Entry>,
    /// 𝓛_qq + Q_q.
    qq: Vec<Entry>,
    pub phi_q: Vec<Entry>,
    q_u: Vec<Entry>,
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
            Block::Vq => &mut self.vq,
            Block::ForceV => &mut self.force_v,
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
        [&mut self.vv, &mut self.vq, &mut self.force_v, &mut self.qq, &mut self.phi_q, &mut self.q_u]
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
        let at = given.at(from.q, &[], &[]);
        self.push_forward(&[], &at, row_q, |of, i, x| r[positions.v[i]] += if of == Variable::D { h * x } else { -x });
        self.q_u.iter().for_each(|e| r[positions.v[e.row]] += h * e.value * given.u[e.col]);
    }

    /// Writes the constant part of 𝓛_v.
    pub fn l_v(&self, at: &NodeView<f64>, l_v: &mut [f64]) {
        l_v.copy_from_slice(&self.l_v);
        self.push_forward(&[], at, |_, of| of == Variable::C, |_, i, x| l_v[i] += x);
    }

    /// Writes the constant part of 𝓛_q + Q.
    pub fn force(&self, at: &NodeView<f64>, force: &mut [f64]) {
        force.copy_from_slice(&self.force);
        self.push_forward(&[], at, of_force, |_, i, x| force[i] += x);
        self.push_forward_controls(at.u, force);
    }

    /// The constant part of K(h) as (row, column, power of h, value); unknowns are numbered v, then σ.
    pub fn tangent(&self) -> impl Iterator<Item = (usize, usize, usize, f64)> {
        let n = self.l_v.len();
        let mechanics = [(&self.vv, 0, 1.0), (&self.vq, 1, 1.0), (&self.force_v, 1, -1.0), (&self.qq, 2, -1.0)];
        let of = |(list, power, sign)| (list as &Vec<Entry>).iter().map(move |e| (e.row, e.col, power, sign * e.value));
        let qv = self.vq.iter().map(|e| (e.col, e.row, 1, -e.value));
        let both = move |e: &Entry| [(n + e.row, e.col, 0, e.value), (e.col, n + e.row, 0, e.value)];
        mechanics.into_iter().flat_map(of).chain(qv).chain(self.phi_q.iter().flat_map(both))
    }

    /// Whether all constant derivatives are finite.
    pub fn are_finite(&self) -> bool {
        let lists = [&self.vv, &self.vq, &self.force_v, &self.qq, &self.phi_q, &self.q_u];
        let waves = self.waves.iter().all(|wave| wave.sine.is_finite() && wave.cosine.is_finite());
        let values = lists.into_iter().flatten().map(|e| e.value).chain(self.l_v.iter().chain(&self.force).copied());
        waves && values.into_iter().all(f64::is_finite)
    }

    /// Adds Q_u u.
    pub fn push_forward_controls(&self, u: &[f64], force: &mut [f64]) {
        self.q_u.iter().for_each(|e| force[e.row] += u[e.col] * e.value);
    }

    /// Adds Q_uᵀ d.
    pub fn pull_back_controls(&self, d: &[f64], row_u: &mut [f64]) {
        self.q_u.iter().for_each(|e| row_u[e.col] += d[e.row] * e.value);
    }
}

impl Entries for Constants {
    #[inline(always)]
    fn each(&self, _: &[f64], mut visit: impl FnMut(Block, [usize; 2], f64)) {
        self.vv.iter().for_each(|e| visit(Block::Vv, [e.row, e.col], e.value));
        self.vq.iter().for_each(|e| visit(Block::Vq, [e.row, e.col], e.value));
        self.force_v.iter().for_each(|e| visit(Block::ForceV, [e.row, e.col], e.value));
        self.qq.iter().for_each(|e| visit(Block::Qq, [e.row, e.col], e.value));
        self.phi_q.iter().for_each(|e| visit(Block::PhiQ, [e.row, e.col], e.value));
    }
}

fn put(list: &mut Vec<Entry>, row: usize, col: usize, value: f64) {
    if value != 0.0 {
        list.push(Entry { row, col, value });
    }
}
