//! [`Record`]: the adjoint variables of every stage, which second derivatives are made of.

use nalgebra::DMatrix;

use crate::System;
use crate::motion::{column, column_mut};
use crate::scheme::StageAdjoint;
use crate::system::Covector;

/// One column a stage, in the order of the motion's second derivatives.
#[derive(Default)]
pub(super) struct Record {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    e: DMatrix<f64>,
}

impl Record {
    /// Makes room for so many stages.
    pub(super) fn fit(&mut self, system: &System, stages: usize) {
        if self.a.shape() == (system.n(), stages) {
            return;
        }
        let state = || DMatrix::zeros(system.n(), stages);
        *self = Record { a: state(), b: state(), c: state(), d: state(), e: DMatrix::zeros(system.m(), stages) };
    }

    pub(super) fn store(&mut self, stage: usize, of: &StageAdjoint) {
        let Record { a, b, c, d, e } = self;
        for (matrix, x) in [(a, &of.a), (b, &of.b), (c, &of.c), (d, &of.d), (e, &of.e)] {
            column_mut(matrix, stage).copy_from_slice(x);
        }
    }

    /// a and b.
    pub(super) fn of_step(&self, stage: usize) -> [&[f64]; 2] {
        [column(&self.a, stage), column(&self.b, stage)]
    }

    /// c, d and e.
    pub(super) fn covector(&self, stage: usize) -> Covector<'_> {
        Covector { c: column(&self.c, stage), d: column(&self.d, stage), e: column(&self.e, stage) }
    }
}
