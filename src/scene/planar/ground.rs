//! Elements between two bodies, of which one is the ground: the same formulas with three coordinates held at zero.

use nalgebra::SVector;

use crate::model::element::ForcePoint;
use crate::{Constraint, Force, PotentialEnergy, Scalar};

/// An element whose first body is the ground.
#[derive(Clone, Copy, Debug)]
pub struct FromGround<E>(pub E);

/// An element whose second body is the ground.
#[derive(Clone, Copy, Debug)]
pub struct ToGround<E>(pub E);

fn after_ground<S: Scalar>(q: &SVector<S, 3>) -> SVector<S, 6> {
    SVector::from_fn(|i, _| if i < 3 { S::zero() } else { q[i - 3] })
}

fn before_ground<S: Scalar>(q: &SVector<S, 3>) -> SVector<S, 6> {
    SVector::from_fn(|i, _| if i < 3 { q[i] } else { S::zero() })
}

macro_rules! grounded {
    ($wrapper:ident, $all:ident, $first:literal) => {
        impl<E: Constraint<6, M, P>, const M: usize, const P: usize> Constraint<3, M, P> for $wrapper<E> {
            fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, P>, t: S) -> SVector<S, M> {
                self.0.phi(&$all(q), b, t)
            }
        }

        impl<E: PotentialEnergy<6, P>, const P: usize> PotentialEnergy<3, P> for $wrapper<E> {
            fn potential_energy<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, P>, t: S) -> S {
                self.0.potential_energy(&$all(q), b, t)
            }
        }

        impl<E: Force<6, K, P>, const K: usize, const P: usize> Force<3, K, P> for $wrapper<E> {
            fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, K>, b: &SVector<S, P>) -> SVector<S, 3> {
                let at = ForcePoint { q: $all(&at.q), v: $all(&at.v), u: at.u, t: at.t };
                self.0.force(&at, b).fixed_rows::<3>($first).into_owned()
            }
        }
    };
}

grounded!(FromGround, after_ground, 3);
grounded!(ToGround, before_ground, 0);
