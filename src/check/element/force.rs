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
    blocks! { Applied, Point<N, 0, K, P>;
        /// Q itself, N numbers.
        q: Derivative::value("Q", OF_Q, Derived::VALUE);
        /// Q_q, N × N.
        q_q: by("Q_q", Part::Q).not("Q_v", Derived::VALUE, Part::V);
        /// Q_v, N × N.
        q_v: by("Q_v", Part::V).not("Q_q", Derived::VALUE, Part::Q);
        /// Q_u, N × K.
        q_u: by("Q_u", Part::U);
        /// Q_t, N numbers.
        q_t: by("Q_t", Part::T);
        /// Q_b, N × P.
        q_b: by("Q_b", Part::B);
    }
}
