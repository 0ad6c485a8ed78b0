//! The equations around Eq. (10): motion (1)–(4), variation (7)–(8), gradient (11)–(12).

use hamiltonian_adjoint::check::{self, Input, complex_step, direct_differentiation};
use hamiltonian_adjoint::paper_system::{Equation, PaperSystem, Variable};
use hamiltonian_adjoint::{Error, Settings};
use nalgebra::{DMatrix, DVector};

use super::mechanisms::{Moving, free_fall};
use super::{Finding, relative};
use crate::statistics::largest;
use crate::table::Verdict;

fn finding(place: &str, printed: &str, corrected: &str, errors: [[f64; 2]; 2], words: &str) -> Finding {
    let fails = |x: &f64| *x > 1e-6;
    let status = if errors[0].iter().any(fails) { Verdict::Misprinted } else { Verdict::Holds };
    Finding::new(place, status, printed, corrected, errors, words)
}

/// A misprint in a sentence or an index, which cannot be evaluated.
fn slip(place: &str, printed: &str, corrected: &str, words: &str) -> Finding {
    Finding::new(place, Verdict::Misprinted, printed, corrected, [[f64::NAN; 2]; 2], words)
}

/// Eq. (1)–(4).
pub fn of_motion(mechanisms: &[&Moving; 2]) -> Result<Vec<Finding>, Error> {
    let [with, without, reference] = free_fall()?;
    let apart = |a: [f64; 2]| largest([a[0] - reference[0], a[1] - reference[1]]);
    let mut t_q = finding(
        "(1b)",
        "ṗ* = Q + Φ̇_qᵀσ",
        "ṗ* = Q + T_q + Φ̇_qᵀσ",
        [[f64::NAN, apart(without)], [f64::NAN, apart(with)]],
        "without T_q = ½ (q̇ᵀ M q̇)_q, the angles of a free double pendulum after 1 s differ from those computed in point-mass coordinates (rad)",
    );
    t_q.status = Verdict::HoldsForConstantMass;
    let trapezoidal = |sign: f64| mechanisms.map(|on| rule_error(on, sign));
    Ok(vec![
        t_q,
        finding(
            "(2) q",
            "q̇_i − γ q_i + q̂_{i−1} = 0",
            "q̇_i − γ q_i − q̂_{i−1} = 0",
            [trapezoidal(1.0), trapezoidal(-1.0)].map(|e| e.map(|e| e[0])),
            "residual along a motion, relative to its terms; (3) uses q̇_i = γ q_i + q̂_{i−1}, which is right",
        ),
        finding(
            "(2) p*",
            "ṗ*_i − γ p*_i + p̂*_{i−1} = 0",
            "ṗ*_i − γ p*_i − p̂*_{i−1} = 0",
            [trapezoidal(1.0), trapezoidal(-1.0)].map(|e| e.map(|e| e[1])),
            "",
        ),
        substituted(mechanisms)?,
        slip("(4), sentence below", "y^{j+1} = y^j = Δy", "y^{j+1} = y^j + Δy", ""),
        slip("section 4, descent", "u_{i+1} = −α ∇J(u_i)", "u_{i+1} = u_i − α ∇J(u_i)", ""),
    ])
}

/// The residuals of (2) for q and p* with ± q̂, relative to the largest term.
fn rule_error(on: &Moving, sign: f64) -> [f64; 2] {
    let gamma = 2.0 / on.inputs.grid.steps[0];
    let error = |x: &DMatrix<f64>, rate: &DMatrix<f64>| {
        let at = |i: usize| {
            let hat = -gamma * x.column(i - 1) - rate.column(i - 1);
            rate.column(i) - gamma * x.column(i) + sign * hat
        };
        relative(largest((1..x.ncols()).map(|i| at(i).amax())), gamma * x.amax())
    };
    let y = &on.motion;
    [error(&y.q, &y.v), error(&y.p_star, &y.p_star_dot)]
}

/// Eq. (7) and (8): with the true δy they must yield the true δJ for any w, because δf = 0.
pub fn of_variation(mechanisms: &[&Moving; 2]) -> Result<Vec<Finding>, Error> {
    let on = mechanisms[0];
    let (mut change, (k, nodes)) = (on.inputs.no_change(), on.inputs.controls.shape());
    change.controls = DMatrix::from_fn(k, nodes, |k, i| (1.3 * i as f64 + k as f64).cos());
    let moved = direct_differentiation(&on.system, &on.inputs, Settings::default(), &change)?.motion.nodes;
    let parts = [moved.v, moved.p_star_dot, moved.q, moved.p_star, moved.sigma];
    let delta_y = DMatrix::from_rows(&parts.iter().flat_map(|part| part.row_iter()).collect::<Vec<_>>());
    let paper = PaperSystem::new(&on.system, &on.inputs, &on.motion)?;
    let last = on.inputs.grid.steps.len();
    // Arbitrary multipliers; the terms of the cost equal δJ and are omitted on both sides.
    let w = |i: usize| DVector::from_fn(delta_y.nrows(), |r, _| ((i * 7 + r * 3) as f64).sin());
    let own = |i: usize| w(i).dot(&(paper.f_y(i).matrix * delta_y.column(i) + paper.f_u(i) * change.controls.column(i)));
    let from_previous = |i: usize| w(i).dot(&(paper.f_y_previous(i).matrix * delta_y.column(i - 1)));
    let size: f64 = (1..=last).map(|i| own(i).abs()).sum();
    let complete: f64 = (1..=last).map(|i| own(i) + from_previous(i)).sum();
    let printed = complete - from_previous(last);
    let errors = [[relative(printed, size), f64::NAN], [relative(complete, size), f64::NAN]];
    let mut seven = finding(
        "(7)",
        "no term with δy_{N−1} from f_N",
        "+ w_Nᵀ f^N_{y_{N−1}} δy_{N−1}",
        errors,
        "Σ wᵀδf must vanish for any w; (8) contains the term, in its sum for i = N − 1",
    );
    seven.status = Verdict::Misprinted;
    Ok(vec![
        seven,
        slip("(8), first term", "w_1ᵀ f^i_{y_0}", "w_1ᵀ f^1_{y_0}", "the index i is not defined there"),
        slip(
            "(6), (8), (11)",
            "w_0 f_0, never defined; (8) leaves w_0ᵀ f^0_{u_0} out, (11) has it",
            "f_0: q_0 and p*_0 given, (1a)–(1c) for q̇_0, σ_0, ṗ*_0",
            "u_0 acts through ṗ*_0 on the first step, so dJ/du_0 is not h_{u_0}; see the numbers at (11)",
        ),
        slip(
            "(10), S",
            "S = [(Φ_{q_{i+1}} q_i)ᵀ σ_{i+1}]_{q_i}",
            "S = [(Φ_{q_{i+1}} q_i)_{q_{i+1}}ᵀ σ_{i+1}]_{q_i} = (Φ_qᵀσ)_q at i + 1",
            "as printed, S is the derivative of a number and thus a vector of n entries; a subscript is missing in two places",
        ),
        slip(
            "(10), names",
            "[f_4^{i+1}]_{q_i} for two blocks of the fourth row; six rows in the left matrix; [f_4^i]_q in the last row",
            "[f_4^{i+1}]_{q̇_i} for the first; five rows; [f_5^i]_q = γ Φ_q + Φ̇_q",
            "",
        ),
        held_velocity(mechanisms)?,
    ])
}

/// [Φ̇_qᵀσ]_q holds as the derivative of the expression with q̂ held; with q̇_i held, it lacks γ (Φ_qᵀσ)_q.
fn held_velocity(mechanisms: &[&Moving; 2]) -> Result<Finding, Error> {
    let run = |on: &Moving, held: bool| -> Result<f64, Error> {
        let paper = PaperSystem::new(&on.system, &on.inputs, &on.motion)?;
        let report = check::step(&paper).f_y(Equation::F4, Variable::Q, |at| {
            let t = at.terms();
            let rest = if held { t.phi_dot_q_t_sigma_q } else { t.phi_dot_q_t_sigma_q + t.phi_q_t_sigma_q * at.gamma };
            &t.force_q + &t.force_v * at.gamma + rest
        });
        Ok(report.run().blocks[0].relative_error)
    };
    let both = |held: bool| -> Result<[f64; 2], Error> { Ok([run(mechanisms[0], held)?, run(mechanisms[1], held)?]) };
    let [a, b] = both(true)?;
    let words = format!(
        "easily misread: Q is split into its two parts, Φ̇ is not; read with q̇ held, it lacks γ (Φ_qᵀσ)_q, an error of {a:.0e} / {b:.0e}"
    );
    Ok(finding("(10), [Φ̇_qᵀσ_i]_q", "with q̂ held", "", [both(false)?; 2], &words))
}

/// Eq. (3), first and third: the residual along the motion, relative to its terms.
fn substituted(mechanisms: &[&Moving; 2]) -> Result<Finding, Error> {
    let error = |on: &Moving| -> Result<f64, Error> {
        let paper = PaperSystem::new(&on.system, &on.inputs, &on.motion)?;
        let at = |i: usize| {
            let f = paper.f(i);
            let (n, m) = (on.system.n(), on.system.m());
            let momentum = relative(f.rows(2 * n, n).amax(), on.motion.p_star.amax());
            momentum.max(relative(f.rows(4 * n, m).amax(), on.motion.v.amax()))
        };
        Ok(largest((1..=on.inputs.grid.steps.len()).map(at)))
    };
    let errors = [error(mechanisms[0])?, error(mechanisms[1])?];
    Ok(finding("(3), first and third", "p*, q̇ and Φ̇ with q̇_i = γ q_i + q̂_{i−1}", "", [errors; 2], ""))
}

/// Eq. (9), (11) and (12), with Eq. (10) corrected.
pub fn of_gradient(on: &Moving) -> Result<Vec<Finding>, Error> {
    let paper = PaperSystem::new(&on.system, &on.inputs, &on.motion)?;
    let w = paper.gradient()?.w;
    let (last, dt, b) = (on.inputs.grid.steps.len(), on.inputs.grid.steps[0], on.inputs.design[0]);
    let settings = Settings::default();
    let all: Vec<Input> = (0..=last).map(|node| Input::Control { channel: 0, node }).collect();
    let truth = complex_step(&on.system, &on.inputs, settings, &all)?;
    // h = ½ b u² at nodes 0 … N − 1.
    let u = |i: usize| on.inputs.controls[(0, i)];
    let h_u = |i: usize| if i < last { b * u(i) } else { 0.0 };
    let sum = |i: usize| h_u(i) + paper.f_u(i).column(0).dot(&w.column(i));
    let size = largest(&truth);
    let worst = |value: &dyn Fn(usize) -> f64, nodes: std::ops::Range<usize>| {
        relative(largest(nodes.map(|i| value(i) - truth[i])), size)
    };
    let one = |x: f64| [x, f64::NAN];
    let eleven = [one(worst(&|i| sum(i) * dt, 0..last)), one(worst(&sum, 0..last))];
    let at_last =
        [one(relative(sum(last) * dt - truth[last], truth[last])), one(relative(sum(last) - truth[last], truth[last]))];
    let first = [one(relative(h_u(0) - truth[0], truth[0])), one(relative(sum(0) - truth[0], truth[0]))];
    let mut findings = vec![
        finding(
            "(8), i = 0",
            "dJ/du_0 = h_{u_0}",
            "h_{u_0} + w_0ᵀ f^0_{u_0}, f_0 as above",
            first,
            "w_0ᵀ f^0_{u_0} is missing",
        ),
        finding(
            "(11)",
            "∇J(u_i) = (h_{u_i} + w_iᵀ f_{u_i}) Δt",
            "h_{u_i} + w_iᵀ f_{u_i}",
            eleven,
            &format!("constant factor Δt (here {dt}) for J as in (5)"),
        ),
        finding("(11), i = N", "∇J(u_N) = w_Nᵀ f_{u_N} Δt", "w_Nᵀ f_{u_N}", at_last, "constant factor Δt"),
    ];
    findings.push(design(on, &paper, &w, dt)?);
    Ok(findings)
}

/// Eq. (12), with its misprints corrected one after the other.
fn design(on: &Moving, paper: &PaperSystem, w: &DMatrix<f64>, dt: f64) -> Result<Finding, Error> {
    let truth = complex_step(&on.system, &on.inputs, Settings::default(), &[Input::Design(0)])?[0];
    let last = on.inputs.grid.steps.len();
    let h_b = |i: usize| if i < last { 0.5 * on.inputs.controls[(0, i)].powi(2) } else { 0.0 };
    let term = |i: usize| h_b(i) + paper.f_b(i).column(0).dot(&w.column(i));
    let sum = |nodes: std::ops::RangeInclusive<usize>| nodes.map(term).sum::<f64>();
    let error = |value: f64| relative(value - truth, truth);
    let printed = error(h_b(0) + sum(0..=last - 1) * dt);
    let words = format!(
        "error {:.0e} without Δt, {:.0e} also without the second h_0, {:.0e} also with the term of i = N",
        error(h_b(0) + sum(0..=last - 1)),
        error(sum(0..=last - 1)),
        error(sum(0..=last))
    );
    let errors = [[printed, f64::NAN], [error(sum(0..=last)), f64::NAN]];
    Ok(finding(
        "(12)",
        "h_{u_0} + Σ_{i=0}^{N−1} (h_u + wᵀ f_u) Δt",
        "Σ_{i=0}^{N−1} (h_u + wᵀ f_u) + w_Nᵀ f^N_u",
        errors,
        &words,
    ))
}
