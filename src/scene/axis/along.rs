//! Elements of one coordinate, placed along an axis s = Σ a_k q_k.

use nalgebra::SVector;

use super::Axis;
use crate::model::Param;
use crate::model::element::{ForcePoint, ListForcePoint};
use crate::{
    Constraint, Force, KineticEnergy, ListConstraint, ListForce, ListKineticEnergy, ListPotentialEnergy, PotentialEnergy,
    Scalar,
};

/// An element of the coordinate s with P parameters as one of the coordinates q of an axis; its parameters are b = [a, those of the element].
pub(super) struct Along<E, const P: usize>(pub(super) E);

/// s = Σ a_k q_k, or its rate.
pub(super) fn combined<S: Scalar>(q: &[S], b: &[S]) -> SVector<S, 1> {
    SVector::from([q.iter().zip(b).map(|(q, a)| *a * *q).sum::<S>()])
}

/// The parameters of the element, which follow n factors.
fn after<S: Scalar, const P: usize>(n: usize, b: &[S]) -> SVector<S, P> {
    SVector::from_fn(|i, _| b[n + i])
}

impl<E: KineticEnergy<1, P>, const P: usize> ListKineticEnergy for Along<E, P> {
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S {
        self.0.kinetic_energy(&combined(q, b), &combined(v, b), &after(q.len(), b))
    }
}

impl<E: PotentialEnergy<1, P>, const P: usize> ListPotentialEnergy for Along<E, P> {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], t: S) -> S {
        self.0.potential_energy(&combined(q, b), &after(q.len(), b), t)
    }
}

impl<E: Constraint<1, 1, P>, const P: usize> ListConstraint for Along<E, P> {
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], t: S, phi: &mut [S]) {
        phi[0] = self.0.phi(&combined(q, b), &after(q.len(), b), t)[0];
    }
}

/// A force along an axis that is driven by K controls.
pub(super) struct Push<E, const K: usize, const P: usize>(pub(super) E);

impl<E: Force<1, K, P>, const K: usize, const P: usize> ListForce for Push<E, K, P> {
    fn force<S: Scalar>(&self, at: &ListForcePoint<S>, b: &[S], force: &mut [S]) {
        let u = SVector::from_fn(|i, _| at.u[i]);
        let point = ForcePoint { q: combined(at.q, b), v: combined(at.v, b), u, t: at.t };
        let push = self.0.force(&point, &after(at.q.len(), b))[0];
        force.iter_mut().zip(b).for_each(|(force, a)| *force = *a * push);
    }
}

impl Axis {
    /// The factors, and the parameters of an element.
    pub(super) fn and(&self, b: &[Param]) -> Vec<Param> {
        [&self.factors, b].concat()
    }
}
