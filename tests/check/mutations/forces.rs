//! Dampers, springs, actuators.

use hamiltonian_adjoint::check::{self, Mistake};
use hamiltonian_adjoint::planar::{Actuator, Damper, LinearSpring, SlidingFriction};

use super::{Case, DAMPER, NAMES, SPRING, edit};
use crate::hand::*;

pub fn cases() -> Vec<Case> {
    let damper = || check::force(&Damper, DAMPER).coordinates(NAMES);
    let spring = || check::potential_energy(&LinearSpring, SPRING).coordinates(NAMES);
    vec![
        ("sign of the block", "damper Q_v", Mistake::SignFlipped, damper().q_v(|at| -damper_v(&at.q, &DAMPER)).run()),
        (
            "coefficient forgotten",
            "damper Q_v",
            Mistake::Factor,
            damper().q_v(|at| damper_v(&at.q, &DAMPER) / DAMPER[4]).run(),
        ),
        (
            "transposed",
            "damper Q_q",
            Mistake::Transposed,
            damper().q_q(|at| damper_q(&at.q, &at.v, &DAMPER).transpose()).run(),
        ),
        (
            "one row zero",
            "damper Q_q",
            Mistake::Zero,
            damper().q_q(|at| edit(damper_q(&at.q, &at.v, &DAMPER), |m| m.row_mut(4).fill(0.0))).run(),
        ),
        (
            "only the first of two terms",
            "damper Q_q",
            Mistake::TermMissing,
            damper()
                .q_q(|at| {
                    let (g, gq) = (distance_q(&at.q, &DAMPER), distance_qq(&at.q, &DAMPER));
                    g * (at.v.transpose() * gq) * -DAMPER[4]
                })
                .run(),
        ),
        (
            "action without reaction",
            "actuator Q_u",
            Mistake::Zero,
            check::force(&Actuator, [0.1, 0.0, 0.2, 0.0, 0.3])
                .q_u(|at| {
                    let (s, c) = (at.q[2] + 0.3).sin_cos();
                    let q = at.q;
                    let b = [0.1, 0.0, 0.2, 0.0];
                    let mut gradient = hinge_q(&q, &b).transpose() * nalgebra::Vector2::new(c, s);
                    gradient[2] += nalgebra::Vector2::new(-s, c).dot(&between(&q, &b));
                    gradient.rows_mut(0, 3).fill(0.0);
                    gradient
                })
                .run(),
        ),
        (
            "free length left out",
            "spring V_q",
            Mistake::TermMissing,
            spring().v_q(|at| spring_q(&at.q, &edit(SPRING, |b| b[5] = 0.0))).run(),
        ),
        (
            "geometric stiffness left out",
            "spring V_qq",
            Mistake::TermMissing,
            spring()
                .v_qq(|at| {
                    let g = distance_q(&at.q, &SPRING);
                    g * g.transpose() * SPRING[4]
                })
                .run(),
        ),
        (
            "error of 1e-6 in all",
            "spring V_qq",
            Mistake::FewDigits,
            spring().v_qq(|at| spring_qq(&at.q, &SPRING) * (1.0 + 1e-6)).run(),
        ),
        (
            "sign of v_a",
            "sliding friction Q_v",
            Mistake::SignFlipped,
            check::force(&SlidingFriction, [0.0, 0.0, 0.0, 0.0, 0.0, 0.5])
                .q_v(|at| {
                    let (s, c) = at.q[2].sin_cos();
                    let mut gradient = Six::from([-c, -s, 0.0, c, s, 0.0]);
                    gradient[2] = nalgebra::Vector2::new(-s, c).dot(&between(&at.q, &[0.0; 4]));
                    edit(gradient * gradient.transpose() * -0.5, |m| m.column_mut(0).neg_mut())
                })
                .run(),
        ),
    ]
}
