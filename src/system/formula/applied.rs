//! Generalized forces Q(q, v, u, t) and their tangents Q_q, Q_v.

use nalgebra::SVector;
use num_dual::DualSVec64;

use super::jet::{FirstDerivatives, Jet, Local};
use super::kind::{ElementKind, Number};
use super::typed::{each, vector};
use crate::model::element::ForcePoint;
use crate::{Force, Scalar};

/// An applied force: adds Q to the right-hand side of Eq. (1b).
pub struct Applied<E>(pub E);

impl<E> Applied<E> {
    fn force<S: Scalar, const N: usize, const K: usize, const P: usize>(
        &self,
        q: SVector<S, N>,
        v: SVector<S, N>,
        at: &Local<f64, N, 0, K>,
        b: &SVector<f64, P>,
    ) -> SVector<S, N>
    where
        E: Force<N, K, P>,
    {
        self.0.force(&ForcePoint { q, v, u: each(&at.u, S::from), t: S::from(at.t) }, &each(b, S::from))
    }
}

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> Jet<N, 0, K, P> for Applied<E> {
    const KIND: ElementKind = ElementKind::Applied;

    fn first<R: Number>(&self, at: &Local<R, N, 0, K>, b: &SVector<R, P>) -> FirstDerivatives<R, N, 0> {
        let force = self.0.force(&ForcePoint { q: at.q, v: at.v, u: at.u, t: at.t }, b);
        FirstDerivatives { force, ..FirstDerivatives::zero() }
    }

    fn values<S: Scalar>(&self, at: &Local<S, N, 0, K>, b: &SVector<S, P>, put: &mut dyn FnMut(S)) {
        let force = self.0.force(&ForcePoint { q: at.q, v: at.v, u: at.u, t: at.t }, b);
        force.iter().for_each(|component| put(*component));
    }

    fn blocks(
        &self,
        at: &Local<f64, N, 0, K>,
        b: &SVector<f64, P>,
        first: &mut FirstDerivatives<f64, N, 0>,
        blocks: &mut [f64],
    ) {
        blocks.fill(0.0);
        let (q_v, q_q) = blocks.split_at_mut(N * N);
        put(&self.force(each(&at.q, From::from), seeded(&at.v), at, b), q_v);
        first.force += put(&self.force(seeded(&at.q), each(&at.v, From::from), at, b), q_q);
    }
}

/// The vector x as dual numbers, each component seeded with its own derivative.
fn seeded<const N: usize>(x: &SVector<f64, N>) -> SVector<DualSVec64<N>, N> {
    vector(|i| DualSVec64::from_re(x[i]).derivative(i))
}

/// Writes the gradients row by row and returns the values.
fn put<const N: usize>(force: &SVector<DualSVec64<N>, N>, rows: &mut [f64]) -> SVector<f64, N> {
    for (i, component) in force.iter().enumerate() {
        if let Some(gradient) = component.eps.0 {
            rows[i * N..][..N].copy_from_slice(gradient.as_slice());
        }
    }
    each(force, |component| component.re)
}
