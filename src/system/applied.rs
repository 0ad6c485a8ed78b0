//! Generalized forces Q(q, v, u, t) and their tangents Q_q, Q_v.

use nalgebra::{SMatrix, SVector};
use num_dual::jacobian;

use super::jet::{First, Form, Jet, Local};
use crate::element::ForcePoint;
use crate::scalar::Real;
use crate::trace::{Structure, Trace};
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
        self.0.force(&ForcePoint { q, v, u: at.u.map(S::from), t: S::from(at.t) }, &b.map(S::from))
    }
}

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> Jet<N, 0, K, P> for Applied<E> {
    const FORM: Form = Form::Applied;

    fn first<R: Real>(&self, at: &Local<R, N, 0, K>, b: &SVector<R, P>) -> First<R, N, 0> {
        let force = self.0.force(&ForcePoint { q: at.q, v: at.v, u: at.u, t: at.t }, b);
        First { force, ..First::zero() }
    }

    fn structure(&self, at: &Local<Trace, N, 0, K>, b: &SVector<Trace, P>) -> Structure {
        Structure::of(|| {
            let force = self.0.force(&ForcePoint { q: at.q, v: at.v, u: at.u, t: at.t }, b);
            force.iter().copied().collect::<Vec<_>>()
        })
    }

    fn blocks<const A: usize>(
        &self,
        active: &[usize; A],
        at: &Local<f64, N, 0, K>,
        b: &SVector<f64, P>,
        first: &mut First<f64, N, 0>,
        blocks: &mut [f64],
    ) {
        let (force, q_v): (SVector<f64, N>, SMatrix<f64, N, N>) =
            jacobian(|v| self.force(at.q.map(From::from), v, at, b), &at.v);
        let (_, q_q): (SVector<f64, N>, SMatrix<f64, N, N>) =
            jacobian(|q| self.force(q, at.v.map(From::from), at, b), &at.q);
        first.force += force;
        for (block, tangent) in blocks.chunks_exact_mut((A * A).max(1)).zip([q_v, q_q]) {
            for (k, entry) in block.iter_mut().enumerate() {
                *entry = tangent[(active[k / A], active[k % A])];
            }
        }
    }
}
