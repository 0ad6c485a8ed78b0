//! Blocks of Eq. (10).

use hamiltonian_adjoint::check::{self, Mistake};
use hamiltonian_adjoint::paper_system::Equation::{F3, F4, F5};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::paper_system::Variable::{Q, Sigma, V};
use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum, simulate};
use nalgebra::DMatrix;

use super::Case;

pub fn cases() -> Vec<Case> {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
    inputs.controls.fill(10.0);
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let f3_q = |gamma: f64, t: &check::Terms| &t.mass * gamma + &t.phi_q_t_sigma_q;
    let f4_q =
        |gamma: f64, t: &check::Terms| &t.force_q + &t.force_v * gamma + &t.phi_dot_q_t_sigma_q + &t.phi_q_t_sigma_q * gamma;
    let f4_v = |t: &check::Terms| -(&t.phi_q_t_sigma_q + &t.force_v);
    let step = || check::step(&paper);
    let dense = |m: DMatrix<f64>| m;
    vec![
        ("(Φ_qᵀσ)_q left out", "∂f3_i/∂q_i", Mistake::TermMissing, step().f_y(F3, Q, |at| at.terms().mass * at.gamma).run()),
        ("γ forgotten", "∂f3_i/∂q_(i−1)", Mistake::Factor, step().f_y_previous(F3, Q, |at| -at.terms().mass).run()),
        (
            "−Δt/2 for −γ",
            "∂f5_i/∂q_(i−1)",
            Mistake::Factor,
            step().f_y_previous(F5, Q, |at| at.terms().phi_q * (-0.5 * at.dt)).run(),
        ),
        (
            "Φ_q of node i − 1 for i",
            "∂f5_i/∂v_(i−1)",
            Mistake::OtherArgument,
            step().f_y_previous(F5, V, |at| -at.previous_terms().phi_q).run(),
        ),
        ("Φ_q for Φ_qᵀ", "∂f3_i/∂σ_i", Mistake::Transposed, step().f_y(F3, Sigma, |at| at.terms().phi_q).run()),
        (
            "γ Q_v left out",
            "∂f4_i/∂q_i",
            Mistake::TermMissing,
            step().f_y(F4, Q, |at| dense(f4_q(at.gamma, &at.terms()) - at.terms().force_v * at.gamma)).run(),
        ),
        (
            "sign of S",
            "∂f4_i/∂v_(i−1)",
            Mistake::TermWrong,
            step().f_y_previous(F4, V, |at| f4_v(&at.terms()) + at.terms().phi_q_t_sigma_q * 2.0).run(),
        ),
        (
            "Q_v twice",
            "∂f4_i/∂v_(i−1)",
            Mistake::TermWrong,
            step().f_y_previous(F4, V, |at| f4_v(&at.terms()) - at.terms().force_v).run(),
        ),
        (
            "error of 1e-6 of M",
            "∂f3_i/∂q_i",
            Mistake::FewDigits,
            step().f_y(F3, Q, |at| f3_q(at.gamma, &at.terms()) + at.terms().mass * (1e-6 * at.gamma)).run(),
        ),
        (
            "σ of node i − 1 for i",
            "∂f4_i/∂v_(i−1)",
            Mistake::OtherArgument,
            step()
                .f_y_previous(F4, V, |at| {
                    let mut state = at.y.clone();
                    state.sigma = at.previous.sigma.clone();
                    f4_v(&at.terms_at(&state))
                })
                .run(),
        ),
    ]
}
