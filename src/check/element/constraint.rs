//! Derivatives of a constraint Φ(q, t; b) and of its rate dΦ/dt = Φ_q v + Φ_t.

use super::super::formula::{Derived, Function};
use super::super::matrix::Matrix;
use super::super::point::{Part, Point};
use super::{Derivative, ElementCheck, Rows};
use crate::{Constraint, Scalar};

/// Φ as a function of all arguments in one list.
struct Phi<'a, E, const N: usize, const M: usize, const P: usize>(&'a E);

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

/// f_q v + f_t, and its two terms.
const RATE: Derived = Derived { rate: &[Part::Q, Part::T], gradient: None };
const BY_MOTION: Derived = Derived { rate: &[Part::Q], gradient: None };
const BY_TIME: Derived = Derived { rate: &[Part::T], gradient: None };
/// (σᵀ f)_q and (σᵀ (f_q v + f_t))_q.
const REACTION: Derived = Derived::gradient(Part::Q);
const RATE_OF_REACTION: Derived = Derived { gradient: Some(Part::Q), ..RATE };

const OF_PHI: Rows = Rows::Equations("Φ of ");
const OF_RATE: Rows = Rows::Equations("dΦ/dt of ");
const OF_REACTION: Rows = Rows::Coordinates("Φ_qᵀσ of ");
const OF_RATE_OF_REACTION: Rows = Rows::Coordinates("(dΦ/dt)_qᵀσ of ");

impl<'a, E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> ElementCheck<'a, E, N, M, 0, P> {
    blocks! { Phi, Point<N, M, 0, P>;
        /// Φ itself, M numbers.
        phi: Derivative::value("Φ", OF_PHI, Derived::VALUE);
        /// dΦ/dt = Φ_q v + Φ_t itself, M numbers.
        phi_dot: Derivative::value("dΦ/dt", OF_RATE, RATE);
        /// Φ_q, M × N.
        phi_q: Derivative::new("Φ_q", OF_PHI, Derived::VALUE, Part::Q);
        /// Φ_t, M numbers.
        phi_t: Derivative::new("Φ_t", OF_PHI, Derived::VALUE, Part::T);
        /// Φ_b, M × P.
        phi_b: Derivative::new("Φ_b", OF_PHI, Derived::VALUE, Part::B);
        /// (Φ_q v)_q, M × N, with v held.
        phi_q_v_q: Derivative::new("(Φ_q v)_q", Rows::Equations("Φ_q v of "), BY_MOTION, Part::Q)
            .not("Φ_q", Derived::VALUE, Part::Q)
            .not("(dΦ/dt)_q", RATE, Part::Q);
        /// (dΦ/dt)_q = (Φ_q v)_q + Φ_tq, M × N, with v held; for constraints with time in them.
        phi_dot_q: Derivative::new("(dΦ/dt)_q", OF_RATE, RATE, Part::Q)
            .terms(&[("(Φ_q v)_q", BY_MOTION, Part::Q), ("Φ_tq", BY_TIME, Part::Q)])
            .not("Φ_q", Derived::VALUE, Part::Q);
        /// (dΦ/dt)_b, M × P.
        phi_dot_b: Derivative::new("(dΦ/dt)_b", OF_RATE, RATE, Part::B).not("Φ_b", Derived::VALUE, Part::B);
        /// (Φ_qᵀσ)_q, N × N, with σ held.
        phi_q_t_sigma_q: Derivative::new("(Φ_qᵀσ)_q", OF_REACTION, REACTION, Part::Q)
            .not("((dΦ/dt)_qᵀσ)_q", RATE_OF_REACTION, Part::Q);
        /// (Φ_qᵀσ)_b, N × P, with σ held.
        phi_q_t_sigma_b: Derivative::new("(Φ_qᵀσ)_b", OF_REACTION, REACTION, Part::B);
        /// ((dΦ/dt)_qᵀσ)_q, N × N, with v and σ held: the constraint's part of 𝓛_qq.
        phi_dot_q_t_sigma_q: Derivative::new("((dΦ/dt)_qᵀσ)_q", OF_RATE_OF_REACTION, RATE_OF_REACTION, Part::Q)
            .not("(Φ_qᵀσ)_q", REACTION, Part::Q);
    }
}
