//! Derivatives of a cost h(y, u, t; b) or S(y; b).

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::{Part, Places, Point};
use super::{Derivative, ElementCheck, Rows};
use crate::model::element::CostPoint;
use crate::{Cost, Scalar};

/// h as a function of all arguments in one list.
struct Value<'a, E, const N: usize, const M: usize, const K: usize, const P: usize>(&'a E);

impl<E, const N: usize, const M: usize, const K: usize, const P: usize> Function for Value<'_, E, N, M, K, P>
where
    E: Cost<N, M, K, P>,
{
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let Point { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, t, b } = Point::from_list(x);
        vec![self.0.cost(&CostPoint { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, t }, &b)]
    }
}

/// Checks hand-derived derivatives of a cost, h or S of Eq. (5), with the constants `b`.
pub fn cost<E, const N: usize, const M: usize, const K: usize, const P: usize>(
    cost: &E,
    b: [f64; P],
) -> ElementCheck<'_, E, N, M, K, P>
where
    E: Cost<N, M, K, P>,
{
    ElementCheck::new(cost, "cost", b)
}

/// h differentiated by a part of the arguments, for which one as long may have been taken.
fn by(places: Places, name: &'static str, by: Part) -> Derivative {
    let states = [("h_q", Part::Q), ("h_v", Part::V), ("h_p*", Part::PStar), ("h_ṗ*", Part::PStarDot), ("h_v̇", Part::VDot)];
    let alike = |part: Part| part != by && places.of(part).len() == places.of(by).len();
    let others = states.into_iter().filter(|&(_, part)| alike(part));
    let block = Derivative::new(name, Rows::One("h"), Derived::VALUE, by);
    others.fold(block, |block, (name, part)| block.not(name, Derived::VALUE, part))
}

impl<'a, E, const N: usize, const M: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, M, K, P>
where
    E: Cost<N, M, K, P>,
{
    blocks! { Value, Point<N, M, K, P>;
        /// h itself.
        h: Derivative::value("h", Rows::One("h"), Derived::VALUE);
        /// h_q, N numbers.
        h_q: by(Self::PLACES, "h_q", Part::Q);
        /// h_v, N numbers.
        h_v: by(Self::PLACES, "h_v", Part::V);
        /// h_p*, N numbers.
        h_p_star: by(Self::PLACES, "h_p*", Part::PStar);
        /// h_ṗ*, N numbers.
        h_p_star_dot: by(Self::PLACES, "h_ṗ*", Part::PStarDot);
        /// h_v̇, N numbers.
        h_v_dot: by(Self::PLACES, "h_v̇", Part::VDot);
        /// h_λ, M numbers.
        h_lambda: by(Self::PLACES, "h_λ", Part::Lambda);
        /// h_σ, M numbers.
        h_sigma: by(Self::PLACES, "h_σ", Part::Sigma);
        /// h_u, K numbers.
        h_u: by(Self::PLACES, "h_u", Part::U);
        /// h_u̇, K numbers.
        h_u_dot: by(Self::PLACES, "h_u̇", Part::UDot);
        /// h_b, P numbers.
        h_b: by(Self::PLACES, "h_b", Part::B);
    }
}
