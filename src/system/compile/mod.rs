//! From the parts of a scene to a compiled system.

mod compiler;
mod groups;
mod names;
mod parameters;
mod postponed;
mod scene_parts;
mod structure;

pub(in crate::system) use names::Names;
pub(in crate::system) use parameters::Parameters;
pub(crate) use scene_parts::{Parts, Required};
