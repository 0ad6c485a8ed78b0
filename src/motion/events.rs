//! The events of a motion as data: what happened at which node, and the state before it.
//!
//! What an event does is in [`event`](crate::event).

use crate::model::Param;
use crate::system::NodeView;

/// What happens at a node, after the step that ends there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Event {
    /// The position constraints are satisfied again, and the multipliers begin anew (`event/restart/`).
    Restart(Restart),
    /// Constraint equations open or close (`event/switch.rs`); in the second step of an impact, with restitution.
    Switch(Option<Restitution>),
    /// An impulse acts on the system (`event/impulse/`).
    #[cfg(test)]
    Impulse(Impulse),
}

/// A restart with s = α σ⁻ + β σ₋, where σ₋ are the multipliers at an earlier node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Restart {
    /// True if Φ = 0 is restored.
    pub(crate) projects: bool,
    /// The node of σ₋.
    pub(crate) before: usize,
    /// α and β.
    pub(crate) weights: [f64; 2],
}

/// The restitution of an impact: σ_j changes by e times its change since an earlier node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Restitution {
    pub(crate) equation: usize,
    /// e.
    pub(crate) coefficient: Param,
    /// The node before the impact.
    pub(crate) before: usize,
}

/// An impulse q_i b_p on one coordinate, with a parameter b_p.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impulse {
    pub(crate) coordinate: usize,
    pub(crate) parameter: usize,
}

/// The events of a motion in the order of their nodes, each with the end of the step before it, and with numbers of its own.
#[derive(Default)]
pub(crate) struct Events {
    nodes: Vec<usize>,
    happened: Vec<Event>,
    ends: StepEnds,
    /// The numbers of all events, one event after another, and where those of each end.
    numbers: Vec<f64>,
    numbers_end: Vec<usize>,
}

#[derive(Default)]
struct StepEnds {
    q: Vec<f64>,
    v: Vec<f64>,
    p_star_dot: Vec<f64>,
    sigma: Vec<f64>,
    blocks: Vec<f64>,
}

/// The state at the end of a step that precedes an event, with its second derivatives.
#[derive(Clone, Copy)]
pub(crate) struct StepEnd<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) p_star_dot: &'a [f64],
    pub(crate) sigma: &'a [f64],
    pub(crate) blocks: &'a [f64],
}

/// An event of a motion.
#[derive(Clone, Copy)]
pub(crate) struct Happened<'a> {
    pub(crate) node: usize,
    pub(crate) event: &'a Event,
    pub(crate) end: StepEnd<'a>,
    /// What the event stored for its derivatives.
    pub(crate) numbers: &'a [f64],
}

impl Events {
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.happened.clear();
        self.numbers.clear();
        self.numbers_end.clear();
        let StepEnds { q, v, p_star_dot, sigma, blocks } = &mut self.ends;
        [q, v, p_star_dot, sigma, blocks].into_iter().for_each(Vec::clear);
    }

    /// Forgets the events after a node.
    pub(crate) fn truncate(&mut self, node: usize) {
        let (all, left) = (self.nodes.len(), self.nodes.partition_point(|&at| at <= node));
        if left == all {
            return;
        }
        let StepEnds { q, v, p_star_dot, sigma, blocks } = &mut self.ends;
        [q, v, p_star_dot, sigma, blocks].into_iter().for_each(|list| list.truncate(list.len() / all * left));
        self.nodes.truncate(left);
        self.happened.truncate(left);
        self.numbers_end.truncate(left);
        self.numbers.truncate(self.numbers_end.last().copied().unwrap_or(0));
    }

    /// True if both have the same events at the same nodes.
    pub(crate) fn are_alike(&self, other: &Events) -> bool {
        self.nodes == other.nodes && self.happened == other.happened
    }

    /// Adds an event after all others; `numbers` writes the numbers of the event.
    pub(crate) fn push<Failure>(
        &mut self,
        (node, event): (usize, Event),
        end: StepEnd,
        numbers: impl FnOnce(&mut Vec<f64>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let begin = self.numbers.len();
        if let Err(failure) = numbers(&mut self.numbers) {
            self.numbers.truncate(begin);
            return Err(failure);
        }
        self.numbers_end.push(self.numbers.len());
        self.nodes.push(node);
        self.happened.push(event);
        let StepEnds { q, v, p_star_dot, sigma, blocks } = &mut self.ends;
        let lists = [(q, end.q), (v, end.v), (p_star_dot, end.p_star_dot), (sigma, end.sigma), (blocks, end.blocks)];
        lists.into_iter().for_each(|(list, of)| list.extend_from_slice(of));
        Ok(())
    }

    /// The event at a node.
    pub(crate) fn at(&self, node: usize) -> Option<Happened<'_>> {
        let which = self.nodes.binary_search(&node).ok()?;
        let count = self.nodes.len();
        let of = |list: &'_ Vec<f64>| {
            let len = list.len() / count;
            which * len..(which + 1) * len
        };
        let StepEnds { q, v, p_star_dot, sigma, blocks } = &self.ends;
        let end = StepEnd {
            q: &q[of(q)],
            v: &v[of(v)],
            p_star_dot: &p_star_dot[of(p_star_dot)],
            sigma: &sigma[of(sigma)],
            blocks: &blocks[of(blocks)],
        };
        let begin = which.checked_sub(1).map_or(0, |before| self.numbers_end[before]);
        let numbers = &self.numbers[begin..self.numbers_end[which]];
        Some(Happened { node, event: &self.happened[which], end, numbers })
    }
}

impl<'a> StepEnd<'a> {
    /// The arguments of the equations, with the inputs of the node.
    pub(crate) fn view(&self, node: NodeView<'a, f64>) -> NodeView<'a, f64> {
        let StepEnd { q, v, p_star_dot, sigma, .. } = *self;
        NodeView { q, v, p_star_dot, sigma, ..node }
    }
}
