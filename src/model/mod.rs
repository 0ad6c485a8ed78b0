//! What a researcher writes: elements, their parameters, and handles for what they are connected to.

pub mod element;
mod expressions;
mod handle;
mod param;

pub use handle::{Control, Coordinate, Design, Multiplier, Output};
pub(crate) use handle::{Handle, SceneTag};
pub use param::Param;
