//! The terms of the blocks of Eq. (10), at one state.

use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;

use super::super::block::MatrixAt;
use super::point::{Part, State, StepPoint};
use crate::System;
use crate::paper_system::{Equation, PaperSystem, Variable};
use crate::system::{NodeValues, NodeView};

/// M, Φ_q and the other terms of Eq. (10), computed by dual numbers.
///
/// Here Q means Q + T_q − V_q, that is 𝓛_q + Q without constraints. (The paper has no T_q and includes −V_q in Q.) T_qq and T_qv are the
/// contributions of the kinetic energy, zero for constant mass matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// M = 𝓛_vv, n × n.
    pub mass: DMatrix<f64>,
    /// (M v)_q, n × n.
    pub mass_v_q: DMatrix<f64>,
    /// Φ_q, m × n.
    pub phi_q: DMatrix<f64>,
    /// (dΦ/dt)_q, m × n; (Φ_q v)_q without driven joints.
    pub phi_dot_q: DMatrix<f64>,
    /// (Φ_qᵀσ)_q, n × n.
    pub phi_q_t_sigma_q: DMatrix<f64>,
    /// ((dΦ/dt)_qᵀσ)_q, n × n.
    pub phi_dot_q_t_sigma_q: DMatrix<f64>,
    /// (Q + T_q − V_q)_q, n × n.
    pub force_q: DMatrix<f64>,
    /// (Q + T_q − V_q)_v, n × n.
    pub force_v: DMatrix<f64>,
    /// T_qq, the contribution of T_q to `force_q`, n × n.
    pub t_qq: DMatrix<f64>,
    /// T_qv, the contribution of T_q to `force_v`, n × n.
    pub t_qv: DMatrix<f64>,
    /// Q_u, n × k.
    pub force_u: DMatrix<f64>,
}

/// The name of a term, and its value from the terms and γ.
type Named = (&'static str, fn(&Terms, f64) -> DMatrix<f64>);

const REACTION: Named = ("(Φ_qᵀσ)_q", |t, _| t.phi_q_t_sigma_q.clone());
const REACTION_RATE: Named = ("((dΦ/dt)_qᵀσ)_q", |t, _| t.phi_dot_q_t_sigma_q.clone());
const MASS: Named = ("M", |t, _| t.mass.clone());
const MASS_Q: Named = ("(M v)_q", |t, _| t.mass_v_q.clone());
const FORCE_Q: Named = ("Q_q", |t, _| &t.force_q - &t.t_qq);
const FORCE_V: Named = ("Q_v", |t, _| &t.force_v - &t.t_qv);
const T_QQ: Named = ("T_qq", |t, _| t.t_qq.clone());
const T_QV: Named = ("T_qv", |t, _| t.t_qv.clone());
const FORCE_U: Named = ("Q_u", |t, _| t.force_u.clone());
const IDENTITY: Named = ("I", |t, _| DMatrix::identity(t.mass.nrows(), t.mass.ncols()));
const PHI_Q: Named = ("Φ_q", |t, _| t.phi_q.clone());
const PHI_DOT_Q: Named = ("(dΦ/dt)_q", |t, _| t.phi_dot_q.clone());
const PHI_Q_T: Named = ("Φ_qᵀ", |t, _| t.phi_q.transpose());
const PHI_DOT_Q_T: Named = ("(dΦ/dt)_qᵀ", |t, _| t.phi_dot_q.transpose());
const ALL_OF_FORCE_V: Named = ("(Q_v + T_qv)", |t, _| t.force_v.clone());
/// If T_q is forgotten, both of its derivatives are missing.
const ALL_OF_T_Q: Named = ("T_qq + γ T_qv (all of T_q)", |t, gamma| &t.t_qq + &t.t_qv * gamma);

/// A term with its sign and, if `times_gamma`, the factor γ.
fn signed<'a>(paper: &'a PaperSystem<'a>, (name, of): Named, sign: f64, times_gamma: bool) -> (String, MatrixAt<'a>) {
    let matrix: MatrixAt<'a> = Box::new(move |x| {
        let at = StepPoint::new(paper, x);
        of(&at.terms(), at.gamma) * if times_gamma { sign * at.gamma } else { sign }
    });
    (format!("{}{}{name}", if sign < 0.0 { "−" } else { "" }, if times_gamma { "γ " } else { "" }), matrix)
}

/// The terms of a block of Eq. (10), as corrected.
pub(super) fn of_block<'a>(paper: &'a PaperSystem<'a>, row: Equation, by: Part) -> Vec<(String, MatrixAt<'a>)> {
    use Equation::{F3, F4, F5};
    let terms: &[(Named, f64, bool)] = match (row, by) {
        (F3, Part::Y(Variable::Q)) => &[(REACTION, 1.0, false), (MASS, 1.0, true), (MASS_Q, 1.0, false)],
        (F4, Part::Y(Variable::Q)) => &[
            (FORCE_Q, 1.0, false),
            (FORCE_V, 1.0, true),
            (T_QQ, 1.0, false),
            (T_QV, 1.0, true),
            (REACTION_RATE, 1.0, false),
            (REACTION, 1.0, true),
            (ALL_OF_T_Q, 1.0, false),
            (ALL_OF_FORCE_V, 1.0, true),
        ],
        (F5, Part::Y(Variable::Q)) => &[(PHI_Q, 1.0, true), (PHI_DOT_Q, 1.0, false)],
        (F4, Part::Previous(Variable::V)) => {
            &[(REACTION, -1.0, false), (FORCE_V, -1.0, false), (T_QV, -1.0, false), (ALL_OF_FORCE_V, -1.0, false)]
        }
        (F4, Part::Previous(Variable::Q)) => {
            &[(REACTION, -1.0, true), (FORCE_V, -1.0, true), (T_QV, -1.0, true), (ALL_OF_FORCE_V, -1.0, true)]
        }
        _ => &[],
    };
    terms.iter().map(|&(term, sign, times_gamma)| signed(paper, term, sign, times_gamma)).collect()
}

/// All terms that occur in Eq. (10).
pub(super) fn all<'a>(paper: &'a PaperSystem<'a>) -> Vec<(String, MatrixAt<'a>)> {
    let of_momenta = [REACTION, REACTION_RATE, MASS, MASS_Q];
    let of_forces = [FORCE_Q, FORCE_V, T_QQ, T_QV, FORCE_U];
    let of_constraints = [IDENTITY, PHI_Q, PHI_DOT_Q, PHI_Q_T, PHI_DOT_Q_T];
    let named = of_momenta.into_iter().chain(of_forces).chain(of_constraints);
    named.flat_map(|term| [signed(paper, term, 1.0, false), signed(paper, term, 1.0, true)]).collect()
}

impl Terms {
    pub(super) fn new(system: &System, y: &State, u: &DVector<f64>, b: &DVector<f64>, time: f64) -> Self {
        let design = system.parameters().values(b.as_slice());
        let state = [&y.q, &y.v, &y.sigma].map(DVector::as_slice);
        let at = NodeView::of_equations(state, (u.as_slice(), time, &design));
        let loaded = &mut NodeValues::of_equations(&at, Dual64::from_re);
        let unloaded = &mut loaded.clone();
        unloaded.sigma.fill(Dual64::from_re(0.0));
        let all = System::plain_sums;
        // Both are linear in σ, so these differences are the contributions without σ and those of σ.
        let [l_v_q, l_q_q, _] = system.columns(all, loaded, |at| &mut at.q);
        let [mass_v_q, force_q, phi_dot_q] = system.columns(all, unloaded, |at| &mut at.q);
        let [mass, force_v, phi_q] = system.columns(all, unloaded, |at| &mut at.v);
        let [_, force_u, _] = system.columns(all, unloaded, |at| &mut at.u);
        let [_, t_qq, _] = system.columns(System::kinetic_sums, unloaded, |at| &mut at.q);
        let [_, t_qv, _] = system.columns(System::kinetic_sums, unloaded, |at| &mut at.v);
        Terms {
            phi_q_t_sigma_q: l_v_q - &mass_v_q,
            phi_dot_q_t_sigma_q: l_q_q - &force_q,
            mass,
            mass_v_q,
            phi_q,
            phi_dot_q,
            force_q,
            force_v,
            t_qq,
            t_qv,
            force_u,
        }
    }
}
