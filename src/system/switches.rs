//! What happens at events: constraints open, close, or are hit.

use crate::System;
use crate::model::{Action, Gap, Switch};

impl System {
    /// The side from which the function of an event becomes zero: 1 from above, −1 from below, 0 from any.
    pub(crate) fn side_of(&self, event: usize) -> f64 {
        self.0.sides.iter().find(|(of, _)| *of == event).map_or(0.0, |(_, side)| *side)
    }

    /// The gaps of rigid contacts whose equations some event changes, but none holds at other values than zero.
    pub(crate) fn gaps(&self) -> &[Gap] {
        &self.0.gaps
    }

    /// The changes of constraint equations at an event.
    pub(crate) fn switches_of(&self, event: usize) -> impl Iterator<Item = Switch> + '_ {
        self.0.switches.iter().filter(move |switch| switch.event == event).copied()
    }

    /// True if an event closes an equation on which another event is an impact.
    pub(crate) fn settles(&self, event: usize, impact: usize) -> bool {
        let is_impact = |switch: &Switch| matches!(switch.action, Action::Impact(_));
        let hit = |equation| self.switches_of(impact).any(|switch| switch.equation == equation && is_impact(&switch));
        self.switches_of(event).any(|switch| matches!(switch.action, Action::Close | Action::Hold) && hit(switch.equation))
    }

    /// The number of steps of length zero that must follow an event: one in which constraints open and close, and a second one for the restitution of
    /// an impact.
    pub(crate) fn zero_steps_of(&self, event: usize) -> usize {
        let of = |switch: Switch| if matches!(switch.action, Action::Impact(_)) { 2 } else { 1 };
        self.switches_of(event).map(of).max().unwrap_or(0)
    }

    /// The equations that some event closes or hits. They are open at the start unless the inputs say otherwise.
    pub(crate) fn open_at_start(&self) -> Vec<usize> {
        let all = self.0.switches.iter().filter(|switch| switch.action != Action::Open);
        let mut open: Vec<usize> = all.map(|switch| switch.equation).collect();
        open.sort_unstable();
        open.dedup();
        open
    }

    /// The equations that some event closes at their present values.
    pub(crate) fn held(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.switches.iter().filter(|switch| switch.action == Action::Hold).map(|switch| switch.equation)
    }

    /// True if some event changes an equation, so that it may be open.
    pub(crate) fn may_open(&self, equation: usize) -> bool {
        self.0.switches.iter().any(|switch| switch.equation == equation)
    }
}
