//! [`Occurrence`]: an event at a node of a grid, and [`Phases`]: the steps between events.

use std::ops::Range;

use super::Timed;
use crate::number::Real;
use crate::{Error, Event, Grid, Inputs, Multiplier, System, Warning};

/// An event that determines a node: the steps between the previous event, or the start, and this node are multiplied by a common factor such that
/// the function of the event is zero at the node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence {
    /// The event.
    pub event: Event,
    /// The node of the given grid.
    pub node: usize,
}

impl Event {
    /// The event at this node.
    pub fn at(self, node: usize) -> Occurrence {
        Occurrence { event: self, node }
    }
}

/// The steps of a given grid between events: the phases that end with an event, and the rest of the motion, which ends when the given grid does. There
/// is no rest if the last node has an event.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Phases {
    ends: Vec<usize>,
    /// The number of phases that end with an event.
    pub(crate) located: usize,
}

impl Phases {
    /// From the events of a grid with these steps. Steps of length zero at the end belong to the last event.
    pub(crate) fn new<R: Real>(events: &[Occurrence], steps: &[R]) -> Self {
        let mut ends: Vec<usize> = events.iter().map(|event| event.node).collect();
        let located = ends.len();
        match ends.last_mut() {
            Some(end) if steps.iter().skip(*end).all(|dt| dt.part(0) == 0.0) => *end = steps.len(),
            _ => ends.push(steps.len()),
        }
        Phases { ends, located }
    }

    /// The number of phases, with the rest of the motion.
    pub(crate) fn count(&self) -> usize {
        self.ends.len()
    }

    /// Whether steps follow the last event.
    pub(crate) fn has_rest(&self) -> bool {
        self.ends.len() > self.located
    }

    /// The steps of a phase, counted from 0.
    pub(crate) fn steps(&self, phase: usize) -> Range<usize> {
        phase.checked_sub(1).map_or(0, |before| self.ends[before])..self.ends[phase]
    }

    /// The sum of the steps of a phase.
    pub(crate) fn length<R: Real>(&self, phase: usize, steps: &[R]) -> R {
        steps[self.steps(phase)].iter().fold(R::zero(), |sum, &dt| sum + dt)
    }
}

/// The factors of the steps of all phases, and the derivatives dg/dT of the functions of their events by their lengths.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Scales {
    pub(crate) factors: Vec<f64>,
    pub(crate) slopes: Vec<f64>,
    /// The knots of controls that are functions of time.
    pub(crate) timed: Option<Timed>,
    /// Warnings of the events.
    pub(crate) warnings: Vec<Warning>,
}

impl Scales {
    pub(crate) fn push(&mut self, factor: f64, slope: f64) {
        self.factors.push(factor);
        self.slopes.push(slope);
    }
}

/// Checks the nodes of events.
pub(crate) fn check_events(inputs: &Inputs, system: &System) -> Result<(), Error> {
    let (mut before, last) = (0, inputs.grid.steps.len());
    if inputs.grid.around != [0, 0] && !inputs.events.is_empty() {
        return Err(Error::EventsInPart);
    }
    if inputs.events.is_empty() {
        return Ok(());
    }
    check_signs(&inputs.grid)?;
    let mut is_zero_until = 0;
    for &Occurrence { event, node } in &inputs.events {
        if event.index() >= system.events() || !system.owns(event.0) {
            return Err(Error::Foreign { element: "Inputs::events".into(), kind: "event" });
        }
        let must_be = if node <= before {
            "larger than that of the event before it, and larger than 0"
        } else if node > last {
            "at most the number of steps"
        } else if inputs.grid.macro_steps(node).is_none() {
            "the end of a macro step of the composed grid"
        } else if node <= is_zero_until {
            "behind the steps of length zero that follow the event before it, and at least one more step"
        } else {
            check_zero_steps(inputs, system, (event.index(), node))?;
            (before, is_zero_until) = (node, node + inputs.grid.stages * system.zero_steps_of(event.index()));
            continue;
        };
        let what = format!("the node of event `{}` in `Inputs::events`", system.event_name(event.index()));
        return Err(Error::Parameter { what, value: node as f64, must_be });
    }
    check_phases(inputs)
}

/// Returns an error if all steps of a phase have length zero, so that no factor moves its end.
fn check_phases(Inputs { grid, events, .. }: &Inputs) -> Result<(), Error> {
    let phases = Phases::new(events, &grid.steps);
    let mut ends = (0..phases.count()).map(|phase| phases.steps(phase));
    let empty = ends.find(|steps| grid.steps[steps.clone()].iter().all(|dt| *dt == 0.0));
    empty.map_or(Ok(()), |steps| {
        let what =
            format!("the time between nodes {} and {}, at which events are or the motion ends,", steps.start, steps.end);
        Err(Error::Parameter { what, value: 0.0, must_be: "longer than steps of length zero" })
    })
}

/// Returns an error unless steps of length zero follow an event at which constraints open or close.
fn check_zero_steps(inputs: &Inputs, system: &System, (event, node): (usize, usize)) -> Result<(), Error> {
    let count = inputs.grid.stages * system.zero_steps_of(event);
    let length = |step: usize| inputs.grid.steps.get(step).copied();
    let Some(step) = (node..node + count).find(|&step| length(step) != Some(0.0)) else { return Ok(()) };
    let name = system.event_name(event);
    if step >= inputs.grid.steps.len() {
        let what = format!("the number of steps behind event `{name}`, at which constraints open or close,");
        let must_be = "large enough for its steps of length zero";
        return Err(Error::Parameter { what, value: (inputs.grid.steps.len() - node) as f64, must_be });
    }
    let what = format!("the length of step {}, which follows event `{name}`, at which constraints open or close,", step + 1);
    Err(Error::Parameter { what, value: inputs.grid.steps[step], must_be: "0" })
}

/// Checks the equations that are open at a place.
pub(crate) fn check_open(place: &str, open: &[Multiplier], system: &System) -> Result<(), Error> {
    for open in open {
        if open.index() >= system.m() || !system.owns(open.0) {
            return Err(Error::Foreign { element: place.into(), kind: "multiplier" });
        }
        if !system.may_open(open.index()) {
            let what = format!("the number of {} in `{place}`", system.equation_name(open.index()));
            let must_be = "that of an equation that some event of the scene opens, closes or hits";
            return Err(Error::Parameter { what, value: open.index() as f64, must_be });
        }
    }
    Ok(())
}

/// Returns an error unless all macro steps go in one direction, so that events have an order.
fn check_signs(grid: &Grid) -> Result<(), Error> {
    let mut lengths = grid.steps.chunks(grid.stages.max(1)).map(|steps| steps.iter().sum::<f64>()).enumerate();
    let forward = lengths.next().is_some_and(|(_, length)| length > 0.0);
    let turn = lengths.find(|(_, length)| *length != 0.0 && (*length > 0.0) != forward);
    turn.map_or(Ok(()), |(k, value)| {
        let what = format!("the length of (macro) step {} of a motion with events", k + 1);
        Err(Error::Parameter { what, value, must_be: "of the same sign as the first one" })
    })
}
