//! [`Record`]: the adjoint variables of every stage, from which second derivatives are computed.

use nalgebra::DMatrix;

use crate::System;
use crate::motion::{column, column_mut};
use crate::scheme::StageAdjoint;
use crate::system::{Covector, Pair};

/// One column per stage, in the order of the second derivatives of the motion.
#[derive(Default)]
pub(super) struct Record {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    e: DMatrix<f64>,
    /// From the last event to the first; elements after the first `passed` belong to earlier motions and only keep their memory.
    events: Vec<OfEvent>,
    passed: usize,
    /// The first stage with zero adjoint variables: no cost reads the state from there on, so values that are not finite have no effect there.
    end: usize,
}

/// An event: the adjoint variables of its node after it, and those of its own.
#[derive(Default)]
pub(super) struct OfEvent {
    node: usize,
    pub(super) after: StageAdjoint,
    pub(super) own: Pair,
}

impl Record {
    /// Makes room for a number of stages.
    pub(super) fn fit(&mut self, system: &System, stages: usize) {
        (self.passed, self.end) = (0, stages);
        if self.a.shape() == (system.n(), stages) {
            return;
        }
        let state = || DMatrix::zeros(system.n(), stages);
        *self = Record {
            a: state(),
            b: state(),
            c: state(),
            d: state(),
            e: DMatrix::zeros(system.m(), stages),
            end: stages,
            ..Record::default()
        };
    }

    pub(super) fn store(&mut self, stage: usize, of: &StageAdjoint) {
        let Record { a, b, c, d, e, .. } = self;
        for (matrix, x) in [(a, &of.a), (b, &of.b), (c, &of.c), (d, &of.d), (e, &of.e)] {
            column_mut(matrix, stage).copy_from_slice(x);
        }
    }

    /// Stores zeros for a stage after which no cost reads the state.
    pub(super) fn store_nothing(&mut self, stage: usize) {
        let Record { a, b, c, d, e, .. } = self;
        [a, b, c, d, e].into_iter().for_each(|matrix| column_mut(matrix, stage).fill(0.0));
        self.end = stage;
    }

    /// True if no cost reads the state from a stage on.
    pub(super) fn has_nothing(&self, stage: usize) -> bool {
        stage >= self.end
    }

    /// Stores the adjoint variables after the event at a node.
    pub(super) fn begin_event(&mut self, node: usize, after: &StageAdjoint) {
        if self.passed == self.events.len() {
            self.events.push(OfEvent::default());
        }
        let OfEvent { node: own_node, after: own, .. } = &mut self.events[self.passed];
        *own_node = node;
        let lists = [(&mut own.a, &after.a), (&mut own.b, &after.b), (&mut own.c, &after.c), (&mut own.d, &after.d)];
        lists.into_iter().chain([(&mut own.e, &after.e)]).for_each(|(own, list)| own.clone_from(list));
        self.passed += 1;
    }

    /// Stores the current event's own adjoint variables.
    pub(super) fn end_event(&mut self, of: &Pair) {
        if let Some(OfEvent { own, .. }) = self.events[..self.passed].last_mut() {
            own.v.clone_from(&of.v);
            own.sigma.clone_from(&of.sigma);
        }
    }

    /// The event at a node.
    pub(super) fn event(&self, node: usize) -> Option<&OfEvent> {
        let at = self.events[..self.passed].binary_search_by(|event| node.cmp(&event.node)).ok()?;
        Some(&self.events[at])
    }

    /// a and b of a stage.
    pub(super) fn of_step(&self, stage: usize) -> [&[f64]; 2] {
        [column(&self.a, stage), column(&self.b, stage)]
    }

    /// c, d and e of a stage.
    pub(super) fn covector(&self, stage: usize) -> Covector<'_> {
        Covector { c: column(&self.c, stage), d: column(&self.d, stage), e: column(&self.e, stage) }
    }
}
