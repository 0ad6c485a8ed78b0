//! [`Along`] and [`BackwardAlong`]: what the reset map of an event reads and writes in products with the Hessian.

use super::backward::Backward;
use super::forward::After;
use crate::System;
use crate::motion::{Happened, Motion, Report};
use crate::node::{Linearisation, PhiAlong, SecondOrderPrograms};
use crate::scheme::StageAdjoint;
use crate::system::{CostRows, NodeView, Pair, Sums};

/// Second derivatives of the formulas, and workspace.
pub(crate) struct Tools<'a> {
    pub(crate) programs: &'a mut SecondOrderPrograms,
    pub(crate) phi: &'a mut PhiAlong,
    pub(crate) sums: &'a mut Sums<f64>,
    pub(crate) rows: &'a mut CostRows,
    pub(crate) right: &'a mut Pair,
    pub(crate) left: &'a mut Pair,
    pub(crate) spare: &'a mut [f64],
    pub(crate) zeros: &'a Pair,
    pub(crate) no_controls: &'a [f64],
}

/// An event in the derivative of the motion along a direction.
pub(crate) struct Along<'a> {
    pub(crate) system: &'a System,
    pub(crate) motion: &'a Motion,
    pub(crate) happened: Happened<'a>,
    pub(crate) linearisation: &'a mut Linearisation,
    pub(crate) report: &'a mut Report,
    /// The derivative of the motion, with that of the end of the step in the columns of the node.
    pub(crate) change: &'a Motion,
    pub(crate) after: After<'a, f64>,
    /// Numbers that the backward sweep needs.
    pub(crate) numbers: &'a mut Vec<f64>,
    pub(crate) tools: Tools<'a>,
}

/// An event in the derivative of the backward sweep along a direction.
pub(crate) struct BackwardAlong<'a> {
    /// The derivatives of all that [`ResetMap::backward`](super::ResetMap::backward) computes.
    pub(crate) of: Backward<'a>,
    /// The adjoint variables of the gradient after the event: dJ/dq = −a, dJ/dp̄ = −b.
    pub(crate) first: &'a StageAdjoint,
    /// The event's own adjoint variables of the gradient.
    pub(crate) first_own: &'a Pair,
    /// The derivative of the motion, with that of the state after the event in the columns of the node.
    pub(crate) change: &'a Motion,
    /// The derivative of the end of the step.
    pub(crate) end: NodeView<'a, f64>,
    /// The numbers stored by [`ResetMap::along`](super::ResetMap::along).
    pub(crate) numbers: &'a [f64],
    pub(crate) tools: Tools<'a>,
}

impl<'a> BackwardAlong<'a> {
    /// A direction of (q, v, σ), with the direction of the inputs at the node.
    pub(crate) fn direction(&self, state: [&'a [f64]; 3]) -> NodeView<'a, f64> {
        let NodeView { u, t, design, .. } = self.change.at(self.of.happened.node);
        NodeView::of_equations(state, (u, t, design))
    }

    /// Adds the derivatives in `tools.rows` with respect to the inputs.
    pub(crate) fn add_inputs(&mut self) {
        let (of, rows) = (&mut self.of, &self.tools.rows);
        crate::number::add(of.u, &rows.u);
        crate::number::add(of.design, &rows.design);
        *of.time += rows.time;
    }
}
