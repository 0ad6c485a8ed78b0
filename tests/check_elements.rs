//! Hand-derived blocks of elements: right ones pass, in any units; wrong ones are found and named.

use hamiltonian_adjoint::check::{self, Mistake};
use hamiltonian_adjoint::planar::Revolute;

fn phi_q(q: &nalgebra::SVector<f64, 6>, b: &nalgebra::SVector<f64, 4>) -> [[f64; 6]; 2] {
    let ([sa, ca], [sb, cb]) = ([q[2].sin(), q[2].cos()], [q[5].sin(), q[5].cos()]);
    [
        [-1.0, 0.0, sa * b[0] + ca * b[1], 1.0, 0.0, -sb * b[2] - cb * b[3]],
        [0.0, -1.0, -ca * b[0] + sa * b[1], 0.0, 1.0, cb * b[2] - sb * b[3]],
    ]
}

#[test]
fn a_wrong_sign_is_named() {
    let report = check::constraint(&Revolute, [0.5, 0.1, -0.4, 0.2])
        .coordinates(["x_a", "y_a", "φ_a", "x_b", "y_b", "φ_b"])
        .equations(["x", "y"])
        .phi_q(|at| phi_q(&at.q, &at.b))
        .phi_q_v_q(|at| {
            let mut m = phi_q(&at.q, &at.b);
            m[0][2] *= -1.0;
            m
        })
        .phi_q(|at| {
            let mut m = phi_q(&at.q, &at.b);
            m[0][2] *= -1.0;
            m
        })
        .run();
    println!("{report}");
    assert_eq!(report.blocks[2].diagnoses[0].mistake, Mistake::SignFlipped);
}
