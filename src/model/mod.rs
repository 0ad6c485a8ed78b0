//! Elements, their parameters, and handles to the parts of a scene.

pub mod element;
mod expressions;
mod frame;
mod handle;
mod param;
mod sketch;
pub mod space;
mod switch;

pub(crate) use frame::Owner;
pub use frame::{Frame, Point};
pub use handle::{Control, Coordinate, Design, Event, Multiplier, Output};
pub(crate) use handle::{Handle, SceneTag};
pub use param::Param;
#[cfg(feature = "files")]
pub(crate) use sketch::Unit;
pub(crate) use sketch::{Drawn, FORCE, Shape, Sketch};
pub(crate) use switch::{Action, Gap, Switch};
