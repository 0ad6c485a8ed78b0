//! Derivatives of a generalized force Q(q, v, u, t; b).

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::{Part, Point};
use super::{Derivative, ElementCheck, Rows};
use crate::model::element::ForcePoint;
use crate::{Force, Scalar};

/// Q as a function of all arguments in one list.
struct Applied<'a, E, const N: usize, const K: usize, const P: usize>(&'a E);

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

const OF_Q: Rows = Rows::Coordinates("Q of ");

fn by(name: &'static str, part: Part) -> Derivative {
    Derivative::new(name, OF_Q, Derived::VALUE, part)
}

impl<'a, E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, 0, K, P> {
    fn of_force<A: Matrix>(mut self, derivative: Derivative, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.blocks.push(derivative.by_hand(Applied(self.element), hand));
        self
    }

    /// Q itself, N numbers.
    pub fn q<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.of_force(Derivative::value("Q", OF_Q, Derived::VALUE), hand)
    }

    /// Q_q, N × N.
    pub fn q_q<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.of_force(by("Q_q", Part::Q).not("Q_v", Derived::VALUE, Part::V), hand)
    }

    /// Q_v, N × N.
    pub fn q_v<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.of_force(by("Q_v", Part::V).not("Q_q", Derived::VALUE, Part::Q), hand)
    }

    /// Q_u, N × K.
    pub fn q_u<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.of_force(by("Q_u", Part::U), hand)
    }

    /// Q_t, N numbers.
    pub fn q_t<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.of_force(by("Q_t", Part::T), hand)
    }

    /// Q_b, N × P.
    pub fn q_b<A: Matrix>(self, hand: impl Fn(&Point<N, 0, K, P>) -> A + 'a) -> Self {
        self.of_force(by("Q_b", Part::B), hand)
    }
}
