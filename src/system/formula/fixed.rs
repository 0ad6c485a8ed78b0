//! [`Fixed`]: a cost of fixed numbers of arguments as a cost of lists.

use nalgebra::SVector;

use crate::Scalar;
use crate::model::element::{Cost, CostPoint, ListCost, ListPoint};

/// A cost with N coordinates, M multipliers, K controls and P constants.
pub struct Fixed<F, const N: usize, const M: usize, const K: usize, const P: usize>(pub F);

impl<C: Cost<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> ListCost for Fixed<C, N, M, K, P> {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        fn vector<S: Scalar, const L: usize>(x: &[S]) -> SVector<S, L> {
            SVector::from_fn(|i, _| x[i])
        }
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
