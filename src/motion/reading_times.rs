//! The times of readings, compared with those of the nodes at which they are read.

use crate::{Error, Inputs, System};

/// The largest difference between the time of a reading and that of its node, relative to the longer one of the steps beside the node.
const TOLERANCE: f64 = 1e-3;

impl Inputs {
    /// Checks that the nodes of this grid have the times of the readings that they are compared with
    /// ([`Scene::reading_time`](crate::Scene::reading_time)). Problems check their inputs, unless the duration or
    /// lengths of steps are free. Nodes after the first event are not checked, because events move them.
    ///
    /// # Errors
    /// The first reading whose node does not exist, or is at another time.
    pub fn check_reading_times(&self, system: &System) -> Result<(), Error> {
        let readings = system.reading_times();
        if readings.is_empty() {
            return Ok(());
        }
        let (grid, times) = (&self.grid, self.grid.times());
        let last = self.events.iter().map(|event| event.node).min().unwrap_or(usize::MAX);
        let is_wrong = |node: usize, time: f64| {
            let beside = [node.checked_sub(1), Some(node)].map(|step| step.and_then(|step| grid.steps.get(step)));
            let longer = beside.into_iter().flatten().fold(0.0f64, |longer, dt| longer.max(dt.abs()));
            times.get(node).is_none_or(|found| (found - time).abs() > TOLERANCE * longer)
        };
        let [before, after] = grid.around;
        for (reading, node, time) in readings {
            // The node may belong to another part of a longer motion.
            let Some(here) = node.checked_sub(before).filter(|here| after == 0 || *here < times.len()) else { continue };
            if here <= last && is_wrong(here, *time) {
                let (reading, found) = (reading.clone(), times.get(here).copied());
                return Err(Error::ReadingTime { reading, time: *time, node: *node, found });
            }
        }
        Ok(())
    }
}
