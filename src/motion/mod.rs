//! Motions as data: inputs, time grid and states.

mod clock;
mod column;
mod composition;
mod grid;
mod inputs;
mod progress;
mod refinement;
mod report;
mod stages;
mod trajectory;

pub(crate) use clock::Clock;
pub(crate) use column::{column, column_mut};
pub use composition::Composition;
pub use grid::Grid;
pub(crate) use inputs::check_size;
pub use inputs::{Held, Inputs, Start};
pub(crate) use progress::Watch;
pub use progress::{Progress, Task};
pub(crate) use refinement::Refinement;
pub use report::Report;
pub use stages::Stages;
pub(crate) use trajectory::Compliances;
pub use trajectory::{Compliance, Trajectory};
