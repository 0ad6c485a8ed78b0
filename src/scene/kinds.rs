//! The table of all kinds of ready-made parts.

use super::ready::Kind;
use super::{axis, basic, costs, planar, spatial, switches};

/// All kinds of ready-made parts.
pub(crate) fn kinds() -> impl Iterator<Item = &'static Kind> {
    let of_bodies = [&planar::KINDS[..], &spatial::KINDS, &axis::KINDS];
    let others = [&basic::KINDS[..], &switches::KINDS, &costs::KINDS];
    of_bodies.into_iter().chain(others).flatten().copied()
}
