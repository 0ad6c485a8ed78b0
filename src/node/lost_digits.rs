//! The warning of digits that a factorisation has lost.

use super::linearisation::Linearisation;
use crate::motion::{Motion, Report};
use crate::{System, Warning};

/// Keeps the worst warning of this kind; with compliances, digits are lost only in multipliers that move nothing.
#[inline]
pub(crate) fn warn_of_lost_digits(
    system: &System,
    motion: &Motion,
    linearisation: &Linearisation,
    report: &mut Report,
    (node, worst_before): (usize, f64),
) {
    let is_new = report.worst_pivot < worst_before.min(Warning::LOST_DIGITS);
    if is_new && !motion.trajectory.has_dependent() {
        note(system, motion, linearisation, report, node);
    }
}

#[cold]
fn note(system: &System, motion: &Motion, linearisation: &Linearisation, report: &mut Report, node: usize) {
    let unknown = system.unknown_name(linearisation.worst_unknown(system));
    let (step, time) = (motion.step_of_whole(node), motion.time(node));
    report.replace(Warning::LostDigits { step, time, unknown, pivot: report.worst_pivot });
}
