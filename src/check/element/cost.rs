//! Derivatives of a cost h(y, u, t; b) or S(y; b).

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::Point;
use super::{Derivative, ElementCheck, Rows};
use crate::model::element::CostPoint;
use crate::{Cost, Scalar};
use std::ops::Range;

/// h as a function of all arguments in one list.
struct Value<'a, E, const N: usize, const M: usize, const K: usize, const P: usize>(&'a E);

impl<E, const N: usize, const M: usize, const K: usize, const P: usize> Clone for Value<'_, E, N, M, K, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E, const N: usize, const M: usize, const K: usize, const P: usize> Copy for Value<'_, E, N, M, K, P> {}

impl<E, const N: usize, const M: usize, const K: usize, const P: usize> Function for Value<'_, E, N, M, K, P>
where
    E: Cost<N, M, K, P>,
{
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let Point { q, v, p_star, p_star_dot, sigma, u, t, b } = Point::from_list(x);
        vec![self.0.cost(&CostPoint { q, v, p_star, p_star_dot, sigma, u, t }, &b)]
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
    fn by_part<A: Matrix>(
        mut self,
        name: &'static str,
        by: Range<usize>,
        hand: impl Fn(&Point<N, M, K, P>) -> A + 'a,
    ) -> Self {
        let at = Self::PLACES;
        let parts = [("h_q", at.q()), ("h_v", at.v()), ("h_p*", at.p_star()), ("h_ṗ*", at.p_star_dot())];
        let block = Derivative::new(name, Rows::One("h"), Derived::Value, by.clone());
        let others = parts.into_iter().filter(|(_, range)| *range != by && range.len() == by.len());
        let block = others.fold(block, |block, (name, range)| block.not(name, Derived::Value, range));
        self.blocks.push(block.by_hand(Value(self.element), hand));
        self
    }

    /// h itself.
    pub fn h<A: Matrix>(mut self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.blocks.push(super::Value("h", Rows::One("h"), Derived::Value).by_hand(Value(self.element), hand));
        self
    }

    /// h_q, N numbers.
    pub fn h_q<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_q", Self::PLACES.q(), hand)
    }

    /// h_v, N numbers.
    pub fn h_v<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_v", Self::PLACES.v(), hand)
    }

    /// h_p*, N numbers.
    pub fn h_p_star<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_p*", Self::PLACES.p_star(), hand)
    }

    /// h_ṗ*, N numbers.
    pub fn h_p_star_dot<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_ṗ*", Self::PLACES.p_star_dot(), hand)
    }

    /// h_σ, M numbers.
    pub fn h_sigma<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_σ", Self::PLACES.sigma(), hand)
    }

    /// h_u, K numbers.
    pub fn h_u<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_u", Self::PLACES.u(), hand)
    }

    /// h_b, P numbers.
    pub fn h_b<A: Matrix>(self, hand: impl Fn(&Point<N, M, K, P>) -> A + 'a) -> Self {
        self.by_part("h_b", Self::PLACES.b(), hand)
    }
}
