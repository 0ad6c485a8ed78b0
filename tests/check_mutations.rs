//! Thirty-odd mistakes, one each in right hand-derived blocks: every one must be caught, and most called by their name.

mod hand;

use hamiltonian_adjoint::check::{self, Mistake, Report};
use hamiltonian_adjoint::paper_system::Equation::{F3, F4, F5};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::paper_system::Variable::{Q, Sigma, V};
use hamiltonian_adjoint::planar::{Actuator, Damper, Distance, LinearSpring, Revolute, SlidingFriction};
use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum, simulate};
use hand::*;
use nalgebra::DMatrix;

const ARMS: [f64; 4] = [0.5, 0.1, -0.4, 0.2];
const ROD: [f64; 5] = [0.5, 0.1, -0.4, 0.2, 1.3];
const DAMPER: [f64; 5] = [0.5, 0.1, -0.4, 0.2, 3.0];
const SPRING: [f64; 6] = [0.5, 0.1, -0.4, 0.2, 40.0, 0.3];
const PENDULUM: [f64; 4] = [0.8, 0.4, 1.1, 0.9];
const NAMES: [&str; 6] = ["cart.x", "cart.y", "cart.φ", "link 1.x", "link 1.y", "link 1.φ"];

/// What was done, where, what it should be called, and the report.
type Case = (&'static str, &'static str, Mistake, Report);

fn joints() -> Vec<Case> {
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
            Mistake::Unexplained,
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

fn forces() -> Vec<Case> {
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
            Mistake::Unexplained,
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
            Mistake::Unexplained,
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

fn energies_and_costs() -> Vec<Case> {
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

fn steps() -> Vec<Case> {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
    inputs.controls.fill(10.0);
    let motion = simulate(&system, &inputs, &Settings::default()).expect("motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let f3_q = |gamma: f64, t: &check::Terms| &t.mass * gamma + &t.phi_q_t_sigma_q;
    let f4_q =
        |gamma: f64, t: &check::Terms| &t.force_q + &t.force_v * gamma + &t.phi_dot_q_t_sigma_q + &t.phi_q_t_sigma_q * gamma;
    let f4_v = |t: &check::Terms| -(&t.phi_q_t_sigma_q + &t.force_v);
    let step = || check::step(&paper);
    let dense = |m: DMatrix<f64>| m;
    vec![
        (
            "(Φ_qᵀσ)_q left out",
            "[f_y^i] f3 by q",
            Mistake::TermMissing,
            step().f_y(F3, Q, |at| at.terms().mass * at.gamma).run(),
        ),
        ("γ forgotten", "[f_y^(i+1)] f3 by q", Mistake::Factor, step().f_y_previous(F3, Q, |at| -at.terms().mass).run()),
        (
            "−Δt/2 for −γ",
            "[f_y^(i+1)] f5 by q",
            Mistake::Factor,
            step().f_y_previous(F5, Q, |at| at.terms().phi_q * (-0.5 * at.dt)).run(),
        ),
        (
            "Φ_q of node i for i + 1",
            "[f_y^(i+1)] f5 by v",
            Mistake::OtherArgument,
            step().f_y_previous(F5, V, |at| -at.previous_terms().phi_q).run(),
        ),
        ("Φ_q for Φ_qᵀ", "[f_y^i] f3 by σ", Mistake::Transposed, step().f_y(F3, Sigma, |at| at.terms().phi_q).run()),
        (
            "γ Q_v left out",
            "[f_y^i] f4 by q",
            Mistake::TermMissing,
            step().f_y(F4, Q, |at| dense(f4_q(at.gamma, &at.terms()) - at.terms().force_v * at.gamma)).run(),
        ),
        (
            "sign of S",
            "[f_y^(i+1)] f4 by v",
            Mistake::TermWrong,
            step().f_y_previous(F4, V, |at| f4_v(&at.terms()) + at.terms().phi_q_t_sigma_q * 2.0).run(),
        ),
        (
            "Q_v twice",
            "[f_y^(i+1)] f4 by v",
            Mistake::TermWrong,
            step().f_y_previous(F4, V, |at| f4_v(&at.terms()) - at.terms().force_v).run(),
        ),
        (
            "error of 1e-6 of M",
            "[f_y^i] f3 by q",
            Mistake::FewDigits,
            step().f_y(F3, Q, |at| f3_q(at.gamma, &at.terms()) + at.terms().mass * (1e-6 * at.gamma)).run(),
        ),
        (
            "σ of node i for i + 1",
            "[f_y^(i+1)] f4 by v",
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

fn edit<T>(mut value: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut value);
    value
}

#[test]
fn every_mistake_is_caught_and_most_are_named() {
    let cases: Vec<Case> = [joints(), forces(), energies_and_costs(), steps()].into_iter().flatten().collect();
    let mut named = 0;
    println!("| # | block | mistake made | caught | diagnosis |\n|---|---|---|---|---|");
    for (i, (mistake, place, expected, report)) in cases.iter().enumerate() {
        let diagnoses = &report.blocks[0].diagnoses;
        let right = diagnoses.len() == 1 && diagnoses[0].mistake == *expected && *expected != Mistake::Unexplained;
        named += usize::from(right);
        let texts: Vec<&str> = diagnoses.iter().map(|d| d.text.as_str()).collect();
        let (caught, mark) = (if report.passed() { "NO" } else { "yes" }, if right { "" } else { " (not named)" });
        println!("| {} | {place} | {mistake} | {caught} | {}{mark} |", i + 1, texts.join("; "));
        for note in report.blocks[0].notes.iter() {
            println!("       note: {note}");
        }
    }
    let caught = cases.iter().filter(|(.., report)| report.verdict() == check::Verdict::Wrong).count();
    println!("{} mistakes, {caught} caught, {named} named right", cases.len());
    assert_eq!(caught, cases.len());
    assert!(named * 25 >= cases.len() * 22, "{named} of {} named", cases.len());
}
