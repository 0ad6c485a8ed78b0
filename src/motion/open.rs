//! Constraint equations that are open: dΦ/dt = 0 does not hold, and σ does not change, so that no force acts.
//!
//! An open equation is one with an infinite compliance (`redundancy/compliances.rs`),
//!
//! ```text
//!   E5:  dΦ/dt − μ (σ_i − σ_{i−1}) = 0,    μ = 1e30
//! ```
//!
//! so that all derivatives of the motion with respect to σ_{i−1} are those of compliances. What differs from zero is 1e-30 of the other terms.

use std::borrow::Cow;

use super::computed::Motion;
use super::trajectory::Compliances;
use crate::System;

/// The compliance of an open equation.
pub(crate) const OPEN: f64 = 1e30;

/// The equations that are open.
pub(crate) fn open(compliances: &Compliances) -> impl Iterator<Item = usize> + '_ {
    compliances.iter().filter(|(_, mu)| *mu >= OPEN).map(|(j, _)| *j)
}

/// The compliances of equations that are not open.
pub(crate) fn closed(compliances: &Compliances) -> impl Iterator<Item = (usize, f64)> + '_ {
    compliances.iter().copied().filter(|(_, mu)| *mu < OPEN)
}

/// These compliances, in their order, with these equations open and all others closed.
pub(crate) fn with_open(compliances: &Compliances, open: &[usize]) -> Vec<(usize, f64)> {
    let kept = compliances.iter().filter(|(j, mu)| *mu < OPEN || open.contains(j));
    let mut all: Vec<(usize, f64)> = kept.map(|&(j, mu)| (j, if open.contains(&j) { OPEN } else { mu })).collect();
    let is_known = |j: &usize| compliances.iter().any(|(known, _)| known == j);
    all.extend(open.iter().filter(|j| !is_known(j)).map(|&j| (j, OPEN)));
    all
}

/// What is due at a node behind an event at which equations open or close.
#[derive(Clone, Copy)]
pub(crate) struct Due {
    pub(crate) event: usize,
    /// True at the end of the second step of length zero, where only impacts go on.
    pub(crate) is_second: bool,
    pub(crate) is_last: bool,
}

impl Motion {
    /// The change of equations that is due at a node.
    pub(crate) fn switch_at(&self, system: &System, node: usize) -> Option<Due> {
        let stages = self.inputs.grid.stages;
        let given = self.node_of_whole(node) - self.inputs.grid.around[0];
        let of = |(event, first): (usize, usize)| {
            let count = system.zero_steps_of(event);
            let passed = given.checked_sub(first).filter(|passed| *passed > 0 && passed.is_multiple_of(stages))? / stages;
            (passed <= count).then_some(Due { event, is_second: passed == 2, is_last: passed == count })
        };
        let events = self.inputs.events.iter().map(|occurred| (occurred.event.index(), occurred.node));
        self.macro_steps(node).and_then(|_| events.filter_map(of).next())
    }

    /// The equations that are open after a node.
    pub(crate) fn open_from(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        open(self.trajectory.compliance_from(node))
    }

    /// The equations that are open before a node.
    pub(crate) fn open_into(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        open(self.trajectory.compliance_into(node))
    }

    /// The compliances with which a node is projected: those of all dependent equations, with none left out.
    pub(crate) fn compliance_of_projection(&self, system: &System, node: usize) -> Cow<'_, Compliances> {
        let mut open: Vec<usize> = self.open_into(node).collect();
        // Equations that hold at other values than zero are not projected.
        for held in system.held() {
            if !open.contains(&held) {
                open.push(held);
            }
        }
        let is_known = open.iter().copied().eq(self::open(&self.shared));
        if is_known { Cow::Borrowed(&self.shared) } else { Cow::Owned(with_open(&self.shared, &open)) }
    }
}
