//! Batches: all elements of one type in one list, behind traits that know nothing of the type.
//!
//! What does not depend on the type stands in a scene's list of [elements](super::element).

use num_dual::Dual64;
use std::any::Any;

use super::blame::Suspect;
use super::constants::Entry;
use super::cost::CostRows;
use super::element::Recordings;
use super::item::PlacedElement;
use super::jet::{ElementKind, Jet, Local, Number};
use super::view::NodeView;
use crate::Cx;
use crate::model::Param;
use crate::number::{Fingerprint, Hyper, add};

/// 𝓛_v (n), 𝓛_q + Q (n) and dΦ/dt (m) of all elements, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Sums<R> {
    pub all: Vec<R>,
    n: usize,
}

impl<R: Number> Sums<R> {
    pub fn new(n: usize, m: usize) -> Self {
        Sums { all: vec![R::zero(); 2 * n + m], n }
    }

    pub fn clear(&mut self) {
        self.all.fill(R::zero());
    }

    pub fn l_v(&self) -> &[R] {
        &self.all[..self.n]
    }

    pub fn force(&self) -> &[R] {
        &self.all[self.n..2 * self.n]
    }

    pub fn phi_dot(&self) -> &[R] {
        &self.all[2 * self.n..]
    }

    /// 𝓛_v, 𝓛_q + Q and dΦ/dt.
    pub fn parts_mut(&mut self) -> [&mut [R]; 3] {
        let (l_v, rest) = self.all.split_at_mut(self.n);
        let (force, phi_dot) = rest.split_at_mut(self.n);
        [l_v, force, phi_dot]
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

    /// Adds another one.
    pub fn add(&mut self, other: &Pair) {
        add(&mut self.v, &other.v);
        add(&mut self.sigma, &other.sigma);
    }

    /// Becomes what is left of another one when this is taken away.
    pub fn subtract_from(&mut self, other: &Pair) {
        self.v.iter_mut().zip(&other.v).for_each(|(x, other)| *x = other - *x);
        self.sigma.iter_mut().zip(&other.sigma).for_each(|(x, other)| *x = other - *x);
    }

    /// −x.
    pub fn negative(&self) -> Pair {
        let negative = |x: &[f64]| x.iter().map(|x| -x).collect();
        Pair { v: negative(&self.v), sigma: negative(&self.sigma) }
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

/// A batch on numbers of type R: the plain formulas.
pub trait PlainBatch<R: Number>: Send + Sync {
    /// Adds the contributions of all elements.
    fn add(&self, at: &NodeView<R>, sums: &mut Sums<R>);
    /// Writes Φ of all constraints.
    fn phi(&self, at: &NodeView<R>, phi: &mut [R]);
}

/// A batch in real numbers: what depends on the types of its formulas, element by element.
pub trait AnyBatch: PlainBatch<f64> + PlainBatch<Cx> + PlainBatch<Hyper> + Any {
    /// What kind of element it holds.
    fn kind(&self) -> ElementKind;
    /// Takes the parameters of all elements through `resolve`.
    fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param);
    /// Records the formulas of all elements; `at` is for those that look at values.
    fn prepare(&mut self, at: &NodeView<f64>, into: &mut Recordings);
    /// Records the formula of the element at a place, batch and item, as it is now.
    fn record_again(&self, place: (usize, usize), at: &NodeView<f64>, into: &mut Recordings);
    /// Joins what identifies the formulas that anything was concluded of.
    fn fingerprint(&self, sum: &mut Fingerprint);
    /// The sum of the formulas of all elements, if they have one value each: T or V.
    fn energy(&self, at: &NodeView<f64>) -> f64;
    /// Appends the entries of Φ_q at a point.
    fn phi_q(&self, at: &NodeView<f64>, entries: &mut Vec<Entry>);
    /// Adds what an element contributes and writes its second derivatives, by dual numbers.
    fn evaluate(&self, item: usize, at: &NodeView<f64>, sums: &mut Sums<f64>, blocks: &mut [f64]);
    /// Adds an element's derivatives with respect to u, design variables and time, by dual numbers.
    fn pull_back_inputs(&self, item: usize, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows);
    /// Adds the derivatives of e·Φ with respect to design variables and time.
    fn pull_back_phi(&self, at: &NodeView<f64>, e: &[f64], rows: &mut InputRows);
    /// Adds what an element adds to the equations of v̇ and λ where these are zero, by dual numbers.
    fn add_acceleration(&self, item: usize, at: &NodeView<f64>, right: &mut Pair);
    /// Adds the derivatives of what it adds to them, with c and e.
    fn pull_back_acceleration(&self, item: usize, at: &NodeView<f64>, with: &Pair, rows: &mut CostRows);
    /// Adds the changes of an element's 𝓛_v, 𝓛_q + Q and dΦ/dt along the inputs of a direction, by dual numbers.
    fn add_changes(&self, item: usize, at: &NodeView<f64>, along: &NodeView<f64>, sums: &mut Sums<f64>);
    /// Adds the derivatives of the change of its c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt along a direction.
    fn pull_back_along(&self, item: usize, at: (&NodeView<f64>, &NodeView<f64>), with: &Covector, rows: &mut CostRows);
    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt of an element, and its rate.
    fn along(&self, item: usize, at: &NodeView<Dual64>, with: &Covector) -> [f64; 2];
    /// The first element whose contributions or their derivatives are not finite.
    fn find_not_finite(&self, at: &NodeView<f64>) -> Option<Suspect<'_>>;
    /// The first element with a derivative with respect to an input that is not finite.
    fn find_bad_input(&self, at: &NodeView<f64>) -> Option<Suspect<'_>>;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// All elements of one type.
pub struct Batch<J, const N: usize, const M: usize, const K: usize, const P: usize> {
    pub items: Vec<PlacedElement<J, N, M, K, P>>,
}

impl<J, const N: usize, const M: usize, const K: usize, const P: usize> Default for Batch<J, N, M, K, P> {
    fn default() -> Self {
        Batch { items: Vec::new() }
    }
}

impl<J, R, const N: usize, const M: usize, const K: usize, const P: usize> PlainBatch<R> for Batch<J, N, M, K, P>
where
    J: Jet<N, M, K, P>,
    R: Number + Send + Sync,
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
    fn kind(&self) -> ElementKind {
        J::KIND
    }

    fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param) {
        self.items.iter_mut().for_each(|item| item.b = item.b.map(&mut *resolve));
    }

    fn prepare(&mut self, at: &NodeView<f64>, into: &mut Recordings) {
        for (place, item) in self.items.iter_mut().enumerate() {
            let formula = into.add(item, (into.batch, place), at);
            item.timed = formula.timed;
            item.is_recorded = formula.template.is_some();
        }
        into.batch += 1;
    }

    fn record_again(&self, place: (usize, usize), at: &NodeView<f64>, into: &mut Recordings) {
        into.add(&self.items[place.1], place, at);
    }

    fn fingerprint(&self, sum: &mut Fingerprint) {
        self.items.iter().for_each(|item| item.fingerprint(sum));
    }

    fn energy(&self, at: &NodeView<f64>) -> f64 {
        let mut sum = 0.0;
        self.items.iter().for_each(|item| item.jet.values(&item.local(at), &item.b(at.design), &mut |value| sum += value));
        sum
    }

    fn phi_q(&self, at: &NodeView<f64>, entries: &mut Vec<Entry>) {
        for item in self.items.iter().filter(|_| M > 0) {
            let local: Local<f64, N, M, K> = item.local(at);
            (0..N).for_each(|i| item.phi_q_column(i, &local.q, at.t, at.design, &mut |e| entries.push(e)));
        }
    }

    fn evaluate(&self, item: usize, at: &NodeView<f64>, sums: &mut Sums<f64>, blocks: &mut [f64]) {
        self.items[item].evaluate(at, sums, blocks);
    }

    fn pull_back_inputs(&self, item: usize, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows) {
        self.items[item].pull_back_inputs(at, with, rows);
    }

    fn pull_back_phi(&self, at: &NodeView<f64>, e: &[f64], rows: &mut InputRows) {
        self.items.iter().filter(|_| M > 0).for_each(|item| item.pull_back_phi(at, e, rows));
    }

    fn add_acceleration(&self, item: usize, at: &NodeView<f64>, right: &mut Pair) {
        self.items[item].add_acceleration(at, right);
    }

    fn pull_back_acceleration(&self, item: usize, at: &NodeView<f64>, with: &Pair, rows: &mut CostRows) {
        self.items[item].pull_back_acceleration(at, with, rows);
    }

    fn add_changes(&self, item: usize, at: &NodeView<f64>, along: &NodeView<f64>, sums: &mut Sums<f64>) {
        self.items[item].add_changes(at, along, sums);
    }

    fn pull_back_along(&self, item: usize, at: (&NodeView<f64>, &NodeView<f64>), with: &Covector, rows: &mut CostRows) {
        self.items[item].pull_back_along(at, with, rows);
    }

    fn along(&self, item: usize, at: &NodeView<Dual64>, with: &Covector) -> [f64; 2] {
        self.items[item].along(at, with)
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
