//! Motions as data: inputs, time grid and states.

mod ahead;
mod assembled;
mod clock;
mod column;
mod composition;
mod computed;
mod examiner;
mod grid;
mod inputs;
mod progress;
mod refinement;
mod report;
mod restarts;
mod stages;
mod trajectory;

pub(crate) use assembled::{Assembly, Which, indices};
pub(crate) use clock::Clock;
pub(crate) use column::{column, column_mut};
pub use composition::Composition;
pub(crate) use computed::Motion;
pub(crate) use examiner::Examiner;
pub use grid::Grid;
pub(crate) use inputs::check_size;
pub use inputs::{Held, Inputs, Start};
pub(crate) use progress::Watch;
pub use progress::{Progress, Task};
pub(crate) use refinement::Refinement;
pub use report::Report;
pub(crate) use restarts::{MOST_CORRECTIONS_OF_PROJECTION, Restart, Restarts};
pub use stages::Stages;
pub(crate) use trajectory::Compliances;
pub use trajectory::{Compliance, Trajectory};
