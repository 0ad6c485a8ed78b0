//! [`Segment`]: a part of a motion, treated as a motion of its own.

use nalgebra::DVector;

use super::free::{Free, Quantity};
use super::motion_problem::MotionProblem;
use super::problem::Interval;
use super::variables::Variables;
use crate::{EndState, Error, Held, Inputs, Settings, Start, System};

/// The problem of a part of a motion, and its place in the whole problem.
#[derive(Debug)]
pub(super) struct Segment {
    pub(super) motion: MotionProblem,
    /// The first and the last node.
    pub(super) first: usize,
    pub(super) last: usize,
    /// The index in the whole problem of each variable of the segment.
    pub(super) places: Vec<usize>,
}

impl Segment {
    /// The segment between two nodes. Unless it begins at the first node, the states of its start are the next variables.
    ///
    /// # Errors
    /// Invalid inputs and variables.
    pub(super) fn new(
        (system, settings): (&System, Settings),
        whole: &Inputs,
        free: &[Free],
        states: &[EndState],
        (first, last): (usize, usize),
        next: &mut usize,
    ) -> Result<Self, Error> {
        if free.iter().any(|of| of.quantity == Quantity::Duration) && share(whole, (first, last)) <= 0.0 {
            let why =
                "one of the segments runs backwards in time or has zero length; use other segments, or fix the duration";
            return Err(Error::NotInSegments { what: "a free duration".into(), why });
        }
        let (own, places) = own_variables(free, whole, (first, last), states, next);
        let inputs = own_inputs(system, whole, (first, last), states);
        let variables = Variables::new(system, &inputs, own)?;
        let motion = MotionProblem::new(system, settings, inputs, variables)?;
        Ok(Segment { motion, first, last, places })
    }

    /// Copies the state at the start of the segment, of `states` coordinates, to the variables of the whole problem.
    pub(super) fn put_start(&self, states: usize, whole: &mut [f64]) {
        let (own, known) = (self.motion.start(), self.places.len() - 2 * states);
        self.places[known..].iter().zip(&own[known..]).for_each(|(&at, x)| whole[at] = *x);
    }
}

/// The fraction of a motion's duration between two nodes.
fn share(inputs: &Inputs, (first, last): (usize, usize)) -> f64 {
    let sum = |steps: &[f64]| steps.iter().sum::<f64>();
    sum(&inputs.grid.steps[first..last]) / sum(&inputs.grid.steps)
}

/// The free quantities of a segment, and their variables in the whole problem; except for the first segment, the start has the next variables.
fn own_variables(
    free: &[Free],
    inputs: &Inputs,
    (first, last): (usize, usize),
    states: &[EndState],
    next: &mut usize,
) -> (Vec<Free>, Vec<usize>) {
    let (mut own, mut places, mut at) = (Vec::new(), Vec::new(), 0);
    let share = share(inputs, (first, last));
    for of in free {
        match of.quantity {
            Quantity::Control(_) => {
                places.extend(at + first..=at + last);
                own.push(of.clone());
                at += inputs.grid.nodes();
                continue;
            }
            Quantity::Duration => {
                let Interval { least, most } = of.bounds;
                own.push(Free { scale: of.scale * share, bounds: Interval::new(least * share, most * share), ..of.clone() });
                places.push(at);
            }
            Quantity::Coordinate(_) | Quantity::Rate(_) if first > 0 => {}
            _ => {
                own.push(of.clone());
                places.push(at);
            }
        }
        at += 1;
    }
    if first > 0 {
        for state in states {
            own.extend([Quantity::Coordinate(state.coordinate), Quantity::Rate(state.coordinate)].map(Free::new));
            places.extend([*next, *next + 1]);
            *next += 2;
        }
    }
    (own, places)
}

/// The inputs between two nodes; except for the first segment, the start consists of states.
fn own_inputs(system: &System, inputs: &Inputs, (first, last): (usize, usize), states: &[EndState]) -> Inputs {
    let mut own = inputs.clone();
    own.grid = inputs.grid.part(first, last);
    own.controls = inputs.controls.columns(first, last - first + 1).into_owned();
    if first > 0 {
        let (q, v) = (inputs.start.q().clone(), DVector::zeros(system.n()));
        let coordinates: Vec<_> = states.iter().map(|state| state.coordinate).collect();
        let held = Held { coordinates: coordinates.clone(), velocities: coordinates };
        own.start = if system.m() == 0 { Start::Velocity { q, v } } else { Start::Assembled { q, v, held } };
    }
    own
}
