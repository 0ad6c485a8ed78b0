//! An element of a scene: its formula, generic over the number type, and its connections.

use std::sync::Arc;

use super::connections::Connections;
use super::differentiated::{Component, Formula};
use super::element::Element;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, OnNumbers, Values};
use super::placed::Placed;
use super::shape::{Argument, Slot, distinct};
use super::vectors::{Covector, Entry, InputRows, Sums};
use super::view::NodeView;
use crate::Scalar;
use crate::number::{Hyper, Slope, hyper, hyper_parts, slope, with_slope};

/// An element and the arguments it is connected to.
pub type PlacedElement = Placed<dyn AnyElement>;

impl PlacedElement {
    pub fn new(name: &str, formula: Arc<dyn AnyElement>, to: Connections) -> Self {
        let shape = formula.shape();
        let (name, slots) = (name.to_string(), shape.of_element().collect());
        Placed { name, formula, shape, to, slots, depends: None, is_graph: false }
    }

    /// Adds the element's 𝓛_v, 𝓛_q + Q and dΦ/dt.
    pub fn add<R: Number>(&self, formula: &dyn OnNumbers<R>, at: &NodeView<R>, sums: &mut Sums<R>) {
        formula.first(&|slot| self.to.read(at, slot), &mut |of, x| *self.place(of, sums) += x);
    }

    /// Evaluates Φ: `put` receives the number of each equation in the scene, and Φ_j.
    pub fn phi(&self, at: &NodeView<f64>, mut put: impl FnMut(usize, f64)) {
        let mut equations = self.to.sigma.iter();
        Values::<f64>::values(&*self.formula, &|slot| self.to.read(at, slot), &mut |x| {
            equations.next().into_iter().for_each(|&j| put(j, x));
        });
    }

    /// Evaluates Φ on other numbers, as [`phi`](Self::phi).
    pub fn write_phi<R: Number>(&self, formula: &dyn OnNumbers<R>, at: &NodeView<R>, mut put: impl FnMut(usize, R)) {
        formula.phi(&|slot| self.to.read(at, slot), &mut |j, x| put(self.to.sigma[j], x));
    }

    /// The sum to which a component of the element is added.
    pub(in crate::system) fn place<'a, R: Number>(&self, of: Component, sums: &'a mut Sums<R>) -> &'a mut R {
        &mut sums.all[of.place((&self.to.q, &self.to.sigma), sums.n)]
    }

    /// The factor of a component in c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt.
    pub(in crate::system) fn weight(&self, of: Component, with: &Covector) -> f64 {
        match of {
            Component::Momentum(i) => with.c[self.to.q[i]],
            Component::Force(i) => with.d[self.to.q[i]],
            Component::Equation(j) => with.e[self.to.sigma[j]],
        }
    }

    /// The energy T or V.
    pub fn energy(&self, at: &NodeView<f64>) -> f64 {
        let mut sum = 0.0;
        Values::<f64>::values(&*self.formula, &|slot| self.to.read(at, slot), &mut |value| sum += value);
        sum
    }

    /// The element after its formula was recorded.
    pub fn element(&self, place: (usize, usize), formula: Arc<Formula>, numbers: Vec<f64>) -> Element {
        Element { name: self.name.clone(), place, to: self.to.clone(), formula, numbers }
    }

    /// The arguments that cause Φ not to be finite.
    pub fn find_undefined_phi(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        self.to_blame(at, |read| {
            let mut is_fine = true;
            Values::<f64>::values(&*self.formula, read, &mut |x| is_fine &= x.is_finite());
            is_fine
        })
    }

    /// The arguments that cause a value not to be finite, otherwise those whose derivatives are not finite, if any.
    pub fn find_not_finite(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        let undefined = self.to_blame(at, |read| {
            let mut is_fine = true;
            let read = |slot| with_slope(read(slot), 0.0);
            OnNumbers::<Slope>::first(&*self.formula, &read, &mut |_, x| is_fine &= x.re().is_finite());
            is_fine
        });
        undefined.or_else(|| self.find_infinite_derivatives(at))
    }

    fn find_infinite_derivatives(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        let (kind, shape) = (self.formula.kind(), self.shape);
        let mut blocks = vec![0.0; kind.length(shape.n, shape.m)];
        self.formula.blocks(&|slot| self.to.read(at, slot), &mut |_, _| (), &mut blocks);
        let infinite = blocks.iter().enumerate().filter(|(_, entry)| !entry.is_finite());
        let mut arguments: Vec<Argument> = infinite
            .map(|(which, _)| {
                // Every block has one column per coordinate; the first block of energies and forces belongs to the velocities.
                let by_v = matches!(kind, ElementKind::Kinetic | ElementKind::Applied) && which < shape.n * shape.n;
                let i = self.to.q[which % shape.n];
                if by_v { Slot::V(i) } else { Slot::Q(i) }
            })
            .collect();
        if arguments.is_empty() {
            return None;
        }
        // Columns of arguments on which the formula does not depend may be 0 · NaN.
        let known = self.arguments(at);
        arguments.retain(|argument| known.contains(argument));
        Some(distinct(if arguments.is_empty() { known } else { arguments }))
    }

    /// Evaluates the contributions and their derivatives by dual numbers.
    pub fn evaluate(&self, at: &NodeView<f64>, sums: &mut Sums<f64>, blocks: &mut [f64]) {
        self.formula.blocks(&|slot| self.to.read(at, slot), &mut |of, x| *self.place(of, sums) += x, blocks);
    }
}

/// Derivatives with respect to one argument.
impl PlacedElement {
    /// An argument, with derivative 1 if it is `seed`.
    fn seeded(&self, at: &NodeView<f64>, seed: Slot, slot: Slot) -> Slope {
        with_slope(self.to.read(at, slot), f64::from(slot == seed))
    }

    /// The derivatives of 𝓛_v, 𝓛_q + Q and dΦ/dt with respect to one argument.
    fn differentiate(&self, at: &NodeView<f64>, seed: Slot, put: &mut dyn FnMut(Component, f64)) {
        let read = |slot| self.seeded(at, seed, slot);
        OnNumbers::<Slope>::first(&*self.formula, &read, &mut |of, x| put(of, slope(&x)));
    }

    /// The derivative of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to one argument.
    pub(in crate::system) fn directional(&self, at: &NodeView<f64>, with: &Covector, seed: Slot) -> f64 {
        let mut sum = 0.0;
        self.differentiate(at, seed, &mut |of, slope| sum += slope * self.weight(of, with));
        sum
    }

    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate, for given rates of all arguments except constants.
    pub fn along(&self, at: &NodeView<f64>, rates: &NodeView<f64>, with: &Covector) -> [f64; 2] {
        let read = |slot: Slot| {
            let rate = if let Slot::B(_) = slot { 0.0 } else { self.to.read(rates, slot) };
            hyper(self.to.read(at, slot), rate, 0.0, 0.0)
        };
        let mut sums = [0.0; 2];
        OnNumbers::<Hyper>::first(&*self.formula, &read, &mut |of, x| {
            let ([value, rate, ..], weight) = (hyper_parts(&x), self.weight(of, with));
            sums[0] += value * weight;
            sums[1] += rate * weight;
        });
        sums
    }

    /// The first input with respect to which the derivatives are not finite.
    pub fn find_bad_input(&self, at: &NodeView<f64>) -> Option<Argument> {
        let is_bad = |seed: Slot| {
            let mut is_finite = true;
            self.differentiate(at, seed, &mut |_, slope| is_finite &= slope.is_finite());
            !is_finite
        };
        let mut inputs = self.inputs().filter(|slot| *slot != Slot::T || self.is_timed());
        inputs.find(|slot| is_bad(*slot)).map(|slot| self.to.argument(slot).0)
    }

    /// Adds the derivatives with respect to u, design variables and time.
    pub fn pull_back_inputs(&self, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows) {
        self.inputs().for_each(|slot| rows.add(self.to.argument(slot), self.directional(at, with, slot)));
    }

    /// Appends the element's entries of M = 𝓛_vv, row by row.
    pub fn mass(&self, at: &NodeView<f64>, entries: &mut Vec<Entry>) {
        let q = &self.to.q;
        let mut block = vec![0.0; q.len() * q.len()];
        self.formula.mass(&|slot| self.to.read(at, slot), &mut block);
        let places = q.iter().flat_map(|&row| q.iter().map(move |&col| (row, col)));
        entries.extend(places.zip(block).map(|((row, col), value)| Entry { row, col, value }));
    }

    /// Whether the element's constraints depend on a design variable.
    pub fn is_set_by_design(&self) -> bool {
        !self.to.sigma.is_empty() && self.to.b.iter().any(|b| b.bound().is_some())
    }

    /// Adds the derivatives of e·Φ with respect to design variables and time.
    pub fn pull_back_phi(&self, at: &NodeView<f64>, e: &[f64], rows: &mut InputRows) {
        if self.to.sigma.is_empty() {
            return;
        }
        let directional = |seed: Slot| {
            let mut sum = 0.0;
            self.differentiate_phi(at, seed, &mut |j, slope| sum += e[self.to.sigma[j]] * slope);
            sum
        };
        let inputs = self.inputs().filter(|slot| matches!(slot, Slot::B(_)) || *slot == Slot::T && self.is_timed());
        inputs.for_each(|slot| rows.add(self.to.argument(slot), directional(slot)));
    }

    fn differentiate_phi(&self, at: &NodeView<f64>, seed: Slot, put: &mut dyn FnMut(usize, f64)) {
        let read = |slot| self.seeded(at, seed, slot);
        OnNumbers::<Slope>::phi(&*self.formula, &read, &mut |j, x| put(j, slope(&x)));
    }

    /// Appends Φ_q of the element, in the scene's numbering.
    pub fn phi_q(&self, at: &NodeView<f64>, entries: &mut Vec<Entry>) {
        let mut put = |j: usize, i: usize, value| entries.push(Entry { row: self.to.sigma[j], col: self.to.q[i], value });
        self.formula.phi_q(&|slot| self.to.read(at, slot), &mut put);
    }
}
