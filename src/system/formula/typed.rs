//! An element of fixed lengths with its type: only this code is compiled for each type of element.

use nalgebra::SVector;
use num_traits::Zero;

use super::differentiated::Component;
use super::jet::{FirstDerivatives, Jet, Local};
use super::kind::{ElementKind, Number};
use super::on_numbers::{AnyElement, OnNumbers, Read, Values, by_columns};
use super::shape::{Shape, Slot};
use crate::Scalar;

/// The second derivatives of elements with more coordinates are computed column by column.
const WIDE: usize = 24;

/// An element with its type.
pub struct Typed<J, const N: usize, const M: usize, const K: usize, const P: usize>(pub J);

impl<J, R, const N: usize, const M: usize, const K: usize, const P: usize> OnNumbers<R> for Typed<J, N, M, K, P>
where
    J: Jet<N, M, K, P>,
    R: Number,
{
    fn first(&self, read: Read<R>, put: &mut dyn FnMut(Component, R)) {
        let (at, b): (Local<R, N, M, K>, SVector<R, P>) = arguments(read);
        put_all(&self.0.first(&at, &b), put);
    }

    fn phi(&self, read: Read<R>, put: &mut dyn FnMut(usize, R)) {
        if M > 0 {
            let (at, b): (Local<R, N, M, K>, SVector<R, P>) = arguments(read);
            put_each(self.0.phi(&at.q, &b, at.t).as_slice(), put);
        }
    }
}

impl<J, S, const N: usize, const M: usize, const K: usize, const P: usize> Values<S> for Typed<J, N, M, K, P>
where
    J: Jet<N, M, K, P>,
    S: Scalar,
{
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let (at, b): (Local<S, N, M, K>, SVector<S, P>) = arguments(read);
        self.0.values(&at, &b, put);
    }
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> AnyElement
    for Typed<J, N, M, K, P>
{
    fn kind(&self) -> ElementKind {
        J::KIND
    }

    fn shape(&self) -> Shape {
        Shape { n: N, m: M, k: K, p: P }
    }

    fn blocks(&self, read: Read<f64>, put: &mut dyn FnMut(Component, f64), blocks: &mut [f64]) {
        if N > WIDE {
            return by_columns(self, read, put, blocks);
        }
        let (at, b): (Local<f64, N, M, K>, SVector<f64, P>) = arguments(read);
        let mut first = FirstDerivatives::zero();
        self.0.blocks(&at, &b, &mut first, blocks);
        put_all(&first, put);
    }
}

/// Builds a vector from its components, as `SVector::from_fn`. Called by functions that are generic over sizes only, so not compiled per element.
#[inline(always)]
pub fn vector<R: nalgebra::Scalar + Copy + Zero, const N: usize>(of: impl Fn(usize) -> R) -> SVector<R, N> {
    let mut values = [R::zero(); N];
    for (i, value) in values.iter_mut().enumerate() {
        *value = of(i);
    }
    SVector::from(values)
}

/// Applies a function to all components; used instead of `map`, so that it is not compiled per element.
pub fn each<R: Copy, S: nalgebra::Scalar + Copy + Zero, const N: usize>(x: &SVector<R, N>, of: fn(R) -> S) -> SVector<S, N> {
    vector(|i| of(x[i]))
}

fn arguments<R: nalgebra::Scalar + Copy + Zero, const N: usize, const M: usize, const K: usize, const P: usize>(
    read: Read<R>,
) -> (Local<R, N, M, K>, SVector<R, P>) {
    let (q, v, sigma, u) = (slots(read, Slot::Q), slots(read, Slot::V), slots(read, Slot::Sigma), slots(read, Slot::U));
    (Local { q, v, sigma, u, t: read(Slot::T) }, slots(read, Slot::B))
}

/// Reads the arguments of one kind; compiled once per number of arguments rather than per element.
fn slots<R: nalgebra::Scalar + Copy + Zero, const N: usize>(read: Read<R>, of: fn(usize) -> Slot) -> SVector<R, N> {
    vector(|i| read(of(i)))
}

fn put_all<R: Copy, const N: usize, const M: usize>(first: &FirstDerivatives<R, N, M>, put: &mut dyn FnMut(Component, R)) {
    put_each(first.l_v.as_slice(), &mut |i, x| put(Component::Momentum(i), x));
    put_each(first.force.as_slice(), &mut |i, x| put(Component::Force(i), x));
    put_each(first.phi_dot.as_slice(), &mut |j, x| put(Component::Equation(j), x));
}

fn put_each<R: Copy>(values: &[R], put: &mut dyn FnMut(usize, R)) {
    values.iter().enumerate().for_each(|(i, x)| put(i, *x));
}
