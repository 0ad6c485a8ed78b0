//! The plain formulas of a batch, on the numbers that are asked for.

use num_dual::Dual64;

use super::batch::{AnyBatch, PlainBatch};
use super::cost::{AnyCosts, PlainCosts};
use crate::Cx;
use crate::number::{Family, Real};

struct Elements<'a>(&'a dyn AnyBatch);

impl<'a> Family for Elements<'a> {
    type Of<R: Real> = &'a dyn PlainBatch<R>;

    fn real(self) -> &'a dyn PlainBatch<f64> {
        self.0
    }
    fn complex(self) -> &'a dyn PlainBatch<Cx> {
        self.0
    }
    fn dual(self) -> &'a dyn PlainBatch<Dual64> {
        self.0
    }
}

struct OfCosts<'a>(&'a dyn AnyCosts);

impl<'a> Family for OfCosts<'a> {
    type Of<R: Real> = &'a dyn PlainCosts<R>;

    fn real(self) -> &'a dyn PlainCosts<f64> {
        self.0
    }
    fn complex(self) -> &'a dyn PlainCosts<Cx> {
        self.0
    }
    fn dual(self) -> &'a dyn PlainCosts<Dual64> {
        self.0
    }
}

pub(super) fn plain<R: Real>(batch: &dyn AnyBatch) -> &dyn PlainBatch<R> {
    R::of(Elements(batch))
}

pub(super) fn plain_costs<R: Real>(costs: &dyn AnyCosts) -> &dyn PlainCosts<R> {
    R::of(OfCosts(costs))
}
