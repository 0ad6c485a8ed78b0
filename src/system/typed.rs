//! An element behind a trait that hides its type; only this code is compiled for each type of element.
//!
//! The code that builds derivatives and adds them to the sums is shared by all elements; see [`item`](super::item).

use nalgebra::SVector;
use num_traits::Zero;

use super::formula::Component;
use super::jet::{ElementKind, FirstDerivatives, Jet, Local, Number};
use super::second_by_columns::by_columns;
use super::shape::Shape;
use crate::number::{Fingerprint, Hyper, Slope};
use crate::program::Symbol;
use crate::{Cx, Scalar};

/// The second derivatives of elements with more coordinates are computed column by column.
const WIDE: usize = 24;

/// An argument of an element's formula, numbered within the element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    Q(usize),
    V(usize),
    Sigma(usize),
    U(usize),
    T,
    B(usize),
}

/// Reads the arguments of a formula.
pub type Read<'a, R> = &'a dyn Fn(Slot) -> R;

/// The contributions of an element, by its plain formula on numbers of type R.
pub trait OnNumbers<R> {
    /// Passes 𝓛_v, 𝓛_q + Q and dΦ/dt to `put`.
    fn first(&self, read: Read<R>, put: &mut dyn FnMut(Component, R));
    /// Passes Φ to `put`.
    fn phi(&self, read: Read<R>, put: &mut dyn FnMut(usize, R));
}

/// The formula (T, V, Q or Φ) on numbers of type S.
pub trait Values<S> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S));
}

/// An element of any type.
pub trait AnyElement:
    OnNumbers<f64>
    + OnNumbers<Cx>
    + OnNumbers<Slope>
    + OnNumbers<Hyper>
    + Values<f64>
    + Values<Symbol>
    + Values<Fingerprint>
    + Send
    + Sync
{
    fn kind(&self) -> ElementKind;
    fn shape(&self) -> Shape;
    /// Computes first derivatives, and writes second derivatives to `blocks`; see [`Jet::blocks`].
    fn blocks(&self, read: Read<f64>, put: &mut dyn FnMut(Component, f64), blocks: &mut [f64]);
}

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
            return by_columns(self, (J::KIND, self.shape()), read, put, blocks);
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
