//! Batches: all elements of one type in one list, behind traits that know nothing of the type.
//!
//! Inner loops are monomorphic, and a virtual call is made once per batch, not once per element.

use num_dual::Dual64;
use std::any::Any;

use super::blame::Suspect;
use super::constants::{Constants, Entry};
use super::item::PlacedElement;
use super::jet::{ElementKind, Jet, Local};
use super::tangent;
use super::view::NodeView;
use crate::Cx;
use crate::model::Param;
use crate::number::Fingerprint;
use crate::number::Real;

/// 𝓛_v (n), 𝓛_q + Q (n) and dΦ/dt (m) of all elements.
#[derive(Clone, Debug, Default)]
pub struct Sums<R> {
    pub l_v: Vec<R>,
    pub force: Vec<R>,
    pub phi_dot: Vec<R>,
}

impl<R: Real> Sums<R> {
    pub fn new(n: usize, m: usize) -> Self {
        Sums { l_v: vec![R::zero(); n], force: vec![R::zero(); n], phi_dot: vec![R::zero(); m] }
    }

    pub fn clear(&mut self) {
        self.l_v.fill(R::zero());
        self.force.fill(R::zero());
        self.phi_dot.fill(R::zero());
    }
}

/// Where each velocity and each multiplier stands in the solver's order.
#[derive(Clone, Debug)]
pub struct Positions {
    pub v: Vec<usize>,
    pub sigma: Vec<usize>,
}

/// Numbers for each velocity (n) and each multiplier (m).
#[derive(Clone, Debug, Default)]
pub struct Pair {
    pub v: Vec<f64>,
    pub sigma: Vec<f64>,
}

impl Pair {
    pub fn new(n: usize, m: usize) -> Self {
        Pair { v: vec![0.0; n], sigma: vec![0.0; m] }
    }

    /// Takes the values out of the solver's order.
    pub fn load(&mut self, positions: &Positions, x: &[f64]) {
        self.v.iter_mut().zip(&positions.v).for_each(|(v, &at)| *v = x[at]);
        self.sigma.iter_mut().zip(&positions.sigma).for_each(|(sigma, &at)| *sigma = x[at]);
    }

    /// Puts the values into the solver's order.
    pub fn store(&self, positions: &Positions, x: &mut [f64]) {
        self.v.iter().zip(&positions.v).for_each(|(v, &at)| x[at] = *v);
        self.sigma.iter().zip(&positions.sigma).for_each(|(sigma, &at)| x[at] = *sigma);
    }
}

/// The adjoint variables c (of E3), d (of E4) and e (of E5) at one node.
#[derive(Clone, Copy)]
pub struct Covector<'a> {
    pub c: &'a [f64],
    pub d: &'a [f64],
    pub e: &'a [f64],
}

/// Derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to v (n), q (n) and σ (m).
#[derive(Clone, Debug, Default)]
pub struct StateRows {
    pub v: Vec<f64>,
    pub q: Vec<f64>,
    pub sigma: Vec<f64>,
}

impl StateRows {
    pub fn new(n: usize, m: usize) -> Self {
        StateRows { v: vec![0.0; n], q: vec![0.0; n], sigma: vec![0.0; m] }
    }

    pub fn clear(&mut self) {
        self.v.fill(0.0);
        self.q.fill(0.0);
        self.sigma.fill(0.0);
    }
}

/// Derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to u, the design variables and t.
pub struct InputRows<'a> {
    pub u: &'a mut [f64],
    pub design: &'a mut [f64],
    pub time: &'a mut f64,
    /// How many single derivatives were evaluated.
    pub evaluations: &'a mut usize,
}

/// What happens to c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt of an element within a step.
#[derive(Clone, Copy)]
pub struct Within {
    /// Its change, less what the derivatives at the ends of the step say.
    pub missed: f64,
    /// The larger of its change and of what these say.
    pub change: f64,
}

/// What an element depends on, in the scene's numbering.
pub struct Footprint<'a> {
    pub form: ElementKind,
    pub q: &'a [usize],
    pub sigma: &'a [usize],
    /// The coordinates whose entries of K vary along a motion (empty for an element with constant blocks).
    pub active: Vec<usize>,
    /// Whether no second derivative mixes two of them.
    pub separable: bool,
}

/// A batch on numbers of type R: the plain formulas.
pub trait PlainBatch<R: Real>: Send + Sync {
    /// Adds the contributions of all elements.
    fn add(&self, at: &NodeView<R>, sums: &mut Sums<R>);
    /// Writes Φ of all constraints.
    fn phi(&self, at: &NodeView<R>, phi: &mut [R]);
}

/// A batch in real numbers: second derivatives, the tangent matrix, and adjoints.
pub trait AnyBatch: PlainBatch<f64> + PlainBatch<Cx> + PlainBatch<Dual64> + Any {
    /// Resolves the parameters of every element, traces its formula and decides what is constant; `at` is for formulas that look at values.
    fn prepare(&mut self, gravity: &[Param; 3], at: &NodeView<f64>);
    /// Joins what identifies the formulas that anything was concluded of.
    fn fingerprint(&self, sum: &mut Fingerprint);
    /// The first element from whose formula other things would be concluded now.
    fn find_changed(&self, at: &NodeView<f64>) -> Option<&str>;
    /// Appends the entries of K that constant derivatives can have.
    fn constant_entries(&self, at: &NodeView<f64>, n: usize, entries: &mut Vec<(usize, usize)>);
    /// What kind of element it holds.
    fn form(&self) -> ElementKind;
    /// What each element touches.
    fn footprints(&self) -> Vec<Footprint<'_>>;
    /// Fixes where each varying entry of K is stored.
    fn place(&mut self, slot: &dyn Fn(usize, usize) -> usize, n: usize);
    /// Adds the blocks of the elements that are constant, for the design variables of a start.
    fn constants(&self, start: &NodeView<f64>, into: &mut Constants);
    /// The first element that has a constant for which `has_place` knows no place.
    fn find_misplaced(&self, start: &NodeView<f64>, has_place: &dyn Fn(&Constants) -> bool) -> Option<&str>;
    /// Appends the entries of Φ_q at a point.
    fn phi_q(&self, at: &NodeView<f64>, entries: &mut Vec<Entry>);
    /// The number of stored derivatives of all varying elements at one node.
    fn block_len(&self) -> usize;
    /// The number of elements evaluated by `evaluate`.
    fn varying(&self) -> usize;
    /// Whether `pull_back_inputs` has anything to add.
    fn has_input_derivatives(&self) -> bool;
    /// Adds what the varying elements contribute and writes their second derivatives.
    fn evaluate(&self, at: &NodeView<f64>, sums: &mut Sums<f64>, blocks: &mut [f64]);
    /// Adds the varying entries of K(h), made from blocks, to its values.
    fn scatter(&self, blocks: &[f64], h: f64, values: &mut [f64]);
    /// Adds the derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to v, q and σ, made from blocks.
    fn pull_back(&self, blocks: &[f64], with: &Covector, rows: &mut StateRows);
    /// Adds its derivatives with respect to u (varying elements), design variables and time.
    fn pull_back_inputs(&self, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows);
    /// Adds the derivatives of e·Φ with respect to design variables and time.
    fn pull_back_phi(&self, at: &NodeView<f64>, e: &[f64], rows: &mut InputRows);
    /// The names of the elements whose derivatives vary other than as sines.
    fn bending(&self) -> Vec<&str>;
    /// Shows what happens to each of them between the ends of a step; derivatives there are along the step.
    fn look_within(&self, ends: &[NodeView<Dual64>; 2], with: &Covector, show: &mut dyn FnMut(Within));
    /// The first element whose contributions or their derivatives are not finite.
    fn find_not_finite(&self, at: &NodeView<f64>) -> Option<Suspect<'_>>;
    /// The first element with a derivative with respect to an input that is not finite.
    fn find_bad_input(&self, at: &NodeView<f64>) -> Option<Suspect<'_>>;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// All elements of one type, those with dual numbers at every iteration (the varying ones) first.
pub struct Batch<J, const N: usize, const M: usize, const K: usize, const P: usize> {
    pub items: Vec<PlacedElement<J, N, M, K, P>>,
    varying: usize,
    /// The elements whose derivatives with respect to inputs are not constant.
    with_input_derivatives: Vec<usize>,
    slots: Vec<u32>,
}

impl<J, const N: usize, const M: usize, const K: usize, const P: usize> Default for Batch<J, N, M, K, P> {
    fn default() -> Self {
        Batch { items: Vec::new(), varying: 0, with_input_derivatives: Vec::new(), slots: Vec::new() }
    }
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> Batch<J, N, M, K, P> {
    fn varying_items(&self) -> impl Iterator<Item = &PlacedElement<J, N, M, K, P>> {
        self.items[..self.varying].iter()
    }
}

impl<J, R, const N: usize, const M: usize, const K: usize, const P: usize> PlainBatch<R> for Batch<J, N, M, K, P>
where
    J: Jet<N, M, K, P>,
    R: Real,
{
    fn add(&self, at: &NodeView<R>, sums: &mut Sums<R>) {
        for item in &self.items {
            let first = item.jet.first(&item.local(at), &item.b(at.design));
            item.scatter_first(&first, sums);
        }
    }

    fn phi(&self, at: &NodeView<R>, phi: &mut [R]) {
        for item in self.items.iter().filter(|_| M > 0) {
            let local: Local<R, N, M, K> = item.local(at);
            let values = item.jet.phi(&local.q, &item.b(at.design), at.t);
            item.sigma.iter().zip(values.iter()).for_each(|(&j, value)| phi[j] = *value);
        }
    }
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> AnyBatch for Batch<J, N, M, K, P> {
    fn prepare(&mut self, gravity: &[Param; 3], at: &NodeView<f64>) {
        for item in &mut self.items {
            item.b = item.b.map(|b| b.resolve(gravity));
            item.plan = item.traced_plan(at);
        }
        let differentiated = |item: &PlacedElement<J, N, M, K, P>| !item.plan.constant && !item.plan.sinusoidal;
        self.items.sort_by_key(|item| !differentiated(item));
        self.varying = self.items.iter().filter(|item| differentiated(item)).count();
        self.with_input_derivatives = (0..self.items.len()).filter(|&i| self.items[i].has_input_derivatives()).collect();
    }

    fn form(&self) -> ElementKind {
        J::KIND
    }

    fn footprints(&self) -> Vec<Footprint<'_>> {
        let footprint = |item: &'_ PlacedElement<J, N, M, K, P>| -> Vec<usize> {
            let count = if item.plan.constant { 0 } else { item.plan.count };
            item.plan.active[..count].iter().map(|&i| item.q[i]).collect()
        };
        let items = self.items.iter();
        items
            .map(|item| Footprint {
                form: J::KIND,
                q: &item.q,
                sigma: &item.sigma,
                active: footprint(item),
                separable: item.plan.sinusoidal,
            })
            .collect()
    }

    fn fingerprint(&self, sum: &mut Fingerprint) {
        self.items.iter().for_each(|item| item.fingerprint(sum));
    }

    fn find_changed(&self, at: &NodeView<f64>) -> Option<&str> {
        self.items.iter().find(|item| !item.plan.agrees(&item.traced_plan(at))).map(|item| item.name.as_str())
    }

    fn constant_entries(&self, at: &NodeView<f64>, n: usize, entries: &mut Vec<(usize, usize)>) {
        self.items.iter().for_each(|item| item.constant_entries(at, n, entries));
    }

    fn place(&mut self, slot: &dyn Fn(usize, usize) -> usize, n: usize) {
        self.slots.clear();
        for item in &mut self.items[..self.varying] {
            item.plan.slots = self.slots.len();
            let active = item.plan.active[..item.plan.count].iter().map(|&i| item.q[i]);
            let mut put = |row, col| self.slots.push(slot(row, col) as u32);
            for row in active.clone() {
                active.clone().for_each(|col| put(row, col));
            }
            for row in item.sigma {
                active.clone().for_each(|col| put(n + row, col));
                active.clone().for_each(|col| put(col, n + row));
            }
        }
    }

    fn constants(&self, start: &NodeView<f64>, into: &mut Constants) {
        self.items.iter().for_each(|item| item.add_constants(start, into));
    }

    fn find_misplaced(&self, start: &NodeView<f64>, has_place: &dyn Fn(&Constants) -> bool) -> Option<&str> {
        let mut own = Constants::new(start.q.len());
        let bad = self.items.iter().find(|item| {
            own.clear();
            item.add_constants(start, &mut own);
            !has_place(&own)
        });
        bad.map(|item| item.name.as_str())
    }

    fn phi_q(&self, at: &NodeView<f64>, entries: &mut Vec<Entry>) {
        for item in self.items.iter().filter(|_| M > 0) {
            let local: Local<f64, N, M, K> = item.local(at);
            (0..N).for_each(|i| item.phi_q_column(i, &local.q, at.t, at.design, &mut |e| entries.push(e)));
        }
    }

    fn block_len(&self) -> usize {
        self.varying_items().map(PlacedElement::block_len).sum()
    }

    fn varying(&self) -> usize {
        self.varying
    }

    fn has_input_derivatives(&self) -> bool {
        !self.with_input_derivatives.is_empty()
    }

    fn evaluate(&self, at: &NodeView<f64>, sums: &mut Sums<f64>, mut blocks: &mut [f64]) {
        for item in self.varying_items() {
            let (own, rest) = blocks.split_at_mut(item.block_len());
            item.evaluate(at, sums, own);
            blocks = rest;
        }
    }

    fn scatter(&self, mut blocks: &[f64], h: f64, values: &mut [f64]) {
        for item in self.varying_items() {
            let (own, rest) = blocks.split_at(item.block_len());
            tangent::scatter(J::KIND, own, item.plan.count, M, &self.slots[item.plan.slots..], h, values);
            blocks = rest;
        }
    }

    fn pull_back(&self, mut blocks: &[f64], with: &Covector, rows: &mut StateRows) {
        for item in self.varying_items() {
            let (own, rest) = blocks.split_at(item.block_len());
            let coordinates = item.plan.active.map(|i| item.q[i]);
            let active = &coordinates[..item.plan.count];
            tangent::pull_back(J::KIND, own, active, &item.sigma, with, rows);
            blocks = rest;
        }
    }

    fn pull_back_inputs(&self, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows) {
        for &i in &self.with_input_derivatives {
            self.items[i].pull_back_inputs(at, with, rows);
        }
    }

    fn pull_back_phi(&self, at: &NodeView<f64>, e: &[f64], rows: &mut InputRows) {
        for &i in self.with_input_derivatives.iter().filter(|_| M > 0) {
            self.items[i].pull_back_phi(at, e, rows);
        }
    }

    fn bending(&self) -> Vec<&str> {
        self.items.iter().filter(|item| item.may_bend()).map(|item| item.name.as_str()).collect()
    }

    fn look_within(&self, ends: &[NodeView<Dual64>; 2], with: &Covector, show: &mut dyn FnMut(Within)) {
        self.items.iter().filter(|item| item.may_bend()).for_each(|item| show(item.within(ends, with)));
    }

    fn find_bad_input(&self, at: &NodeView<f64>) -> Option<Suspect<'_>> {
        self.items.iter().find_map(|item| Some(Suspect { element: &item.name, arguments: vec![item.find_bad_input(at)?] }))
    }

    fn find_not_finite(&self, at: &NodeView<f64>) -> Option<Suspect<'_>> {
        self.items.iter().find_map(|item| {
            let arguments = item.find_not_finite(at)?;
            Some(Suspect { element: &item.name, arguments })
        })
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
