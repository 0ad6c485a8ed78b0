//! Derivatives of a kinetic energy T(q, v; b) and of a potential energy V(q, t; b).

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::{Part, Point};
use super::{Derivative, ElementCheck, Rows};
use crate::{KineticEnergy, PotentialEnergy, Scalar};

/// T as a function of all arguments in one list.
struct Kinetic<'a, E, const N: usize, const P: usize>(&'a E);

/// V as a function of all arguments in one list.
struct Potential<'a, E, const N: usize, const P: usize>(&'a E);

impl<E: KineticEnergy<N, P>, const N: usize, const P: usize> Function for Kinetic<'_, E, N, P> {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let at = Point::<N, 0, 0, P, S>::from_list(x);
        vec![self.0.kinetic_energy(&at.q, &at.v, &at.b)]
    }
}

impl<E: PotentialEnergy<N, P>, const N: usize, const P: usize> Function for Potential<'_, E, N, P> {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let at = Point::<N, 0, 0, P, S>::from_list(x);
        vec![self.0.potential_energy(&at.q, &at.b, at.t)]
    }
}

/// Checks hand-derived derivatives of a kinetic energy with the physical constants `b`.
pub fn kinetic_energy<E, const N: usize, const P: usize>(element: &E, b: [f64; P]) -> ElementCheck<'_, E, N, 0, 0, P>
where
    E: KineticEnergy<N, P>,
{
    ElementCheck::new(element, "kinetic energy", b)
}

/// Checks hand-derived derivatives of a potential energy with the physical constants `b`.
pub fn potential_energy<E, const N: usize, const P: usize>(element: &E, b: [f64; P]) -> ElementCheck<'_, E, N, 0, 0, P>
where
    E: PotentialEnergy<N, P>,
{
    ElementCheck::new(element, "potential energy", b)
}

/// T_v = M v, and the gradients by q.
const MOMENTUM: Derived = Derived::gradient(Part::V);
const GRADIENT: Derived = Derived::gradient(Part::Q);

const OF_T: Rows = Rows::One("T");
const OF_T_V: Rows = Rows::Coordinates("T_v of ");
const OF_V: Rows = Rows::One("V");
const OF_V_Q: Rows = Rows::Coordinates("V_q of ");

impl<'a, E: KineticEnergy<N, P>, const N: usize, const P: usize> ElementCheck<'a, E, N, 0, 0, P> {
    blocks! { Kinetic, Point<N, 0, 0, P>;
        /// T itself.
        t: Derivative::value("T", OF_T, Derived::VALUE);
        /// M = T_vv, N × N.
        mass: Derivative::new("M", OF_T_V, MOMENTUM, Part::V).not("(M v)_q", MOMENTUM, Part::Q);
        /// p = T_v = M v, N numbers.
        t_v: Derivative::new("T_v", OF_T, Derived::VALUE, Part::V).not("T_q", Derived::VALUE, Part::Q);
        /// T_q = ½ (vᵀ M v)_q, N numbers.
        t_q: Derivative::new("T_q", OF_T, Derived::VALUE, Part::Q).not("T_v", Derived::VALUE, Part::V);
        /// (M v)_q = T_vq, N × N, with v held.
        mass_v_q: Derivative::new("(M v)_q", OF_T_V, MOMENTUM, Part::Q).not("M", MOMENTUM, Part::V);
        /// T_qq, N × N.
        t_qq: Derivative::new("T_qq", Rows::Coordinates("T_q of "), GRADIENT, Part::Q);
        /// (M v)_b, N × P.
        mass_v_b: Derivative::new("(M v)_b", OF_T_V, MOMENTUM, Part::B);
    }
}

impl<'a, E: PotentialEnergy<N, P>, const N: usize, const P: usize> ElementCheck<'a, E, N, 0, 0, P> {
    blocks! { Potential, Point<N, 0, 0, P>;
        /// V itself.
        v: Derivative::value("V", OF_V, Derived::VALUE);
        /// V_q, N numbers; the force is −V_q.
        v_q: Derivative::new("V_q", OF_V, Derived::VALUE, Part::Q);
        /// V_qq, N × N.
        v_qq: Derivative::new("V_qq", OF_V_Q, GRADIENT, Part::Q);
        /// V_qb, N × P.
        v_qb: Derivative::new("V_qb", OF_V_Q, GRADIENT, Part::B);
    }
}
