//! A mass matrix that depends on q, and a cost that uses every part of y.

use hamiltonian_adjoint::check::{self, Mistake};

use super::{Case, PENDULUM, edit};
use crate::hand::*;

pub fn cases() -> Vec<Case> {
    let b = Four::from(PENDULUM);
    let pendulum = || {
        check::kinetic_energy(&DoublePendulum, PENDULUM).coordinates(["φ_1", "φ_2"]).constants(["m_1", "m_2", "l_1", "l_2"])
    };
    let cost = || check::cost(&Everything, [2.0, 0.3, 0.7, 1.9]);
    vec![
        (
            "½ forgotten",
            "double pendulum T_q",
            Mistake::Factor,
            pendulum().t_q(move |at| pendulum_t_q(&at.q, &at.v, &b) * 2.0).run(),
        ),
        (
            "transposed",
            "double pendulum (M v)_q",
            Mistake::Transposed,
            pendulum().mass_v_q(move |at| pendulum_mass_v_q(&at.q, &at.v, &b).transpose()).run(),
        ),
        (
            "m_2 left out of M_11",
            "double pendulum M",
            Mistake::TermMissing,
            pendulum().mass(move |at| edit(pendulum_mass(&at.q, &b), |m| m[(0, 0)] = b[0] * b[2] * b[2])).run(),
        ),
        (
            "sine for cosine",
            "double pendulum M",
            Mistake::OtherArgument,
            pendulum()
                .mass(move |at| {
                    edit(pendulum_mass(&at.q, &b), |m| {
                        let coupling = b[1] * b[2] * b[3] * (at.q[0] - at.q[1]).sin();
                        (m[(0, 1)], m[(1, 0)]) = (coupling, coupling);
                    })
                })
                .run(),
        ),
        (
            "symmetric instead of antisymmetric",
            "double pendulum T_qq",
            Mistake::SignFlipped,
            pendulum()
                .t_qq(move |at| edit(pendulum_t_qq(&at.q, &at.v, &b), |m| (m[(0, 1)], m[(1, 0)]) = (-m[(0, 1)], -m[(1, 0)])))
                .run(),
        ),
        (
            "wrong sign of V",
            "double pendulum V_q",
            Mistake::SignFlipped,
            check::potential_energy(&DoublePendulum, PENDULUM).v_q(move |at| -pendulum_v_q(&at.q, &b)).run(),
        ),
        (
            "weight forgotten",
            "cost h_u",
            Mistake::Factor,
            cost().constants(["w_q", "w_v", "w_u", "w_σ"]).h_u(|at| at.u[0]).run(),
        ),
        (
            "a product term left out",
            "cost h_q",
            Mistake::TermMissing,
            cost().h_q(|at| [2.0 * (at.q[0] + at.q[1]), 2.0 * at.q[0]]).run(),
        ),
        ("entries exchanged", "cost h_v", Mistake::Swapped, cost().h_v(|at| [0.3 * at.v[0], 0.3 * at.v[1]]).run()),
        ("p* and σ confused", "cost h_σ", Mistake::OtherArgument, cost().h_sigma(|at| 1.9 * at.sigma[0]).run()),
    ]
}
