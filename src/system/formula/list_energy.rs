//! Kinetic and potential energy of lists as parts of 𝓛 = T − V + σᵀ dΦ/dt.

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, OnNumbers, Read, Values, by_columns, gradient, with_lists};
use super::shape::{Shape, Slot};
use crate::Scalar;
use crate::model::element::{ListKineticEnergy, ListPotentialEnergy};

/// A kinetic energy of n coordinates and p constants: 𝓛_v = T_v, 𝓛_q = T_q.
pub struct ListKinetic<E> {
    pub energy: E,
    pub n: usize,
    pub p: usize,
}

impl<E: ListKineticEnergy, S: Scalar> Values<S> for ListKinetic<E> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let lists: [(fn(usize) -> Slot, usize); 3] = [(Slot::Q, self.n), (Slot::V, self.n), (Slot::B, self.p)];
        with_lists(read, lists, &mut |[q, v, b]| put(self.energy.kinetic_energy(q, v, b)));
    }
}

impl<E: ListKineticEnergy, R: Number> OnNumbers<R> for ListKinetic<E> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        gradient(self, (Slot::V, self.n), read, &mut |i, slope| add(Component::Momentum(i), slope));
        gradient(self, (Slot::Q, self.n), read, &mut |i, slope| add(Component::Force(i), slope));
    }
}

impl<E: ListKineticEnergy> AnyElement for ListKinetic<E> {
    fn kind(&self) -> ElementKind {
        ElementKind::Kinetic
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        by_columns(self, read, add, blocks);
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: 0, k: 0, p: self.p }
    }
}

/// A potential energy of n coordinates and p constants: 𝓛_q = −V_q.
pub struct ListPotential<E> {
    pub energy: E,
    pub n: usize,
    pub p: usize,
}

impl<E: ListPotentialEnergy, S: Scalar> Values<S> for ListPotential<E> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let lists: [(fn(usize) -> Slot, usize); 2] = [(Slot::Q, self.n), (Slot::B, self.p)];
        with_lists(read, lists, &mut |[q, b]| put(self.energy.potential_energy(q, b, read(Slot::T))));
    }
}

impl<E: ListPotentialEnergy, R: Number> OnNumbers<R> for ListPotential<E> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        gradient(self, (Slot::Q, self.n), read, &mut |i, slope| add(Component::Force(i), -slope));
    }
}

impl<E: ListPotentialEnergy> AnyElement for ListPotential<E> {
    fn kind(&self) -> ElementKind {
        ElementKind::Potential
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        by_columns(self, read, add, blocks);
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: 0, k: 0, p: self.p }
    }
}
