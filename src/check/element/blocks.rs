//! Tables of derivatives: the function of each kind of element, and the blocks derived from it.

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::{Part, Places, Point};
use super::{Derivative, ElementCheck, Rows};
use crate::model::element::{CostPoint, ForcePoint};
use crate::{Constraint, Cost, Force, KineticEnergy, PotentialEnergy, Scalar};

/// Defines a method for each block of an element's function: its name, and the derivative.
macro_rules! blocks {
    ($function:ident, $point:ty; $($(#[$doc:meta])* $method:ident: $derivative:expr;)*) => {
        $($(#[$doc])*
        pub fn $method<A: Matrix>(self, hand: impl Fn(&$point) -> A + 'a) -> Self {
            let function = $function(self.element);
            self.block(function, $derivative, hand)
        })*
    };
}

/// Φ, T, V, Q and h as functions of all arguments in one list.
struct Phi<'a, E, const N: usize, const M: usize, const P: usize>(&'a E);
struct Kinetic<'a, E, const N: usize, const P: usize>(&'a E);
struct Potential<'a, E, const N: usize, const P: usize>(&'a E);
struct Applied<'a, E, const N: usize, const K: usize, const P: usize>(&'a E);
struct Value<'a, E, const N: usize, const M: usize, const K: usize, const P: usize>(&'a E);

impl<E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> Function for Phi<'_, E, N, M, P> {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let at = Point::<N, M, 0, P, S>::from_list(x);
        self.0.phi(&at.q, &at.b, at.t).iter().copied().collect()
    }
}

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

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> Function for Applied<'_, E, N, K, P> {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let at = Point::<N, 0, K, P, S>::from_list(x);
        let point = ForcePoint { q: at.q, v: at.v, u: at.u, t: at.t };
        self.0.force(&point, &at.b).iter().copied().collect()
    }
}

impl<E, const N: usize, const M: usize, const K: usize, const P: usize> Function for Value<'_, E, N, M, K, P>
where
    E: Cost<N, M, K, P>,
{
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let Point { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, t, b } = Point::from_list(x);
        vec![self.0.cost(&CostPoint { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, t }, &b)]
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

/// Checks hand-derived derivatives of a generalized force with the physical constants `b`.
pub fn force<E, const N: usize, const K: usize, const P: usize>(element: &E, b: [f64; P]) -> ElementCheck<'_, E, N, 0, K, P>
where
    E: Force<N, K, P>,
{
    ElementCheck::new(element, "force", b)
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

/// f itself; f_q or (σᵀ f)_q; and T_v = M v.
const VALUE: Derived = Derived { rate: &[], gradient: None };
const GRADIENT: Derived = Derived { gradient: Some(Part::Q), ..VALUE };
const MOMENTUM: Derived = Derived { gradient: Some(Part::V), ..VALUE };
/// f_q v + f_t, its two terms, and (σᵀ (f_q v + f_t))_q.
const RATE: Derived = Derived { rate: &[Part::Q, Part::T], gradient: None };
const BY_MOTION: Derived = Derived { rate: &[Part::Q], gradient: None };
const BY_TIME: Derived = Derived { rate: &[Part::T], gradient: None };
const GRADIENT_OF_RATE: Derived = Derived { gradient: Some(Part::Q), ..RATE };

const OF_PHI: Rows = Rows::Equations("Φ of ");
const OF_RATE: Rows = Rows::Equations("dΦ/dt of ");
const OF_REACTION: Rows = Rows::Coordinates("Φ_qᵀσ of ");
const OF_RATE_OF_REACTION: Rows = Rows::Coordinates("(dΦ/dt)_qᵀσ of ");
const OF_T: Rows = Rows::One("T");
const OF_T_V: Rows = Rows::Coordinates("T_v of ");
const OF_V: Rows = Rows::One("V");
const OF_V_Q: Rows = Rows::Coordinates("V_q of ");
const OF_Q: Rows = Rows::Coordinates("Q of ");

impl<'a, E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> ElementCheck<'a, E, N, M, 0, P> {
    blocks! { Phi, Point<N, M, 0, P>;
        /// Φ itself, M numbers.
        phi: Derivative::value("Φ", OF_PHI, VALUE);
        /// dΦ/dt = Φ_q v + Φ_t itself, M numbers.
        phi_dot: Derivative::value("dΦ/dt", OF_RATE, RATE);
        /// Φ_q, M × N.
        phi_q: Derivative::new("Φ_q", OF_PHI, VALUE, Part::Q);
        /// Φ_t, M numbers.
        phi_t: Derivative::new("Φ_t", OF_PHI, VALUE, Part::T);
        /// Φ_b, M × P.
        phi_b: Derivative::new("Φ_b", OF_PHI, VALUE, Part::B);
        /// (Φ_q v)_q, M × N, for constant v.
        phi_q_v_q: Derivative::new("(Φ_q v)_q", Rows::Equations("Φ_q v of "), BY_MOTION, Part::Q)
            .not("Φ_q", VALUE, Part::Q)
            .not("(dΦ/dt)_q", RATE, Part::Q);
        /// (dΦ/dt)_q = (Φ_q v)_q + Φ_tq, M × N, for constant v; for constraints that depend on time.
        phi_dot_q: Derivative::new("(dΦ/dt)_q", OF_RATE, RATE, Part::Q)
            .terms(&[("(Φ_q v)_q", BY_MOTION, Part::Q), ("Φ_tq", BY_TIME, Part::Q)])
            .not("Φ_q", VALUE, Part::Q);
        /// (dΦ/dt)_b, M × P.
        phi_dot_b: Derivative::new("(dΦ/dt)_b", OF_RATE, RATE, Part::B).not("Φ_b", VALUE, Part::B);
        /// (Φ_qᵀσ)_q, N × N, for constant σ.
        phi_q_t_sigma_q: Derivative::new("(Φ_qᵀσ)_q", OF_REACTION, GRADIENT, Part::Q)
            .not("((dΦ/dt)_qᵀσ)_q", GRADIENT_OF_RATE, Part::Q);
        /// (Φ_qᵀσ)_b, N × P, for constant σ.
        phi_q_t_sigma_b: Derivative::new("(Φ_qᵀσ)_b", OF_REACTION, GRADIENT, Part::B);
        /// ((dΦ/dt)_qᵀσ)_q, N × N, for constant v and σ: the constraint's contribution to 𝓛_qq.
        phi_dot_q_t_sigma_q: Derivative::new("((dΦ/dt)_qᵀσ)_q", OF_RATE_OF_REACTION, GRADIENT_OF_RATE, Part::Q)
            .not("(Φ_qᵀσ)_q", GRADIENT, Part::Q);
    }
}

impl<'a, E: KineticEnergy<N, P>, const N: usize, const P: usize> ElementCheck<'a, E, N, 0, 0, P> {
    blocks! { Kinetic, Point<N, 0, 0, P>;
        /// T itself.
        t: Derivative::value("T", OF_T, VALUE);
        /// M = T_vv, N × N.
        mass: Derivative::new("M", OF_T_V, MOMENTUM, Part::V).not("(M v)_q", MOMENTUM, Part::Q);
        /// p = T_v = M v, N numbers.
        t_v: Derivative::new("T_v", OF_T, VALUE, Part::V).not("T_q", VALUE, Part::Q);
        /// T_q = ½ (vᵀ M v)_q, N numbers.
        t_q: Derivative::new("T_q", OF_T, VALUE, Part::Q).not("T_v", VALUE, Part::V);
        /// (M v)_q = T_vq, N × N, for constant v.
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
        v: Derivative::value("V", OF_V, VALUE);
        /// V_q, N numbers; the force is −V_q.
        v_q: Derivative::new("V_q", OF_V, VALUE, Part::Q);
        /// V_qq, N × N.
        v_qq: Derivative::new("V_qq", OF_V_Q, GRADIENT, Part::Q);
        /// V_qb, N × P.
        v_qb: Derivative::new("V_qb", OF_V_Q, GRADIENT, Part::B);
    }
}

impl<'a, E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, 0, K, P> {
    blocks! { Applied, Point<N, 0, K, P>;
        /// Q itself, N numbers.
        q: Derivative::value("Q", OF_Q, VALUE);
        /// Q_q, N × N.
        q_q: Derivative::new("Q_q", OF_Q, VALUE, Part::Q).not("Q_v", VALUE, Part::V);
        /// Q_v, N × N.
        q_v: Derivative::new("Q_v", OF_Q, VALUE, Part::V).not("Q_q", VALUE, Part::Q);
        /// Q_u, N × K.
        q_u: Derivative::new("Q_u", OF_Q, VALUE, Part::U);
        /// Q_t, N numbers.
        q_t: Derivative::new("Q_t", OF_Q, VALUE, Part::T);
        /// Q_b, N × P.
        q_b: Derivative::new("Q_b", OF_Q, VALUE, Part::B);
    }
}

/// h differentiated with respect to one kind of argument; the alternatives are other kinds of the same length.
fn by(places: Places, name: &'static str, by: Part) -> Derivative {
    let states = [("h_q", Part::Q), ("h_v", Part::V), ("h_p*", Part::PStar), ("h_ṗ*", Part::PStarDot), ("h_v̇", Part::VDot)];
    let alike = |part: Part| part != by && places.of(part).len() == places.of(by).len();
    let others = states.into_iter().filter(|&(_, part)| alike(part));
    let block = Derivative::new(name, Rows::One("h"), VALUE, by);
    others.fold(block, |block, (name, part)| block.not(name, VALUE, part))
}

impl<'a, E, const N: usize, const M: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, M, K, P>
where
    E: Cost<N, M, K, P>,
{
    blocks! { Value, Point<N, M, K, P>;
        /// h itself.
        h: Derivative::value("h", Rows::One("h"), VALUE);
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
