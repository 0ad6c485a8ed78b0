//! Kinetic and potential energy as parts of 𝓛 = T − V + σᵀ dΦ/dt.

use nalgebra::SVector;
use num_dual::{Dual2SVec64, DualSVec, HyperDualSVec64, gradient};

use super::jet::{FirstDerivatives, Jet, Local};
use super::kind::{ElementKind, Number};
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
        let b = each(b, From::from);
        let seeded = |x: &SVector<f64, N>, [first, second]: [bool; 2]| {
            vector(|i| {
                let x = HyperDualSVec64::<N, N>::from_re(x[i]);
                let x = if first { x.derivative1(i) } else { x };
                if second { x.derivative2(i) } else { x }
            })
        };
        let energy = |v, q| self.0.kinetic_energy(&seeded(&at.q, q), &seeded(&at.v, v), &b);
        let by_v = energy([true, true], [false, false]);
        let by_both = energy([true, false], [false, true]);
        let by_q = energy([false, false], [true, true]);
        if let Some(t_v) = by_v.eps1.0 {
            first.l_v += t_v;
        }
        if let Some(t_q) = by_q.eps1.0 {
            first.force += t_q;
        }
        blocks.fill(0.0);
        for (block, energy) in blocks.chunks_exact_mut((N * N).max(1)).zip([by_v, by_both, by_q]) {
            if let Some(second) = energy.eps1eps2.0 {
                block.iter_mut().enumerate().for_each(|(k, entry)| *entry = second[(k / N, k % N)]);
            }
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
