//! Kinetic and potential energy as parts of 𝓛 = T − V + σᵀ dΦ/dt.

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, OnNumbers, Read, Values, WIDE, by_columns, gradient, hessian, with_lists};
use super::shape::{Shape, Slot};
use crate::Scalar;
use crate::model::element::{ListKineticEnergy, ListPotentialEnergy};

/// A kinetic energy of n coordinates and p constants: 𝓛_v = T_v, 𝓛_q = T_q. `WIDTH` derivatives are computed at once.
pub struct Kinetic<E, const WIDTH: usize> {
    pub energy: E,
    pub n: usize,
    pub p: usize,
}

impl<E: ListKineticEnergy, S: Scalar, const WIDTH: usize> Values<S> for Kinetic<E, WIDTH> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        with_lists(read, [(Slot::Q, self.n), (Slot::V, self.n), (Slot::B, self.p)], &mut |[q, v, b]| {
            put(self.energy.kinetic_energy(q, v, b));
        });
    }
}

impl<E: ListKineticEnergy, R: Number, const WIDTH: usize> OnNumbers<R> for Kinetic<E, WIDTH> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        gradient::<R, WIDTH>(self, (Slot::V, self.n), read, &mut |i, slope| add(Component::Momentum(i), slope));
        gradient::<R, WIDTH>(self, (Slot::Q, self.n), read, &mut |i, slope| add(Component::Force(i), slope));
    }
}

impl<E: ListKineticEnergy, const WIDTH: usize> AnyElement for Kinetic<E, WIDTH> {
    fn kind(&self) -> ElementKind {
        ElementKind::Kinetic
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: 0, k: 0, p: self.p }
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        if WIDTH > WIDE {
            return by_columns(self, read, add, blocks);
        }
        blocks.fill(0.0);
        let square = self.n * self.n;
        let (vv, rest) = blocks.split_at_mut(square);
        let (vq, qq) = rest.split_at_mut(square);
        let (q, v): ((fn(usize) -> Slot, usize), (fn(usize) -> Slot, usize)) = ((Slot::Q, self.n), (Slot::V, self.n));
        hessian::<WIDTH>(self, [v, v], read, &mut |i, slope| add(Component::Momentum(i), slope), vv);
        hessian::<WIDTH>(self, [v, q], read, &mut |_, _| (), vq);
        hessian::<WIDTH>(self, [q, q], read, &mut |i, slope| add(Component::Force(i), slope), qq);
    }
}

/// A potential energy of n coordinates and p constants: 𝓛_q = −V_q. `WIDTH` derivatives are computed at once.
pub struct Potential<E, const WIDTH: usize> {
    pub energy: E,
    pub n: usize,
    pub p: usize,
}

impl<E: ListPotentialEnergy, S: Scalar, const WIDTH: usize> Values<S> for Potential<E, WIDTH> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        with_lists(read, [(Slot::Q, self.n), (Slot::B, self.p)], &mut |[q, b]| {
            put(self.energy.potential_energy(q, b, read(Slot::T)));
        });
    }
}

impl<E: ListPotentialEnergy, R: Number, const WIDTH: usize> OnNumbers<R> for Potential<E, WIDTH> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        gradient::<R, WIDTH>(self, (Slot::Q, self.n), read, &mut |i, slope| add(Component::Force(i), -slope));
    }
}

impl<E: ListPotentialEnergy, const WIDTH: usize> AnyElement for Potential<E, WIDTH> {
    fn kind(&self) -> ElementKind {
        ElementKind::Potential
    }

    fn shape(&self) -> Shape {
        Shape { n: self.n, m: 0, k: 0, p: self.p }
    }

    fn blocks(&self, read: Read<f64>, add: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        if WIDTH > WIDE {
            return by_columns(self, read, add, blocks);
        }
        blocks.fill(0.0);
        let lists: [(fn(usize) -> Slot, usize); 2] = [(Slot::Q, self.n); 2];
        hessian::<WIDTH>(self, lists, read, &mut |i, slope| add(Component::Force(i), -slope), blocks);
        blocks.iter_mut().for_each(|x| *x = -*x);
    }
}
