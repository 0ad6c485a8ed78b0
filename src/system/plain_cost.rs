//! A cost behind a trait that hides its type; only this code is compiled for each type of cost.

use nalgebra::SVector;
use num_dual::DualSVec64;

use crate::model::element::{Cost, CostPoint, ListCost, ListPoint};
use crate::number::{Fingerprint, Hyper};
use crate::program::Symbol;
use crate::{Cx, Scalar};

/// The number of derivatives that dual numbers carry at once.
pub const SEEDS: usize = 4;

/// The formula of a cost on numbers of type S.
pub trait PlainCost<S> {
    fn value(&self, at: &ListPoint<S>) -> S;
}

impl<C: ListCost, S: Scalar> PlainCost<S> for C {
    fn value(&self, at: &ListPoint<S>) -> S {
        self.cost(at)
    }
}

/// A cost of any type.
pub trait AnyCost:
    PlainCost<f64>
    + PlainCost<Cx>
    + PlainCost<Hyper>
    + PlainCost<DualSVec64<SEEDS>>
    + PlainCost<Symbol>
    + PlainCost<Fingerprint>
    + Send
    + Sync
{
}

impl<C: ListCost> AnyCost for C {}

/// Adapter: a cost with fixed numbers of arguments, used as a [`ListCost`].
pub struct Fixed<C, const N: usize, const M: usize, const K: usize, const P: usize>(pub C);

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
