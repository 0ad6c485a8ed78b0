//! [`Fixed`]: formulas of fixed numbers of arguments.

use nalgebra::SVector;

use super::applied::{Applied, ForceFormula};
use super::energy::{Kinetic, KineticFormula, Potential, PotentialFormula};
use super::holonomic::{ConstraintFormula, Holonomic};
use super::on_numbers::Read;
use super::shape::{Shape, Slot};
use crate::Scalar;
use crate::model::element::{
    Constraint, Cost, CostPoint, Force, ForcePoint, KineticEnergy, ListCost, ListPoint, PotentialEnergy,
};

/// The list as a vector of fixed length.
#[inline]
fn vector<S: Scalar, const L: usize>(x: &[S]) -> SVector<S, L> {
    SVector::from_fn(|i, _| x[i])
}

/// A formula with N coordinates, M multipliers or equations, K controls and P constants.
pub struct Fixed<F, const N: usize, const M: usize, const K: usize, const P: usize>(pub F);

/// The arguments of one list; compiled for each length, not for each element.
fn slots<S: Scalar, const L: usize>(read: Read<S>, of: fn(usize) -> Slot) -> SVector<S, L> {
    SVector::from_fn(|i, _| read(of(i)))
}

impl<E: KineticEnergy<N, P>, const N: usize, const P: usize> KineticFormula for Fixed<E, N, 0, 0, P> {
    fn kinetic_energy<S: Scalar>(&self, _: Shape, read: Read<S>) -> S {
        self.0.kinetic_energy(&slots(read, Slot::Q), &slots(read, Slot::V), &slots(read, Slot::B))
    }
}

impl<E: PotentialEnergy<N, P>, const N: usize, const P: usize> PotentialFormula for Fixed<E, N, 0, 0, P> {
    fn potential_energy<S: Scalar>(&self, _: Shape, read: Read<S>) -> S {
        self.0.potential_energy(&slots(read, Slot::Q), &slots(read, Slot::B), read(Slot::T))
    }
}

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> ForceFormula for Fixed<E, N, 0, K, P> {
    fn force<S: Scalar>(&self, _: Shape, read: Read<S>, put: &mut dyn FnMut(S)) {
        let (q, v, u) = (slots(read, Slot::Q), slots(read, Slot::V), slots(read, Slot::U));
        let force = self.0.force(&ForcePoint { q, v, u, t: read(Slot::T) }, &slots(read, Slot::B));
        force.iter().for_each(|component| put(*component));
    }
}

impl<E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> ConstraintFormula for Fixed<E, N, M, 0, P> {
    fn phi<S: Scalar>(&self, _: Shape, read: Read<S>, put: &mut dyn FnMut(S)) {
        self.0.phi(&slots(read, Slot::Q), &slots(read, Slot::B), read(Slot::T)).iter().for_each(|phi| put(*phi));
    }
}

impl<C: Cost<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> ListCost for Fixed<C, N, M, K, P> {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let ListPoint { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, t, b } = *at;
        let point = CostPoint {
            q: vector(q),
            v: vector(v),
            p_star: vector(p_star),
            p_star_dot: vector(p_star_dot),
            v_dot: vector(v_dot),
            sigma: vector(sigma),
            lambda: vector(lambda),
            u: vector(u),
            u_dot: vector(u_dot),
            t,
        };
        self.0.cost(&point, &vector(b))
    }
}

impl<E, const N: usize, const P: usize> Kinetic<Fixed<E, N, 0, 0, P>, N> {
    pub fn fixed(energy: E) -> Self {
        Kinetic { energy: Fixed(energy), n: N, p: P }
    }
}

impl<E, const N: usize, const P: usize> Potential<Fixed<E, N, 0, 0, P>, N> {
    pub fn fixed(energy: E) -> Self {
        Potential { energy: Fixed(energy), n: N, p: P }
    }
}

impl<E, const N: usize, const K: usize, const P: usize> Applied<Fixed<E, N, 0, K, P>, N> {
    pub fn fixed(force: E) -> Self {
        Applied { force: Fixed(force), n: N, k: K, p: P }
    }
}

impl<E, const N: usize, const M: usize, const P: usize> Holonomic<Fixed<E, N, M, 0, P>, N> {
    pub fn fixed(constraint: E) -> Self {
        Holonomic { constraint: Fixed(constraint), n: N, m: M, p: P }
    }
}
