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
    /// From the last restart to the first; elements after the first `crossings` belong to earlier motions and only keep their memory.
    crossed: Vec<Crossed>,
    crossings: usize,
    /// The first stage with zero adjoint variables: no cost reads the state from there on, so values that are not finite have no effect there.
    end: usize,
}

/// A restart: the adjoint variables of the restarted motion, and (c, e) of the projection.
#[derive(Default)]
pub(super) struct Crossed {
    node: usize,
    pub(super) anew: StageAdjoint,
    pub(super) projection: Pair,
}

impl Record {
    /// Makes room for a number of stages.
    pub(super) fn fit(&mut self, system: &System, stages: usize) {
        (self.crossings, self.end) = (0, stages);
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

    /// Stores the adjoint variables after the restart at a node.
    pub(super) fn begin_crossing(&mut self, node: usize, anew: &StageAdjoint) {
        if self.crossings == self.crossed.len() {
            self.crossed.push(Crossed::default());
        }
        let Crossed { node: own_node, anew: own, .. } = &mut self.crossed[self.crossings];
        *own_node = node;
        let lists = [(&mut own.a, &anew.a), (&mut own.b, &anew.b), (&mut own.c, &anew.c), (&mut own.d, &anew.d)];
        lists.into_iter().chain([(&mut own.e, &anew.e)]).for_each(|(own, list)| own.clone_from(list));
        self.crossings += 1;
    }

    /// Stores (c, e) of the projection of the current restart.
    pub(super) fn end_crossing(&mut self, of: &StageAdjoint) {
        if let Some(Crossed { projection, .. }) = self.crossed[..self.crossings].last_mut() {
            projection.v.clone_from(&of.c);
            projection.sigma.clone_from(&of.e);
        }
    }

    /// The restart at a node.
    pub(super) fn crossed(&self, node: usize) -> Option<&Crossed> {
        let at = self.crossed[..self.crossings].binary_search_by(|crossed| node.cmp(&crossed.node)).ok()?;
        Some(&self.crossed[at])
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
