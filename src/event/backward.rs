//! [`Backward`]: what the reset map of an event reads and writes in the backward sweep.

use crate::System;
use crate::motion::{Happened, Motion, Report};
use crate::node::Linearisation;
use crate::system::{CostRows, Pair, StateRows};

/// The derivatives of J with respect to p̄ and σ̄.
pub(crate) struct AfterRows {
    pub(crate) p_star: Vec<f64>,
    pub(crate) sigma: Vec<f64>,
}

/// The contribution of an event to J_σ of an earlier node, until the backward sweep reaches that node.
pub(crate) struct EarlierSigma {
    pub(crate) node: Option<usize>,
    pub(crate) rows: Vec<f64>,
}

/// An event in the backward sweep.
pub(crate) struct Backward<'a> {
    pub(crate) system: &'a System,
    pub(crate) motion: &'a Motion,
    pub(crate) happened: Happened<'a>,
    pub(crate) linearisation: &'a mut Linearisation,
    pub(crate) report: &'a mut Report,
    pub(crate) after: &'a AfterRows,
    /// The derivatives of J with respect to the end of the step. At first, `q` is dJ/dq after the event, and all others are zero.
    pub(crate) end: &'a mut CostRows,
    pub(crate) earlier: &'a mut EarlierSigma,
    /// dJ/du of the node, dJ/dz for the parameters, and dJ/dt, to be added to.
    pub(crate) u: &'a mut [f64],
    pub(crate) design: &'a mut [f64],
    pub(crate) time: &'a mut f64,
    /// Adjoint variables of the event itself, which products with the Hessian need.
    pub(crate) own: &'a mut Pair,
    pub(crate) zeros: &'a Pair,
    /// Workspace: derivatives with respect to a state, a right-hand side in the solver's order, and n numbers.
    pub(crate) rows: &'a mut StateRows,
    pub(crate) right: &'a mut [f64],
    pub(crate) spare: &'a mut [f64],
}
