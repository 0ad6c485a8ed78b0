//! Derivatives of a generalized force Q(q, v, u, t; b).

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::Point;
use super::{Derivative, ElementCheck, Rows, Value};
use crate::model::element::ForcePoint;
use crate::{Force, Scalar};
use std::ops::Range;

/// Q as a function of all arguments in one list.
struct Applied<'a, E, const N: usize, const K: usize, const P: usize>(&'a E);

impl<E, const N: usize, const K: usize, const P: usize> Clone for Applied<'_, E, N, K, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E, const N: usize, const K: usize, const P: usize> Copy for Applied<'_, E, N, K, P> {}

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> Function for Applied<'_, E, N, K, P> {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let at = Point::<N, 0, K, P, S>::from_list(x);
        let point = ForcePoint { q: at.q, v: at.v, u: at.u, t: at.t };
        self.0.force(&point, &at.b).iter().copied().collect()
    }
}

/// Checks hand-derived derivatives of a generalized force with the physical constants `b`.
pub fn force<E, const N: usize, const K: usize, const P: usize>(element: &E, b: [f64; P]) -> ElementCheck<'_, E, N, 0, K, P>
where
    E: Force<N, K, P>,
{
    ElementCheck::new(element, "force", b)
}

impl<'a, E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, 0, K, P> {
    fn of_force<A: Matrix>(mut self, derivative: Derivative, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.blocks.push(derivative.by_hand(Applied(self.element), hand));
        self
    }

    fn by(name: &'static str, range: Range<usize>) -> Derivative {
        Derivative::new(name, Rows::Coordinates("Q of "), Derived::Value, range)
    }

    /// Q itself, N numbers.
    pub fn q<A: Matrix>(mut self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.blocks.push(Value("Q", Rows::Coordinates("Q of "), Derived::Value).by_hand(Applied(self.element), hand));
        self
    }

    /// Q_q, N × N.
    pub fn q_q<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        self.of_force(Self::by("Q_q", at.q()).not("Q_v", Derived::Value, at.v()), hand)
    }

    /// Q_v, N × N.
    pub fn q_v<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        self.of_force(Self::by("Q_v", at.v()).not("Q_q", Derived::Value, at.q()), hand)
    }

    /// Q_u, N × K.
    pub fn q_u<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        let by_u = Self::PLACES.u();
        self.of_force(Self::by("Q_u", by_u), hand)
    }

    /// Q_t, N numbers.
    pub fn q_t<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        let t = Self::PLACES.t();
        self.of_force(Self::by("Q_t", t..t + 1), hand)
    }

    /// Q_b, N × P.
    pub fn q_b<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        let by_b = Self::PLACES.b();
        self.of_force(Self::by("Q_b", by_b), hand)
    }
}
