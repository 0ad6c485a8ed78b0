//! Dependencies among constraints, one for each left-out equation: the smallest set of dependent equations that contains this equation and no other
//! left-out one (its fundamental circuit, in the language of matroid theory).
//!
//! ```text
//!   Φ_qᵀ z = 0,  z_j = 1:      K (v, e_j − z) = (Φ_qᵀ e_j, 0)     by the factors at hand
//! ```
//!
//! Circuits that have no equation in common, as in mechanisms connected by independent constraints, are computed as their sum by one solve.

use super::compliances::root_flexibility;
use crate::System;
use crate::motion::Compliances;
use crate::node::Linearisation;
use crate::number::larger;
use crate::system::{Covector, Pair, StateRows};

/// An equation remains left out while its share is at least this fraction of the largest.
const AS_BEFORE: f64 = 0.6;
/// An equation is in a circuit if its share is at least this fraction of that of the left-out equation …
const NEGLIGIBLE: f64 = 1e-6;
/// … and circuits are recomputed if the share of an equation outside of them exceeds this.
const STRAY: f64 = 1e-3;
/// Equations are dependent while √(zᵀ Φ_q M⁻¹ Φ_qᵀ z) is below this for a z_j of size one.
const INDEPENDENT: f64 = 1e-5;

/// The left-out equations, numbered among the equations that close loops.
pub(crate) fn left_out<'a>(chosen: &'a Compliances, shared: &'a Compliances) -> impl Iterator<Item = usize> + 'a {
    (0..shared.len()).filter(|&k| chosen[k] != shared[k])
}

/// A circuit; equations are numbered among those that close loops.
struct Circuit {
    left_out: usize,
    equations: Vec<usize>,
    /// Circuits of one group have no equation in common.
    group: usize,
    /// The equation with the largest share; true if the share of the left-out equation is at least `AS_BEFORE` of it.
    largest: usize,
    is_good: bool,
}

impl Circuit {
    /// Finds the largest share and compares it with that of the left-out equation.
    fn judge(&mut self, shares: &[f64]) {
        let by_share = |a: &usize, b: &usize| shares[*a].total_cmp(&shares[*b]);
        self.largest = self.equations.iter().copied().max_by(by_share).unwrap_or(self.left_out);
        self.is_good = shares[self.left_out] >= AS_BEFORE * shares[self.largest];
    }
}

/// The circuits of all equations that are left out.
#[derive(Default)]
pub(crate) struct Circuits {
    known: Vec<Circuit>,
    /// The equations that are left out now.
    left_out: Vec<usize>,
    /// The largest |v| of all circuits.
    most_v: f64,
    /// Sum of the circuits of a group, |z_k| √(Φ_q M⁻¹ Φ_qᵀ)_kk; true for equations in one of them.
    shares: Vec<f64>,
    is_inside: Vec<bool>,
    unit: Vec<f64>,
    zeros: Vec<f64>,
    rows: StateRows,
    left: Pair,
}

impl Circuits {
    /// Clears the circuits when a motion begins.
    pub(crate) fn forget(&mut self) {
        self.known.clear();
    }

    /// True if all left-out equations have sufficient shares, with the current factors at the point of the last evaluation.
    pub(crate) fn are_good(
        &mut self,
        linearisation: &mut Linearisation,
        system: &System,
        (shared, now): (&Compliances, &Compliances),
    ) -> bool {
        self.fit(system, shared);
        self.left_out.clear();
        self.left_out.extend(left_out(now, shared));
        self.carry_over();
        self.most_v = 0.0;
        if !self.compute_groups(linearisation, system, shared) {
            self.known.clear();
        }
        if self.known.len() < self.left_out.len() {
            self.find(linearisation, system, shared);
        }
        self.known.iter().all(|circuit| circuit.is_good)
    }

    /// True if all left-out equations depend on others, which they do to rounding if positions satisfy all equations.
    pub(crate) fn are_dependent(&self) -> bool {
        self.most_v <= INDEPENDENT
    }

    /// Restores left-out equations that have lost their share; leaves out those with the largest share instead unless they may be in other circuits.
    pub(crate) fn exchange(&self, shared: &Compliances, chosen: &mut [(usize, f64)], left_out: f64) {
        let mut circuits_of = vec![0; shared.len()];
        self.known.iter().flat_map(|circuit| &circuit.equations).for_each(|&k| circuits_of[k] += 1);
        for circuit in self.known.iter().filter(|circuit| !circuit.is_good) {
            chosen[circuit.left_out] = shared[circuit.left_out];
            if circuit.equations.iter().all(|&k| circuits_of[k] == 1) {
                chosen[circuit.largest].1 *= left_out;
            }
        }
    }

    fn fit(&mut self, system: &System, shared: &Compliances) {
        let (n, m) = (system.n(), system.m());
        if self.zeros.len() != n || self.unit.len() != m {
            (self.unit, self.zeros) = (vec![0.0; m], vec![0.0; n]);
            (self.rows, self.left) = (StateRows::new(n, m), Pair::new(n, m));
        }
        self.shares.resize(shared.len(), 0.0);
        self.is_inside.resize(shared.len(), false);
    }

    /// Keeps the circuits that contain exactly one of the equations that are left out now, and assigns them to it.
    fn carry_over(&mut self) {
        let is_same = self.known.iter().map(|circuit| circuit.left_out).eq(self.left_out.iter().copied());
        if is_same {
            return;
        }
        let left_out = &self.left_out;
        self.known.retain_mut(|circuit| {
            let mut own = circuit.equations.iter().filter(|k| left_out.binary_search(k).is_ok());
            let [first, second] = [own.next(), own.next()];
            circuit.left_out = first.map_or(circuit.left_out, |first| *first);
            first.is_some() && second.is_none()
        });
        self.arrange();
    }

    /// Sorts circuits by their left-out equations, and assigns them to groups.
    fn arrange(&mut self) {
        self.known.sort_by_key(|circuit| circuit.left_out);
        self.known.dedup_by_key(|circuit| circuit.left_out);
        let mut taken: Vec<Vec<bool>> = Vec::new();
        for circuit in &mut self.known {
            let is_free = |taken: &Vec<bool>| circuit.equations.iter().all(|&k| !taken[k]);
            circuit.group = taken.iter().position(is_free).unwrap_or(taken.len());
            if circuit.group == taken.len() {
                taken.push(vec![false; self.shares.len()]);
            }
            circuit.equations.iter().for_each(|&k| taken[circuit.group][k] = true);
        }
    }

    /// Computes the shares in all known circuits, group by group; false if the circuits have changed.
    fn compute_groups(&mut self, linearisation: &mut Linearisation, system: &System, shared: &Compliances) -> bool {
        let groups = self.known.iter().map(|circuit| circuit.group + 1).max().unwrap_or(0);
        for group in 0..groups {
            self.unit.fill(0.0);
            self.is_inside.fill(false);
            for circuit in self.known.iter().filter(|circuit| circuit.group == group) {
                let (j, mu) = shared[circuit.left_out];
                self.unit[j] = root_flexibility(mu).recip();
                circuit.equations.iter().for_each(|&k| self.is_inside[k] = true);
            }
            self.solve(linearisation, system, shared);
            if self.shares.iter().zip(&self.is_inside).any(|(share, inside)| !inside && *share > STRAY) {
                return false;
            }
            for circuit in self.known.iter_mut().filter(|circuit| circuit.group == group) {
                circuit.judge(&self.shares);
            }
        }
        true
    }

    /// Computes the unknown circuits one by one.
    #[cold]
    fn find(&mut self, linearisation: &mut Linearisation, system: &System, shared: &Compliances) {
        for left_out in self.left_out.clone() {
            if self.known.iter().any(|circuit| circuit.left_out == left_out) {
                continue;
            }
            let (j, mu) = shared[left_out];
            self.unit.fill(0.0);
            self.unit[j] = root_flexibility(mu).recip();
            self.solve(linearisation, system, shared);
            let own = self.shares[left_out];
            let takes_part = |k: &usize| *k == left_out || self.shares[*k] >= NEGLIGIBLE * own;
            let equations = (0..shared.len()).filter(takes_part).collect();
            let mut circuit = Circuit { left_out, equations, group: 0, largest: left_out, is_good: true };
            circuit.judge(&self.shares);
            self.known.push(circuit);
        }
        self.arrange();
    }

    /// Computes the shares in the sum of the circuits of the equations in `unit`.
    fn solve(&mut self, linearisation: &mut Linearisation, system: &System, shared: &Compliances) {
        let evaluation = &linearisation.evaluation;
        let with = Covector { c: &self.zeros, d: &self.zeros, e: &self.unit };
        evaluation.pull_back(system, &evaluation.blocks, &with, &mut self.rows);
        self.left.v.copy_from_slice(&self.rows.v);
        self.left.sigma.fill(0.0);
        linearisation.solve(system, &mut self.left);
        self.most_v = larger(self.most_v, linearisation.size_of(&self.left.v));
        for (share, &(j, mu)) in self.shares.iter_mut().zip(shared) {
            *share = (self.unit[j] - self.left.sigma[j]).abs() * root_flexibility(mu);
        }
    }
}
