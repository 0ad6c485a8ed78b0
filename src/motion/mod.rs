//! Motions as data: inputs, time grid and states.

mod ahead;
mod assembled;
mod clock;
mod column;
mod composition;
mod computed;
mod events;
mod examiner;
mod grid;
mod halving;
mod inputs;
mod occurrence;
mod open;
mod progress;
mod reading_times;
mod refinement;
mod report;
mod states;
mod timed;
mod trajectory;
mod trial;

pub(crate) use assembled::{Assembly, Which, indices};
pub(crate) use clock::Clock;
pub(crate) use column::{column, column_mut};
pub use composition::Composition;
pub(crate) use computed::Motion;
#[cfg(test)]
pub(crate) use events::Impulse;
pub(crate) use events::{Event, Events, Happened, Restart, Restitution, StepEnd};
pub(crate) use examiner::Examiner;
pub use grid::Grid;
pub(crate) use grid::passed;
pub(crate) use inputs::check_size;
pub use inputs::{Held, Inputs, Start};
pub use occurrence::Occurrence;
pub(crate) use occurrence::{Phases, Scales, check_open};
pub(crate) use open::{Due, OPEN, closed, open, with_open};
pub(crate) use progress::Watch;
pub use progress::{Progress, Task};
pub(crate) use refinement::Refinement;
pub use report::Report;
pub use states::States;
pub(crate) use timed::{ByKnots, Timed, find_jump};
pub(crate) use trajectory::Compliances;
pub use trajectory::{Compliance, Trajectory};
pub(crate) use trial::Trial;
