//! [`Forward`]: what the reset map of an event reads and writes in the forward sweep.

use crate::System;
use crate::motion::{Motion, Report};
use crate::node::{Lengths, Linearisation, Point};

/// The known part of the node problem after an event: at first q⁻, p*⁻ and σ⁻.
pub(crate) struct After<'a, R> {
    pub(crate) q: &'a mut [R],
    pub(crate) p_star: &'a mut [R],
    pub(crate) sigma: &'a mut [R],
}

/// An event in the forward sweep.
pub(crate) struct Forward<'a> {
    pub(crate) system: &'a System,
    /// The motion, with the end of the step in the columns of the node.
    pub(crate) motion: &'a Motion,
    pub(crate) node: usize,
    /// With the factors of K(0) at the end of the step.
    pub(crate) linearisation: &'a mut Linearisation,
    pub(crate) report: &'a mut Report,
    pub(crate) lengths: &'a mut Lengths,
    /// The multipliers at the end of the macro step before.
    pub(crate) sigma_before: &'a [f64],
    /// Workspace.
    pub(crate) point: &'a mut Point,
    pub(crate) after: After<'a, f64>,
    /// Numbers that the other sweeps need.
    pub(crate) numbers: &'a mut Vec<f64>,
}
