//! Eq. (10) block by block: as printed in our copy, as corrected, and the true derivative.

use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::check::{self, Report, StepPoint, Terms};
use hamiltonian_adjoint::paper_system::{Equation, PaperSystem, Variable};
use nalgebra::DMatrix;

use super::Finding;
use super::mechanisms::{Moving, double_pendulum_force_q, double_pendulum_force_v};
use crate::table::Verdict;
use Equation::{F1, F2, F3, F4, F5};
use Variable::{PStar, PStarDot, Q, Sigma, V};

type Formula = fn(&StepPoint) -> DMatrix<f64>;

/// One block: its position, the printed formula and the correct formula.
struct Block {
    equation: Equation,
    variable: Variable,
    printed: &'static str,
    /// The printed formula; `None` if it is not a matrix of the block's size.
    value: Option<Formula>,
    correct: &'static str,
    correct_value: Formula,
}

/// A block that is right as printed.
const fn right((equation, variable): (Equation, Variable), printed: &'static str, value: Formula) -> Block {
    Block { equation, variable, printed, value: Some(value), correct: printed, correct_value: value }
}

/// A block that is misprinted.
const fn wrong(
    (equation, variable): (Equation, Variable),
    (printed, value): (&'static str, Option<Formula>),
    (correct, correct_value): (&'static str, Formula),
) -> Block {
    Block { equation, variable, printed, value, correct, correct_value }
}

const IDENTITY: Formula = |at| DMatrix::identity(at.y.q.len(), at.y.q.len());
const MINUS_IDENTITY: Formula = |at| -IDENTITY(at);
const GAMMA_IDENTITY: Formula = |at| IDENTITY(at) * at.gamma;
const MINUS_GAMMA_IDENTITY: Formula = |at| IDENTITY(at) * -at.gamma;
const PHI_Q_TRANSPOSED: Formula = |at| at.terms().phi_q.transpose();

/// γ M_i + (Φ_qᵀσ_i)_q.
fn mass_and_constraint_force(at: &StepPoint) -> DMatrix<f64> {
    let t = at.terms();
    t.mass * at.gamma + t.phi_q_t_sigma_q
}

/// [Φ̇_qᵀσ_i]_q with q̂ held.
fn constraint_force(at: &StepPoint, t: &Terms) -> DMatrix<f64> {
    &t.phi_dot_q_t_sigma_q + &t.phi_q_t_sigma_q * at.gamma
}

/// Q_q + γ Q_q̇. T_qq + γ T_qv is part of `force_q + γ force_v`; the paper's Q has no T_q. Only the double pendulum has one.
fn force_without_t_q(at: &StepPoint, t: &Terms) -> DMatrix<f64> {
    if at.y.q.len() == 2 { double_pendulum_force_q(&at.y.q, &at.y.v, at.gamma) } else { &t.force_q + &t.force_v * at.gamma }
}

/// S + Q_q̇^i, with S as meant.
fn s_and_previous_force_v(at: &StepPoint) -> DMatrix<f64> {
    let q = &at.previous.q;
    let force_v = if q.len() == 2 { double_pendulum_force_v(q) } else { at.previous_terms().force_v };
    at.terms().phi_q_t_sigma_q + force_v
}

/// S + (Q + T_q)_q̇^{i+1}.
fn s_and_force_v(at: &StepPoint) -> DMatrix<f64> {
    let t = at.terms();
    t.phi_q_t_sigma_q + t.force_v
}

/// ∂f_i/∂y_i.
const LEFT: [Block; 12] = [
    right((F1, V), "I", IDENTITY),
    right((F1, Q), "−γ I", MINUS_GAMMA_IDENTITY),
    right((F2, PStarDot), "I", IDENTITY),
    right((F2, PStar), "−γ I", MINUS_GAMMA_IDENTITY),
    wrong(
        (F3, Q),
        ("γ M_i + (Φ_qᵀσ_i)_q", Some(mass_and_constraint_force)),
        ("γ M_i + (M q̇_i)_q + (Φ_qᵀσ_i)_q", |at| mass_and_constraint_force(at) + at.terms().mass_v_q),
    ),
    right((F3, PStar), "−I", MINUS_IDENTITY),
    right((F3, Sigma), "Φ_qᵀ", PHI_Q_TRANSPOSED),
    wrong(
        (F4, Q),
        (
            "Q_q + γ Q_q̇ + [Φ̇_qᵀσ_i]_q, q̂ held",
            Some(|at| force_without_t_q(at, &at.terms()) + constraint_force(at, &at.terms())),
        ),
        ("(Q + T_q)_q + γ (Q + T_q)_q̇ + [Φ̇_qᵀσ_i]_q, q̂ held", |at| {
            let t = at.terms();
            &t.force_q + &t.force_v * at.gamma + constraint_force(at, &t)
        }),
    ),
    wrong((F4, PStar), ("−I (first of the two rows), −γ I (second)", Some(MINUS_IDENTITY)), ("−γ I", MINUS_GAMMA_IDENTITY)),
    wrong((F4, Sigma), ("Φ_qᵀ", Some(PHI_Q_TRANSPOSED)), ("Φ̇_qᵀ", |at| at.terms().phi_dot_q.transpose())),
    wrong(
        (F5, Q),
        ("[f_4^i]_q (n × n)", None),
        ("[f_5^i]_q = γ Φ_q + Φ̇_q", |at| {
            let t = at.terms();
            t.phi_q * at.gamma + t.phi_dot_q
        }),
    ),
    right((F5, Sigma), "0", |at| {
        let m = at.terms().phi_q.nrows();
        DMatrix::zeros(m, m)
    }),
];

/// ∂f_{i+1}/∂y_i; the functions are evaluated at node i + 1, `previous` is node i.
const RIGHT: [Block; 12] = [
    right((F1, V), "I", IDENTITY),
    right((F1, Q), "γ I", GAMMA_IDENTITY),
    right((F2, PStarDot), "I", IDENTITY),
    right((F2, PStar), "γ I", GAMMA_IDENTITY),
    wrong((F3, V), ("−M_i", Some(|at| -at.previous_terms().mass)), ("−M_{i+1}", |at| -at.terms().mass)),
    wrong(
        (F3, Q),
        ("−γ M_i", Some(|at| at.previous_terms().mass * -at.gamma)),
        ("−γ M_{i+1}", |at| at.terms().mass * -at.gamma),
    ),
    wrong(
        (F4, V),
        ("−S − Q_q̇^i, with S as meant", Some(|at| -s_and_previous_force_v(at))),
        ("−S − (Q + T_q)_q̇^{i+1}", |at| -s_and_force_v(at)),
    ),
    right((F4, PStarDot), "I", IDENTITY),
    wrong(
        (F4, Q),
        ("−γ (S + Q_q̇^i), with S as meant", Some(|at| s_and_previous_force_v(at) * -at.gamma)),
        ("−γ (S + (Q + T_q)_q̇^{i+1})", |at| s_and_force_v(at) * -at.gamma),
    ),
    wrong((F4, PStar), ("0", Some(|at| IDENTITY(at) * 0.0)), ("γ I", GAMMA_IDENTITY)),
    wrong((F5, V), ("−Φ_q at i", Some(|at| -at.previous_terms().phi_q)), ("−Φ_q at i + 1", |at| -at.terms().phi_q)),
    wrong(
        (F5, Q),
        ("−γ Φ_q at i", Some(|at| at.previous_terms().phi_q * -at.gamma)),
        ("−γ Φ_q at i + 1", |at| at.terms().phi_q * -at.gamma),
    ),
];

fn side(right: bool) -> &'static str {
    if right { "right" } else { "left" }
}

impl Block {
    /// The difference between both formulas, if the diagnosis of the check does not explain it completely.
    fn note(&self, right: bool) -> &'static str {
        match (self.equation, self.variable, right) {
            (F4, Q, false) => "T_qq + γ T_qq̇ is missing, because (1b) lacks T_q",
            (F4, V | Q, true) => "Q_q̇ of node i for i + 1; with variable M, T_qq̇ is missing too",
            _ => "",
        }
    }

    fn check(&self, right: bool, on: &Moving, value: Formula) -> Result<Report, Error> {
        let paper = PaperSystem::new(&on.system, &on.inputs, &on.motion)?;
        let step = check::step(&paper);
        Ok(match right {
            true => step.f_y_previous(self.equation, self.variable, value).run(),
            false => step.f_y(self.equation, self.variable, value).run(),
        })
    }

    fn finding(&self, right: bool, mechanisms: &[&Moving; 2]) -> Result<Finding, Error> {
        let run = |value: Formula| -> Result<[Report; 2], Error> {
            Ok([self.check(right, mechanisms[0], value)?, self.check(right, mechanisms[1], value)?])
        };
        let corrected = run(self.correct_value)?;
        let printed = self.value.map(run).transpose()?;
        let passes = |report: &Report| report.verdict() == check::Verdict::Right;
        let status = match &printed {
            Some([a, b]) if passes(a) && passes(b) => Verdict::Holds,
            Some([a, _]) if passes(a) => Verdict::HoldsForConstantMass,
            _ => Verdict::Misprinted,
        };
        let error = |report: &Report| report.blocks[0].relative_error;
        let says = |reports: &[Report; 2]| {
            let wrong = reports.iter().find(|report| !passes(report))?;
            Some(wrong.blocks[0].diagnoses.iter().map(|d| d.text.clone()).collect::<Vec<_>>().join("; "))
        };
        let words = match &printed {
            Some(reports) => says(reports).unwrap_or_default(),
            None => "no matrix of this size is defined under that name".into(),
        };
        let note = self.note(right);
        let words = if note.is_empty() || words.is_empty() { words } else { note.to_string() };
        let corrected_error = |report: &Report| if passes(report) { error(report) } else { f64::INFINITY };
        let as_printed = printed.map_or([f64::NAN; 2], |both| both.each_ref().map(error));
        let errors = [as_printed, corrected.each_ref().map(corrected_error)];
        let place = format!("(10) {}: {} by {}", side(right), self.equation.name(), self.variable.name());
        Ok(Finding::new(&place, status, self.printed, self.correct, errors, &words))
    }
}

/// Findings for every block of both matrices of Eq. (10), including the blocks that must be zero.
pub fn findings(mechanisms: &[&Moving; 2]) -> Result<Vec<Finding>, Error> {
    let mut findings = Vec::new();
    for (right, listed) in [(false, &LEFT), (true, &RIGHT)] {
        for printed in listed {
            findings.push(printed.finding(right, mechanisms)?);
        }
        findings.push(zeros(mechanisms, right, listed)?);
    }
    Ok(findings)
}

/// The blocks printed as 0.
fn zeros(mechanisms: &[&Moving; 2], right: bool, listed: &[Block; 12]) -> Result<Finding, Error> {
    let mut worst = [0.0f64; 2];
    let mut count = 0;
    for (worst, on) in worst.iter_mut().zip(mechanisms) {
        let paper = PaperSystem::new(&on.system, &on.inputs, &on.motion)?;
        let tangent = if right { paper.f_y_previous(20) } else { paper.f_y(20) };
        count = 0;
        for row in Equation::ALL {
            for column in Variable::ALL.into_iter().filter(|&c| !listed.iter().any(|p| p.equation == row && p.variable == c))
            {
                *worst = worst.max(tangent.block(row, column).amax());
                count += 1;
            }
        }
    }
    let status = if worst == [0.0; 2] { Verdict::Holds } else { Verdict::Misprinted };
    let place = format!("(10) {}: the other {count} blocks", side(right));
    Ok(Finding::new(&place, status, "0", "", [worst; 2], ""))
}
