//! [`Jet`]: formulas of fixed lengths seen through automatic differentiation.

use nalgebra::SVector;

use super::kind::{ElementKind, Number};
use crate::Scalar;

/// The arguments of one element.
#[derive(Clone, Copy, Debug)]
pub struct Local<R, const N: usize, const M: usize, const K: usize> {
    pub q: SVector<R, N>,
    pub v: SVector<R, N>,
    pub sigma: SVector<R, M>,
    pub u: SVector<R, K>,
    pub t: R,
}

/// The contributions of one element to 𝓛_v, to 𝓛_q + Q and to dΦ/dt.
#[derive(Clone, Copy)]
pub struct FirstDerivatives<R, const N: usize, const M: usize> {
    pub l_v: SVector<R, N>,
    pub force: SVector<R, N>,
    pub phi_dot: SVector<R, M>,
}

impl<R: Number, const N: usize, const M: usize> FirstDerivatives<R, N, M> {
    pub fn zero() -> Self {
        FirstDerivatives { l_v: SVector::zeros(), force: SVector::zeros(), phi_dot: SVector::zeros() }
    }
}

/// One kind of element: N coordinates, M constraint equations, K controls, P physical constants.
///
/// `first` is the plain formula, generic over the number type of the simulation. `blocks` computes the same values together with
/// all second derivatives, in real numbers.
pub trait Jet<const N: usize, const M: usize, const K: usize, const P: usize>: Send + Sync + 'static {
    const KIND: ElementKind;

    fn first<R: Number>(&self, at: &Local<R, N, M, K>, b: &SVector<R, P>) -> FirstDerivatives<R, N, M>;

    /// Φ, for constraints.
    fn phi<R: Number>(&self, _q: &SVector<R, N>, _b: &SVector<R, P>, _t: R) -> SVector<R, M> {
        SVector::zeros()
    }

    /// The formula: T, V, Q or Φ.
    fn values<S: Scalar>(&self, at: &Local<S, N, M, K>, b: &SVector<S, P>, put: &mut dyn FnMut(S));

    /// Adds the first derivatives to `first` and writes the second derivatives to `blocks`.
    ///
    /// Order: vv, vq, qq (kinetic); qq (potential); Q_v, Q_q (applied); σᵀΦ_qq, σᵀ(dΦ/dt)_qq, Φ_q, (dΦ/dt)_q (holonomic), each by rows.
    fn blocks(
        &self,
        at: &Local<f64, N, M, K>,
        b: &SVector<f64, P>,
        first: &mut FirstDerivatives<f64, N, M>,
        blocks: &mut [f64],
    );
}
