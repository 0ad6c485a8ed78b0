//! [`Trial`]: inputs whose steps are tried while events are located.

use super::{Phases, Timed};
use crate::Inputs;
use crate::number::Real;

/// The given inputs, and those whose steps are tried.
pub(crate) struct Trial<'a, R: Real> {
    given: &'a Inputs<R>,
    pub(crate) taken: Inputs<R>,
    pub(crate) phases: Phases,
    /// The knots of controls that are functions of time.
    pub(crate) timed: Option<Timed<R>>,
}

impl<'a, R: Real> Trial<'a, R> {
    pub(crate) fn of(given: &'a Inputs<R>) -> Self {
        let phases = Phases::new(&given.events, &given.grid.steps);
        Trial { given, taken: given.clone(), phases, timed: Timed::of(given) }
    }

    /// Sets the steps of a phase to multiples of the given ones, and the controls at its nodes.
    pub(crate) fn set_steps(&mut self, phase: usize, scale: R) {
        let steps = self.phases.steps(phase);
        let given = self.given.grid.steps[steps.clone()].iter();
        self.taken.grid.steps[steps.clone()].iter_mut().zip(given).for_each(|(dt, given)| *dt = *given * scale);
        if let Some(timed) = &self.timed {
            let nodes = steps.start + 1..steps.end + 1;
            timed.write(&self.taken.grid.passed(), nodes, &mut self.taken.controls);
        }
    }
}
