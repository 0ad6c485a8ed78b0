//! [`SolvedMotion`]: a motion and the means to solve linear equations along it.

use super::linearisation::Linearisation;
use crate::motion::{Motion, Report, Watch};

/// A computed motion, as backward sweeps and products with its Hessian need it.
pub(crate) struct SolvedMotion<'a> {
    pub(crate) motion: &'a Motion,
    pub(crate) linearisation: &'a mut Linearisation,
    /// The report of the forward sweep.
    pub(crate) report: &'a Report,
    pub(crate) watch: &'a mut Watch,
}
