//! Derivatives of a kinetic energy T(q, v; b) and of a potential energy V(q, t; b).

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::Point;
use super::{Derivative, ElementCheck, Rows, Value};
use crate::{KineticEnergy, PotentialEnergy, Scalar};

/// T as a function of all arguments in one list.
struct Kinetic<'a, E, const N: usize, const P: usize>(&'a E);

/// V as a function of all arguments in one list.
struct Potential<'a, E, const N: usize, const P: usize>(&'a E);

impl<E, const N: usize, const P: usize> Clone for Kinetic<'_, E, N, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E, const N: usize, const P: usize> Copy for Kinetic<'_, E, N, P> {}

impl<E, const N: usize, const P: usize> Clone for Potential<'_, E, N, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E, const N: usize, const P: usize> Copy for Potential<'_, E, N, P> {}

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

impl<'a, E: KineticEnergy<N, P>, const N: usize, const P: usize> ElementCheck<'a, E, N, 0, 0, P> {
    fn of_t<A: Matrix>(mut self, derivative: Derivative, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        self.blocks.push(derivative.by_hand(Kinetic(self.element), hand));
        self
    }

    fn momentum() -> Derived {
        Derived::Gradient { q: Self::PLACES.v(), sigma: None }
    }

    /// T itself.
    pub fn t<A: Matrix>(mut self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        self.blocks.push(Value("T", Rows::One("T"), Derived::Value).by_hand(Kinetic(self.element), hand));
        self
    }

    /// M = T_vv, N × N.
    pub fn mass<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        let block = Derivative::new("M", Rows::Coordinates("T_v of "), Self::momentum(), at.v());
        self.of_t(block.not("(M v)_q", Self::momentum(), at.q()), hand)
    }

    /// p = T_v = M v, N numbers.
    pub fn t_v<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        self.of_t(Derivative::new("T_v", Rows::One("T"), Derived::Value, at.v()).not("T_q", Derived::Value, at.q()), hand)
    }

    /// T_q = ½ (vᵀ M v)_q, N numbers.
    pub fn t_q<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        self.of_t(Derivative::new("T_q", Rows::One("T"), Derived::Value, at.q()).not("T_v", Derived::Value, at.v()), hand)
    }

    /// (M v)_q = T_vq, N × N, with v held.
    pub fn mass_v_q<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        let block = Derivative::new("(M v)_q", Rows::Coordinates("T_v of "), Self::momentum(), at.q());
        self.of_t(block.not("M", Self::momentum(), at.v()), hand)
    }

    /// T_qq, N × N.
    pub fn t_qq<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        let force = Derived::Gradient { q: at.q(), sigma: None };
        self.of_t(Derivative::new("T_qq", Rows::Coordinates("T_q of "), force, at.q()), hand)
    }

    /// (M v)_b, N × P.
    pub fn mass_v_b<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        self.of_t(Derivative::new("(M v)_b", Rows::Coordinates("T_v of "), Self::momentum(), at.b()), hand)
    }
}

impl<'a, E: PotentialEnergy<N, P>, const N: usize, const P: usize> ElementCheck<'a, E, N, 0, 0, P> {
    fn of_v<A: Matrix>(mut self, derivative: Derivative, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        self.blocks.push(derivative.by_hand(Potential(self.element), hand));
        self
    }

    /// V itself.
    pub fn v<A: Matrix>(mut self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        self.blocks.push(Value("V", Rows::One("V"), Derived::Value).by_hand(Potential(self.element), hand));
        self
    }

    /// V_q, N numbers; the force is −V_q.
    pub fn v_q<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let by_q = Self::PLACES.q();
        self.of_v(Derivative::new("V_q", Rows::One("V"), Derived::Value, by_q), hand)
    }

    /// V_qq, N × N.
    pub fn v_qq<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let by_q = Self::PLACES.q();
        let gradient = Derived::Gradient { q: by_q.clone(), sigma: None };
        self.of_v(Derivative::new("V_qq", Rows::Coordinates("V_q of "), gradient, by_q), hand)
    }

    /// V_qb, N × P.
    pub fn v_qb<A: Matrix>(self, hand: impl Fn(&Point<N, 0, 0, P>) -> A + 'a) -> Self {
        let at = Self::PLACES;
        let gradient = Derived::Gradient { q: at.q(), sigma: None };
        self.of_v(Derivative::new("V_qb", Rows::Coordinates("V_q of "), gradient, at.b()), hand)
    }
}
