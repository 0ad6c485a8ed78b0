//! An element on a subset of its coordinates; the others (those of the ground, or the angle of a particle) are fixed at zero.
//!
//! The element uses the same formula, and no further code is compiled.

use std::sync::Arc;

use super::differentiated::Component;
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, OnNumbers, Read, Values};
use super::shape::{Shape, Slot};
use crate::Scalar;

/// Second derivatives of elements of two bodies with at most this many equations are stored in an array of fixed length.
const EQUATIONS: usize = 6;
const ROOM: usize = ElementKind::Holonomic.length(6, EQUATIONS);

/// An element, and the numbers (within the element) of the coordinates that are present.
pub struct Restricted {
    pub inner: Arc<dyn AnyElement>,
    pub there: &'static [usize],
}

impl Restricted {
    /// The index of a coordinate among those that are present.
    fn place(&self, i: usize) -> Option<usize> {
        self.there.iter().position(|&there| there == i)
    }

    fn read<S>(&self, read: Read<S>, slot: Slot, zero: S) -> S {
        let there = |place: Option<usize>, slot: fn(usize) -> Slot| place.map(|i| read(slot(i)));
        match slot {
            Slot::Q(i) => there(self.place(i), Slot::Q).unwrap_or(zero),
            Slot::V(i) => there(self.place(i), Slot::V).unwrap_or(zero),
            slot => read(slot),
        }
    }

    /// Passes on the components of coordinates that are present.
    fn put_there<R>(&self, put: &mut dyn FnMut(Component, R)) -> impl FnMut(Component, R) {
        move |of, x| {
            let there = match of {
                Component::Momentum(i) => self.place(i).map(Component::Momentum),
                Component::Force(i) => self.place(i).map(Component::Force),
                Component::Equation(j) => Some(Component::Equation(j)),
            };
            if let Some(of) = there {
                put(of, x);
            }
        }
    }

    /// Extracts the blocks of the coordinates that are present from those of all coordinates: n × n, or m × n for equations.
    fn select(&self, all: &[f64], blocks: &mut [f64]) {
        let (kind, Shape { n, m, .. }, own) = (self.inner.kind(), self.inner.shape(), self.there);
        let (squares, rectangles) = all.split_at(kind.squares() * n * n);
        let of_squares = squares.chunks_exact(n * n).flat_map(|block| own.iter().map(move |&row| &block[row * n..][..n]));
        let of_rectangles = rectangles.chunks_exact((m * n).max(1)).flat_map(|block| block.chunks_exact(n));
        let rows = of_squares.chain(of_rectangles);
        for (to, row) in blocks.chunks_exact_mut(own.len()).zip(rows) {
            to.iter_mut().zip(own).for_each(|(to, &col)| *to = row[col]);
        }
    }
}

impl<R: Number> OnNumbers<R> for Restricted
where
    dyn AnyElement: OnNumbers<R>,
{
    fn first(&self, read: Read<R>, put: &mut dyn FnMut(Component, R)) {
        self.inner.first(&|slot| self.read(read, slot, R::zero()), &mut self.put_there(put));
    }

    fn phi(&self, read: Read<R>, put: &mut dyn FnMut(usize, R)) {
        self.inner.phi(&|slot| self.read(read, slot, R::zero()), put);
    }
}

impl<S: Scalar> Values<S> for Restricted
where
    dyn AnyElement: Values<S>,
{
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let mut count = 0;
        let mut put_there = |value| {
            // A force has one component per coordinate.
            let is_there = self.inner.kind() != ElementKind::Applied || self.place(count).is_some();
            count += 1;
            if is_there {
                put(value);
            }
        };
        self.inner.values(&|slot| self.read(read, slot, S::zero()), &mut put_there);
    }
}

impl AnyElement for Restricted {
    fn kind(&self) -> ElementKind {
        self.inner.kind()
    }

    fn shape(&self) -> Shape {
        Shape { n: self.there.len(), ..self.inner.shape() }
    }

    fn blocks(&self, read: Read<f64>, put: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        let Shape { n, m, .. } = self.inner.shape();
        let len = self.inner.kind().length(n, m);
        let (mut room, mut more) = ([0.0; ROOM], Vec::new());
        let all = if len <= ROOM {
            &mut room[..len]
        } else {
            more.resize(len, 0.0);
            &mut more[..]
        };
        self.inner.blocks(&|slot| self.read(read, slot, 0.0), &mut self.put_there(put), all);
        self.select(all, blocks);
    }

    fn phi_q(&self, read: Read<f64>, put: &mut dyn FnMut(usize, usize, f64)) {
        let read = |slot| self.read(read, slot, 0.0);
        self.inner.phi_q(&read, &mut |j, i, x| self.place(i).into_iter().for_each(|i| put(j, i, x)));
    }

    fn mass(&self, read: Read<f64>, block: &mut [f64]) {
        let Shape { n, m, .. } = self.inner.shape();
        let mut all = vec![0.0; self.inner.kind().length(n, m)];
        self.inner.mass(&|slot| self.read(read, slot, 0.0), &mut all[..n * n]);
        self.select(&all, block);
    }
}
