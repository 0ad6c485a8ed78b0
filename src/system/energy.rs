//! Kinetic and potential energy as parts of 𝓛 = T − V + σᵀ dΦ/dt.

use nalgebra::SVector;
use num_dual::{Dual2SVec64, DualSVec, gradient, hessian, partial_hessian};

use super::jet::{ElementKind, FirstDerivatives, Jet, Local, Number};
use super::typed::{each, vector};
use crate::{KineticEnergy, PotentialEnergy, Scalar};

/// A kinetic energy: 𝓛_v = T_v, 𝓛_q = T_q.
pub struct Kinetic<E>(pub E);

/// A potential energy: 𝓛_q = −V_q.
pub struct Potential<E>(pub E);

fn constant<R: Number, const N: usize, const D: usize>(x: &SVector<R, N>) -> SVector<DualSVec<R, D>, N> {
    each(x, DualSVec::from_re)
}

/// The vector x as second-order dual numbers, each component seeded with its own derivative.
fn seeded<const N: usize>(x: &SVector<f64, N>) -> SVector<Dual2SVec64<N>, N> {
    vector(|i| Dual2SVec64::from_re(x[i]).derivative(i))
}

impl<E: KineticEnergy<N, P>, const N: usize, const P: usize> Jet<N, 0, 0, P> for Kinetic<E> {
    const KIND: ElementKind = ElementKind::Kinetic;

    fn first<R: Number>(&self, at: &Local<R, N, 0, 0>, b: &SVector<R, P>) -> FirstDerivatives<R, N, 0> {
        let (q, v, b) = (constant(&at.q), constant(&at.v), constant(b));
        let (_, l_v) = gradient(|v| self.0.kinetic_energy(&q, &v, &b), &at.v);
        let (_, force) = gradient(|q| self.0.kinetic_energy(&q, &v, &b), &at.q);
        FirstDerivatives { l_v, force, phi_dot: SVector::zeros() }
    }

    fn values<S: Scalar>(&self, at: &Local<S, N, 0, 0>, b: &SVector<S, P>, put: &mut dyn FnMut(S)) {
        put(self.0.kinetic_energy(&at.q, &at.v, b));
    }

    fn blocks(
        &self,
        at: &Local<f64, N, 0, 0>,
        b: &SVector<f64, P>,
        first: &mut FirstDerivatives<f64, N, 0>,
        blocks: &mut [f64],
    ) {
        let b_of_block = each(b, From::from);
        let (_, t_v, t_vv) = hessian(|v| self.0.kinetic_energy(&each(&at.q, From::from), &v, &b_of_block), &at.v);
        let (_, t_q, t_qq) = hessian(|q| self.0.kinetic_energy(&q, &each(&at.v, From::from), &b_of_block), &at.q);
        let b = each(b, From::from);
        let (_, _, _, t_vq) = partial_hessian(|(v, q)| self.0.kinetic_energy(&q, &v, &b), (&at.v, &at.q));
        first.l_v += t_v;
        first.force += t_q;
        for (block, second) in blocks.chunks_exact_mut((N * N).max(1)).zip([t_vv, t_vq, t_qq]) {
            block.iter_mut().enumerate().for_each(|(k, entry)| *entry = second[(k / N, k % N)]);
        }
    }
}

impl<E: PotentialEnergy<N, P>, const N: usize, const P: usize> Jet<N, 0, 0, P> for Potential<E> {
    const KIND: ElementKind = ElementKind::Potential;

    fn first<R: Number>(&self, at: &Local<R, N, 0, 0>, b: &SVector<R, P>) -> FirstDerivatives<R, N, 0> {
        let (b, t) = (constant(b), DualSVec::from_re(at.t));
        let (_, v_q) = gradient(|q| self.0.potential_energy(&q, &b, t), &at.q);
        FirstDerivatives { l_v: SVector::zeros(), force: -v_q, phi_dot: SVector::zeros() }
    }

    fn values<S: Scalar>(&self, at: &Local<S, N, 0, 0>, b: &SVector<S, P>, put: &mut dyn FnMut(S)) {
        put(self.0.potential_energy(&at.q, b, at.t));
    }

    fn blocks(
        &self,
        at: &Local<f64, N, 0, 0>,
        b: &SVector<f64, P>,
        first: &mut FirstDerivatives<f64, N, 0>,
        blocks: &mut [f64],
    ) {
        let energy = self.0.potential_energy(&seeded(&at.q), &each(b, From::from), at.t.into());
        blocks.fill(0.0);
        if let Some(v_q) = energy.v1.0 {
            first.force -= v_q.transpose();
        }
        if let Some(v_qq) = energy.v2.0 {
            blocks.iter_mut().zip(v_qq.iter()).for_each(|(entry, second)| *entry = -second);
        }
    }
}
