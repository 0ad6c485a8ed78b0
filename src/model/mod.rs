//! Elements, their parameters, and handles to the parts of a scene.

mod axis;
pub mod element;
mod expressions;
mod frame;
mod handle;
mod param;
mod sketch;
pub mod space;
mod switch;

pub use axis::Axis;
pub(crate) use frame::Owner;
pub use frame::{Frame, Point};
pub use handle::{Control, Coordinate, Design, Event, Multiplier, Output};
pub(crate) use handle::{Handle, SceneTag};
pub use param::Param;
pub(crate) use sketch::{Drawn, Drives, FORCE, Shape, Sketch, Unit};
pub(crate) use switch::{Action, Gap, Switch};
