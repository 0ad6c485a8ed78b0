//! Derivatives of a cost h(y, u, t; b) or S(y; b).

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::{Part, Point};
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

impl<'a, E, const N: usize, const M: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, M, K, P>
where
    E: Cost<N, M, K, P>,
{
    fn by_part<A: Matrix>(mut self, name: &'static str, by: Part, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        let states =
            [("h_q", Part::Q), ("h_v", Part::V), ("h_p*", Part::PStar), ("h_ṗ*", Part::PStarDot), ("h_v̇", Part::VDot)];
        let alike = |part: Part| part != by && Self::PLACES.of(part).len() == Self::PLACES.of(by).len();
        let block = Derivative::new(name, Rows::One("h"), Derived::VALUE, by);
        let others = states.into_iter().filter(|&(_, part)| alike(part));
        let block = others.fold(block, |block, (name, part)| block.not(name, Derived::VALUE, part));
        self.blocks.push(block.by_hand(Value(self.element), hand));
        self
    }

    /// h itself.
    pub fn h<A: Matrix>(mut self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        let value = Derivative::value("h", Rows::One("h"), Derived::VALUE);
        self.blocks.push(value.by_hand(Value(self.element), hand));
        self
    }

    /// h_q, N numbers.
    pub fn h_q<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_q", Part::Q, hand)
    }

    /// h_v, N numbers.
    pub fn h_v<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_v", Part::V, hand)
    }

    /// h_p*, N numbers.
    pub fn h_p_star<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_p*", Part::PStar, hand)
    }

    /// h_ṗ*, N numbers.
    pub fn h_p_star_dot<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_ṗ*", Part::PStarDot, hand)
    }

    /// h_v̇, N numbers.
    pub fn h_v_dot<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_v̇", Part::VDot, hand)
    }

    /// h_λ, M numbers.
    pub fn h_lambda<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_λ", Part::Lambda, hand)
    }

    /// h_σ, M numbers.
    pub fn h_sigma<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_σ", Part::Sigma, hand)
    }

    /// h_u, K numbers.
    pub fn h_u<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_u", Part::U, hand)
    }

    /// h_u̇, K numbers.
    pub fn h_u_dot<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_u̇", Part::UDot, hand)
    }

    /// h_b, P numbers.
    pub fn h_b<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_b", Part::B, hand)
    }
}
