//! Elements between two bodies, of which one is the ground or a particle: the same formulas with the coordinates that it lacks held at zero.

use nalgebra::SVector;

use crate::model::Owner;
use crate::model::element::ForcePoint;
use crate::{Constraint, Error, Force, PotentialEnergy, Scalar, Scene};

/// An element whose first body is the ground.
#[derive(Clone, Copy, Debug)]
pub struct FromGround<E>(pub E);

/// An element whose second body is the ground.
#[derive(Clone, Copy, Debug)]
pub struct ToGround<E>(pub E);

/// An element between a body and a particle.
#[derive(Clone, Copy, Debug)]
pub struct ToParticle<E>(pub E);

/// An element between a particle and a body.
#[derive(Clone, Copy, Debug)]
pub struct FromParticle<E>(pub E);

/// An element between two particles.
#[derive(Clone, Copy, Debug)]
pub struct BetweenParticles<E>(pub E);

/// An element between the ground and a particle.
#[derive(Clone, Copy, Debug)]
pub struct GroundToParticle<E>(pub E);

/// An element between a particle and the ground.
#[derive(Clone, Copy, Debug)]
pub struct ParticleToGround<E>(pub E);

/// All six coordinates of two bodies from those that are there.
fn all<S: Scalar, const N: usize>(q: &SVector<S, N>, there: [usize; N]) -> SVector<S, 6> {
    let mut all = SVector::from_element(S::zero());
    there.iter().zip(q.iter()).for_each(|(&i, q)| all[i] = *q);
    all
}

macro_rules! with_coordinates {
    ($($wrapper:ident, $n:literal, $there:expr;)*) => {$(
        impl<E: Constraint<6, M, P>, const M: usize, const P: usize> Constraint<$n, M, P> for $wrapper<E> {
            fn phi<S: Scalar>(&self, q: &SVector<S, $n>, b: &SVector<S, P>, t: S) -> SVector<S, M> {
                self.0.phi(&all(q, $there), b, t)
            }
        }

        impl<E: PotentialEnergy<6, P>, const P: usize> PotentialEnergy<$n, P> for $wrapper<E> {
            fn potential_energy<S: Scalar>(&self, q: &SVector<S, $n>, b: &SVector<S, P>, t: S) -> S {
                self.0.potential_energy(&all(q, $there), b, t)
            }
        }

        impl<E: Force<6, K, P>, const K: usize, const P: usize> Force<$n, K, P> for $wrapper<E> {
            fn force<S: Scalar>(&self, at: &ForcePoint<S, $n, K>, b: &SVector<S, P>) -> SVector<S, $n> {
                let at = ForcePoint { q: all(&at.q, $there), v: all(&at.v, $there), u: at.u, t: at.t };
                let force = self.0.force(&at, b);
                SVector::from($there.map(|i| force[i]))
            }
        }
    )*};
}

with_coordinates! {
    FromGround, 3, [3, 4, 5];
    ToGround, 3, [0, 1, 2];
    ToParticle, 5, [0, 1, 2, 3, 4];
    FromParticle, 5, [0, 1, 3, 4, 5];
    BetweenParticles, 4, [0, 1, 3, 4];
    GroundToParticle, 2, [3, 4];
    ParticleToGround, 2, [0, 1];
}

/// Adds an element between two frames, of bodies or of the ground.
macro_rules! between {
    ($frames:expr, $element:ident, $q:ident, $add:expr, $otherwise:expr) => {
        match $frames {
            (Owner::Body(a), Owner::Body(b)) => {
                let $q = [a[0], a[1], a[2], b[0], b[1], b[2]];
                $add
            }
            (Owner::Ground, Owner::Body($q)) => {
                let $element = FromGround($element);
                $add
            }
            (Owner::Body($q), Owner::Ground) => {
                let $element = ToGround($element);
                $add
            }
            _ => $otherwise,
        }
    };
}

/// The same for an element that goes with particles too: each of these costs five more types to compile.
macro_rules! between_any {
    ($frames:expr, $element:ident, $q:ident, $add:expr, $otherwise:expr) => {
        match $frames {
            (Owner::Body(a), Owner::Particle(b)) => {
                let ($element, $q) = (ToParticle($element), [a[0], a[1], a[2], b[0], b[1]]);
                $add
            }
            (Owner::Particle(a), Owner::Body(b)) => {
                let ($element, $q) = (FromParticle($element), [a[0], a[1], b[0], b[1], b[2]]);
                $add
            }
            (Owner::Particle(a), Owner::Particle(b)) => {
                let ($element, $q) = (BetweenParticles($element), [a[0], a[1], b[0], b[1]]);
                $add
            }
            (Owner::Ground, Owner::Particle($q)) => {
                let $element = GroundToParticle($element);
                $add
            }
            (Owner::Particle($q), Owner::Ground) => {
                let $element = ParticleToGround($element);
                $add
            }
            frames => between!(frames, $element, $q, $add, $otherwise),
        }
    };
}

pub(super) use {between, between_any};

impl Scene {
    /// Reports an element between frames that it does not go with.
    pub(super) fn report_frames(&mut self, element: &str, frames: (Owner, Owner)) {
        let element = element.to_string();
        let particle = matches!(frames.0, Owner::Particle(_)) || matches!(frames.1, Owner::Particle(_));
        self.report(if particle { Error::Particle { element } } else { Error::NoBody { element } });
    }
}
