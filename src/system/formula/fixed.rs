//! [`Fixed`]: formulas of fixed numbers of arguments as formulas of lists.

use nalgebra::SVector;

use super::applied::Applied;
use super::energy::{Kinetic, Potential};
use super::holonomic::Holonomic;
use crate::Scalar;
use crate::model::element::{
    Constraint, Cost, CostPoint, Force, ForcePoint, KineticEnergy, ListConstraint, ListCost, ListForce, ListForcePoint,
    ListKineticEnergy, ListPoint, ListPotentialEnergy, PotentialEnergy,
};

/// The list as a vector of fixed length.
#[inline]
fn vector<S: Scalar, const L: usize>(x: &[S]) -> SVector<S, L> {
    SVector::from_fn(|i, _| x[i])
}

/// A formula with N coordinates, M multipliers or equations, K controls and P constants.
pub struct Fixed<F, const N: usize, const M: usize, const K: usize, const P: usize>(pub F);

impl<E: KineticEnergy<N, P>, const N: usize, const P: usize> ListKineticEnergy for Fixed<E, N, 0, 0, P> {
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S {
        self.0.kinetic_energy(&vector(q), &vector(v), &vector(b))
    }
}

impl<E: PotentialEnergy<N, P>, const N: usize, const P: usize> ListPotentialEnergy for Fixed<E, N, 0, 0, P> {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], t: S) -> S {
        self.0.potential_energy(&vector(q), &vector(b), t)
    }
}

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> ListForce for Fixed<E, N, 0, K, P> {
    fn force<S: Scalar>(&self, at: &ListForcePoint<S>, b: &[S], force: &mut [S]) {
        let at = ForcePoint { q: vector(at.q), v: vector(at.v), u: vector(at.u), t: at.t };
        force.copy_from_slice(self.0.force(&at, &vector(b)).as_slice());
    }
}

impl<E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> ListConstraint for Fixed<E, N, M, 0, P> {
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], t: S, phi: &mut [S]) {
        phi.copy_from_slice(self.0.phi(&vector(q), &vector(b), t).as_slice());
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
