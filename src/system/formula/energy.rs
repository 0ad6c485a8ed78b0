//! Kinetic and potential energy as parts of 𝓛 = T − V + σᵀ dΦ/dt.

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, By, OnNumbers, Read, Values, WIDE, by_columns, gradient, hessian};
use super::shape::Shape;
use crate::Scalar;

/// The formula T(q, v; b), which reads its arguments itself.
pub trait KineticFormula: Send + Sync + 'static {
    fn kinetic_energy<S: Scalar>(&self, shape: Shape, read: Read<S>) -> S;
}

/// The formula V(q, t; b), which reads its arguments itself.
pub trait PotentialFormula: Send + Sync + 'static {
    fn potential_energy<S: Scalar>(&self, shape: Shape, read: Read<S>) -> S;
}

/// A kinetic energy of n coordinates and p constants: 𝓛_v = T_v, 𝓛_q = T_q. `WIDTH` derivatives are computed at once.
pub struct Kinetic<E, const WIDTH: usize> {
    pub energy: E,
    pub n: usize,
    pub p: usize,
}

impl<E: KineticFormula, S: Scalar, const WIDTH: usize> Values<S> for Kinetic<E, WIDTH> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        put(self.energy.kinetic_energy(self.shape(), read));
    }
}

impl<E: KineticFormula, R: Number, const WIDTH: usize> OnNumbers<R> for Kinetic<E, WIDTH> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        gradient::<R, WIDTH>(self, (By::V, self.n), read, &mut |_, _| (), &mut |_, i, slope| {
            add(Component::Momentum(i), slope)
        });
        gradient::<R, WIDTH>(self, (By::Q, self.n), read, &mut |_, _| (), &mut |_, i, slope| {
            add(Component::Force(i), slope)
        });
    }
}

impl<E: KineticFormula, const WIDTH: usize> AnyElement for Kinetic<E, WIDTH> {
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
        hessian::<WIDTH>(self, ([By::V, By::V], self.n), read, &mut |i, slope| add(Component::Momentum(i), slope), vv);
        hessian::<WIDTH>(self, ([By::V, By::Q], self.n), read, &mut |_, _| (), vq);
        hessian::<WIDTH>(self, ([By::Q, By::Q], self.n), read, &mut |i, slope| add(Component::Force(i), slope), qq);
    }

    fn mass(&self, read: Read<f64>, block: &mut [f64]) {
        if WIDTH <= WIDE {
            return hessian::<WIDTH>(self, ([By::V, By::V], self.n), read, &mut |_, _| (), block);
        }
        let mut blocks = vec![0.0; 3 * self.n * self.n];
        by_columns(self, read, &mut |_, _| (), &mut blocks);
        block.copy_from_slice(&blocks[..block.len()]);
    }
}

/// A potential energy of n coordinates and p constants: 𝓛_q = −V_q. `WIDTH` derivatives are computed at once.
pub struct Potential<E, const WIDTH: usize> {
    pub energy: E,
    pub n: usize,
    pub p: usize,
}

impl<E: PotentialFormula, S: Scalar, const WIDTH: usize> Values<S> for Potential<E, WIDTH> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        put(self.energy.potential_energy(self.shape(), read));
    }
}

impl<E: PotentialFormula, R: Number, const WIDTH: usize> OnNumbers<R> for Potential<E, WIDTH> {
    fn first(&self, read: Read<R>, add: &mut dyn FnMut(Component, R)) {
        gradient::<R, WIDTH>(self, (By::Q, self.n), read, &mut |_, _| (), &mut |_, i, slope| {
            add(Component::Force(i), -slope)
        });
    }
}

impl<E: PotentialFormula, const WIDTH: usize> AnyElement for Potential<E, WIDTH> {
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
        hessian::<WIDTH>(self, ([By::Q, By::Q], self.n), read, &mut |i, slope| add(Component::Force(i), -slope), blocks);
        blocks.iter_mut().for_each(|x| *x = -*x);
    }
}
