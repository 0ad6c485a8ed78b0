//! Derivatives of a constraint Φ(q, t; b) and of its rate dΦ/dt = Φ_q v + Φ_t.

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::Point;
use super::{Derivative, ElementCheck, Rows, Value};
use crate::{Constraint, Scalar};

/// Φ as a function of all arguments in one list.
struct Phi<'a, E, const N: usize, const M: usize, const P: usize>(&'a E);

impl<E, const N: usize, const M: usize, const P: usize> Clone for Phi<'_, E, N, M, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E, const N: usize, const M: usize, const P: usize> Copy for Phi<'_, E, N, M, P> {}

impl<E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> Function for Phi<'_, E, N, M, P> {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let at = Point::<N, M, 0, P, S>::from_list(x);
        self.0.phi(&at.q, &at.b, at.t).iter().copied().collect()
    }
}

/// Checks hand-derived derivatives of a constraint with the physical constants `b`.
///
/// ```
/// use hamiltonian_adjoint::{check, planar::Revolute};
///
/// let report = check::constraint(&Revolute, [0.5, 0.1, -0.4, 0.2])
///     .coordinates(["x_a", "y_a", "φ_a", "x_b", "y_b", "φ_b"])
///     .equations(["x", "y"])
///     .phi_q(|at| {
///         let ([sa, ca], [sb, cb]) = ([at.q[2].sin(), at.q[2].cos()], [at.q[5].sin(), at.q[5].cos()]);
///         let b = at.b;
///         [
///             [-1.0, 0.0, sa * b[0] + ca * b[1], 1.0, 0.0, -sb * b[2] - cb * b[3]],
///             [0.0, -1.0, -ca * b[0] + sa * b[1], 0.0, 1.0, cb * b[2] - sb * b[3]],
///         ]
///     })
///     .run();
/// report.assert_passed();
/// ```
pub fn constraint<E, const N: usize, const M: usize, const P: usize>(
    element: &E,
    b: [f64; P],
) -> ElementCheck<'_, E, N, M, 0, P>
where
    E: Constraint<N, M, P>,
{
    ElementCheck::new(element, "constraint", b)
}

impl<'a, E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> ElementCheck<'a, E, N, M, 0, P> {
    fn of_phi<A: Matrix>(mut self, derivative: Derivative, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        self.blocks.push(derivative.by_hand(Phi(self.element), hand));
        self
    }

    fn rate(with_time: bool) -> Derived {
        let at = Self::PLACES;
        Derived::Along { q: at.q(), v: at.v(), t: with_time.then(|| at.t()) }
    }

    fn reaction() -> Derived {
        Derived::Gradient { q: Self::PLACES.q(), sigma: Some(Self::PLACES.sigma()) }
    }

    fn rate_of_reaction() -> Derived {
        let at = Self::PLACES;
        Derived::GradientAlong { q: at.q(), v: at.v(), t: at.t(), sigma: at.sigma() }
    }

    /// Φ itself, M numbers.
    pub fn phi<A: Matrix>(mut self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        self.blocks.push(Value("Φ", Rows::Equations("Φ of "), Derived::Value).by_hand(Phi(self.element), hand));
        self
    }

    /// dΦ/dt = Φ_q v + Φ_t itself, M numbers.
    pub fn phi_dot<A: Matrix>(mut self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        self.blocks.push(Value("dΦ/dt", Rows::Equations("dΦ/dt of "), Self::rate(true)).by_hand(Phi(self.element), hand));
        self
    }

    /// Φ_q, M × N.
    pub fn phi_q<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let by_q = Self::PLACES.q();
        self.of_phi(Derivative::new("Φ_q", Rows::Equations("Φ of "), Derived::Value, by_q), hand)
    }

    /// Φ_t, M numbers.
    pub fn phi_t<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let t = Self::PLACES.t();
        self.of_phi(Derivative::new("Φ_t", Rows::Equations("Φ of "), Derived::Value, t..t + 1), hand)
    }

    /// Φ_b, M × P.
    pub fn phi_b<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let by_b = Self::PLACES.b();
        self.of_phi(Derivative::new("Φ_b", Rows::Equations("Φ of "), Derived::Value, by_b), hand)
    }

    /// (Φ_q v)_q, M × N, with v held.
    pub fn phi_q_v_q<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let by_q = Self::PLACES.q();
        let block = Derivative::new("(Φ_q v)_q", Rows::Equations("Φ_q v of "), Self::rate(false), by_q.clone());
        self.of_phi(block.not("Φ_q", Derived::Value, by_q.clone()).not("(dΦ/dt)_q", Self::rate(true), by_q), hand)
    }

    /// (dΦ/dt)_q = (Φ_q v)_q + Φ_tq, M × N, with v held; for constraints with time in them.
    pub fn phi_dot_q<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let (by_q, t) = (Self::PLACES.q(), Self::PLACES.t());
        let phi_t = Derived::Along { q: 0..0, v: 0..0, t: Some(t) };
        let block = Derivative::new("(dΦ/dt)_q", Rows::Equations("dΦ/dt of "), Self::rate(true), by_q.clone());
        let block = block.term("(Φ_q v)_q", Self::rate(false), by_q.clone()).term("Φ_tq", phi_t, by_q.clone());
        self.of_phi(block.not("Φ_q", Derived::Value, by_q), hand)
    }

    /// (dΦ/dt)_b, M × P.
    pub fn phi_dot_b<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let by_b = Self::PLACES.b();
        let block = Derivative::new("(dΦ/dt)_b", Rows::Equations("dΦ/dt of "), Self::rate(true), by_b.clone());
        self.of_phi(block.not("Φ_b", Derived::Value, by_b), hand)
    }

    /// (Φ_qᵀσ)_q, N × N, with σ held.
    pub fn phi_q_t_sigma_q<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let by_q = Self::PLACES.q();
        let block = Derivative::new("(Φ_qᵀσ)_q", Rows::Coordinates("Φ_qᵀσ of "), Self::reaction(), by_q.clone());
        self.of_phi(block.not("((dΦ/dt)_qᵀσ)_q", Self::rate_of_reaction(), by_q), hand)
    }

    /// (Φ_qᵀσ)_b, N × P, with σ held.
    pub fn phi_q_t_sigma_b<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let by_b = Self::PLACES.b();
        self.of_phi(Derivative::new("(Φ_qᵀσ)_b", Rows::Coordinates("Φ_qᵀσ of "), Self::reaction(), by_b), hand)
    }

    /// ((dΦ/dt)_qᵀσ)_q, N × N, with v and σ held: the constraint's part of 𝓛_qq.
    pub fn phi_dot_q_t_sigma_q<A: Matrix>(self, hand: impl Fn(&Point<N, M, 0, P>) -> A + 'a) -> Self {
        let by_q = Self::PLACES.q();
        let name = "((dΦ/dt)_qᵀσ)_q";
        let block = Derivative::new(name, Rows::Coordinates("(dΦ/dt)_qᵀσ of "), Self::rate_of_reaction(), by_q.clone());
        self.of_phi(block.not("(Φ_qᵀσ)_q", Self::reaction(), by_q), hand)
    }
}
