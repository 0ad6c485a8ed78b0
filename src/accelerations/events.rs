//! [`EventFunctions`]: the functions of events, which may read v̇ and λ.

use super::Accelerations;
use crate::motion::Compliances;
use crate::number::Real;
use crate::system::NodeView;
use crate::{Error, System};

/// Evaluates the functions of the events of one motion.
#[derive(Default)]
pub(crate) struct EventFunctions {
    /// Created for the first function that reads v̇ or λ.
    accelerations: Option<Box<Accelerations>>,
}

impl EventFunctions {
    /// The function of an event at a node, with the compliances of the motion from there on.
    ///
    /// # Errors
    /// Accelerations that are not determined, or needed in hyper-dual numbers.
    pub(crate) fn value<R: Real>(
        &mut self,
        system: &System,
        event: usize,
        (at, place): (&NodeView<R>, (usize, &Compliances)),
    ) -> Result<R, Error> {
        if !system.event_reads_accelerations(event) {
            return Ok(system.event_value(event, at));
        }
        let accelerations = self.accelerations.get_or_insert_with(|| Box::new(Accelerations::new(system)));
        let [v_dot, lambda] = accelerations.lift(system, at, (place, true))?;
        Ok(system.event_value(event, &NodeView { v_dot: &v_dot, lambda: &lambda, ..*at }))
    }
}
