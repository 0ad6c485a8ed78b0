//! Hinges, rods, and a moving profile.

use hamiltonian_adjoint::check::{self, Mistake};
use hamiltonian_adjoint::planar::{Distance, Revolute};

use super::{ARMS, Case, NAMES, ROD, edit};
use crate::hand::*;

pub fn cases() -> Vec<Case> {
    let hinge = || check::constraint(&Revolute, ARMS).coordinates(NAMES).equations(["x", "y"]);
    let rod = || check::constraint(&Distance, ROD).coordinates(NAMES);
    vec![
        (
            "sign of one entry",
            "hinge Φ_q",
            Mistake::SignFlipped,
            hinge().phi_q(|at| edit(hinge_q(&at.q, &ARMS), |m| m[(0, 2)] *= -1.0)).run(),
        ),
        (
            "sign of the block",
            "hinge (Φ_q v)_q",
            Mistake::SignFlipped,
            hinge().phi_q_v_q(|at| -hinge_q_v_q(&at.q, &at.v, &ARMS)).run(),
        ),
        (
            "rows exchanged",
            "hinge Φ_q",
            Mistake::Swapped,
            hinge().phi_q(|at| edit(hinge_q(&at.q, &ARMS), |m| m.swap_rows(0, 1))).run(),
        ),
        (
            "angles' columns exchanged",
            "hinge Φ_q",
            Mistake::Swapped,
            hinge().phi_q(|at| edit(hinge_q(&at.q, &ARMS), |m| m.swap_columns(2, 5))).run(),
        ),
        (
            "dropped term in one entry (s_ay)",
            "hinge Φ_q",
            Mistake::TermMissing,
            hinge().phi_q(|at| edit(hinge_q(&at.q, &ARMS), |m| m[(0, 2)] -= at.q[2].cos() * ARMS[1])).run(),
        ),
        (
            "φ_a for φ_b in one column",
            "hinge Φ_q",
            Mistake::OtherArgument,
            hinge()
                .phi_q(|at| {
                    edit(hinge_q(&at.q, &ARMS), |m| {
                        let mut q = at.q;
                        q[5] = q[2];
                        m.set_column(5, &hinge_q(&q, &ARMS).column(5));
                    })
                })
                .run(),
        ),
        (
            "sine for cosine in one entry",
            "hinge (Φ_qᵀσ)_q",
            Mistake::OtherArgument,
            hinge()
                .phi_q_t_sigma_q(|at| {
                    edit(hinge_t_sigma_q(&at.q, &at.sigma, &ARMS), |m| {
                        let mut q = at.q;
                        q[2] += std::f64::consts::FRAC_PI_2;
                        m[(2, 2)] = hinge_t_sigma_q(&q, &at.sigma, &ARMS)[(2, 2)];
                    })
                })
                .run(),
        ),
        (
            "σ_y left out",
            "hinge (Φ_qᵀσ)_q",
            Mistake::TermMissing,
            hinge()
                .phi_q_t_sigma_q(|at| {
                    let mut sigma = at.sigma;
                    sigma[1] = 0.0;
                    hinge_t_sigma_q(&at.q, &sigma, &ARMS)
                })
                .run(),
        ),
        (
            "one diagonal entry zero",
            "hinge (Φ_qᵀσ)_q",
            Mistake::Zero,
            hinge().phi_q_t_sigma_q(|at| edit(hinge_t_sigma_q(&at.q, &at.sigma, &ARMS), |m| m[(5, 5)] = 0.0)).run(),
        ),
        (
            "(Φ_qᵀσ)_q for ((dΦ/dt)_qᵀσ)_q",
            "hinge",
            Mistake::OtherBlock,
            hinge().phi_dot_q_t_sigma_q(|at| hinge_t_sigma_q(&at.q, &at.sigma, &ARMS)).run(),
        ),
        ("transposed 2×6", "hinge Φ_q", Mistake::Transposed, hinge().phi_q(|at| hinge_q(&at.q, &ARMS).transpose()).run()),
        (
            "error of 1e-6 in one entry",
            "hinge Φ_q",
            Mistake::FewDigits,
            hinge().phi_q(|at| edit(hinge_q(&at.q, &ARMS), |m| m[(1, 5)] *= 1.0 + 1e-6)).run(),
        ),
        (
            "an entry that should be zero",
            "hinge Φ_q",
            Mistake::NotZero,
            hinge().phi_q(|at| edit(hinge_q(&at.q, &ARMS), |m| m[(0, 1)] = -1.0)).run(),
        ),
        ("factor ½ forgotten", "rod Φ_q", Mistake::Factor, rod().phi_q(|at| rod_q(&at.q, &ROD) * 2.0).run()),
        ("1/l forgotten", "rod Φ_q", Mistake::Factor, rod().phi_q(|at| rod_q(&at.q, &ROD) * ROD[4]).run()),
        (
            "Jᵀ(d) held constant: a product rule without its second term",
            "rod (Φ_q v)_q",
            Mistake::TermMissing,
            rod()
                .phi_q_v_q(|at| {
                    let j = hinge_q(&at.q, &ROD);
                    (j * at.v).transpose() * j / ROD[4]
                })
                .run(),
        ),
        (
            "Φ_tq left out",
            "cam (dΦ/dt)_q",
            Mistake::TermMissing,
            check::constraint(&Cam, [1.7]).phi_dot_q(|at| [[at.v[0], at.v[1]]]).run(),
        ),
        (
            "(Φ_q v)_q left out",
            "cam (dΦ/dt)_q",
            Mistake::TermMissing,
            check::constraint(&Cam, [1.7]).phi_dot_q(|at| [[1.7 * (1.7 * at.t).cos(), 0.0]]).run(),
        ),
        (
            "ω forgotten",
            "cam Φ_t",
            Mistake::Factor,
            check::constraint(&Cam, [1.7]).constants(["ω"]).phi_t(|at| at.q[0] * (1.7 * at.t).cos()).run(),
        ),
    ]
}
