//! Located events in complex or dual numbers: the parts of the lengths of phases for which the parts of the functions of events vanish.

use super::{Lifted, Near};
use crate::accelerations::EventFunctions;
use crate::motion::{Refinement, Trial};
use crate::number::Real;
use crate::{Error, Inputs};

/// Largest number of corrections of a phase.
const MOST: usize = 30;

/// The length of a phase, and the function at its end.
#[derive(Clone, Copy)]
struct Pass<R> {
    length: R,
    g: R,
}

impl<R: Real> Lifted<R> {
    /// Computes all nodes after the start for these given inputs, whose events are located in the real motion.
    pub(super) fn step_located(&mut self, near: &mut Near, given: &Inputs<R>, refinement: &Refinement) -> Result<(), Error> {
        let (mut trial, scales) = (Trial::of(given), near.motion.scales.clone());
        let mut left = given.grid.steps.iter().fold(R::zero(), |sum, &dt| sum + dt);
        let (mut first, mut functions) = (1, EventFunctions::default());
        for phase in 0..trial.phases.count() {
            let last = near.motion.trajectory.column_of(trial.phases.steps(phase).end);
            let own = trial.phases.length(phase, &given.grid.steps);
            let is_located = phase < trial.phases.located;
            let mut length = if is_located { own * scales.factors[phase] } else { left };
            let (mut slope, mut before) = (scales.slopes[phase], None::<Pass<R>>);
            for pass in 0..MOST {
                trial.set_steps(phase, length / own);
                self.inputs = refinement.refine(&trial.taken);
                self.inputs.grid.write_times(&mut self.trajectory.times);
                (first..=last).try_for_each(|i| self.step(near, i))?;
                if !is_located {
                    break;
                }
                let node = near.motion.trajectory.column_of(given.events[phase].node);
                let at = self.trajectory.at((&self.inputs, &self.design), node);
                let place = (near.motion.node_of_whole(node), near.motion.trajectory.compliance_from(node));
                let g = functions.value(near.system, given.events[phase].event.index(), (&at, place))?;
                let now = Pass { length, g };
                let size = self.size(now.g);
                // The mixed part of a hyper-dual number depends on the others.
                let is_stalled = before.is_some_and(|before| pass >= R::PARTS && size >= 0.5 * self.size(before.g));
                if size == 0.0 || is_stalled {
                    break;
                }
                slope = before.map_or(slope, |before| self.slope(before, now, slope));
                (1..R::PARTS).for_each(|part| length.add_to_part(part, -now.g.part(part) / slope));
                before = Some(now);
            }
            first = last + 1;
            left -= length;
        }
        Ok(())
    }

    /// The largest part beyond the real one, relative to the perturbation.
    fn size(&self, x: R) -> f64 {
        (1..R::PARTS).fold(0.0, |size, part| (x.part(part).abs() / self.unit[part].max(f64::MIN_POSITIVE)).max(size))
    }

    /// dg/dT by the first part of two passes, since the given one may be that of the other side of a kink.
    fn slope(&self, before: Pass<R>, now: Pass<R>, known: f64) -> f64 {
        let [by, change] = [now.length - before.length, now.g - before.g].map(|x| x.part(1));
        let counts = change.abs() > 1e-6 * before.g.part(1).abs() && by != 0.0;
        if counts { change / by } else { known }
    }
}
