//! What the reset map of an event reads and writes in motions in complex or dual numbers.

use super::forward::After;
use crate::motion::{Happened, Motion, Report};
use crate::node::Linearisation;
use crate::number::Real;
use crate::system::{NodeView, Pair, Sums};
use crate::{Error, System, Trajectory};

/// An event of a motion in numbers of type R, near the real motion.
pub(crate) struct Lifted<'a, R: Real> {
    pub(crate) system: &'a System,
    /// The real motion.
    pub(crate) motion: &'a Motion,
    pub(crate) happened: Happened<'a>,
    pub(crate) linearisation: &'a mut Linearisation,
    pub(crate) report: &'a mut Report,
    /// The motion, with the end of the step in the columns of the node.
    pub(crate) trajectory: &'a Trajectory<R>,
    /// The end of the step, with the inputs of the node.
    pub(crate) end: NodeView<'a, R>,
    pub(crate) after: After<'a, R>,
    pub(crate) sums: &'a mut Sums<R>,
    pub(crate) part: &'a mut Pair,
    /// The largest perturbation of any input, in each part beyond the real one.
    pub(crate) unit: &'a [f64],
    /// The largest correction attributed to rounding, relative to the size that a perturbation of `unit` can cause.
    pub(crate) rounding: &'a mut f64,
}

/// The reset map of an event for numbers of type R.
pub(crate) trait OnNumbers<R: Real> {
    /// Computes (q, p̄, σ̄).
    fn reset(&self, of: Lifted<R>) -> Result<(), Error>;
}
