//! A cost behind a trait that hides its type; only this code is compiled for each type of cost.

use super::typed::Wide;
use crate::model::element::{ListCost, ListPoint};
use crate::number::{Fingerprint, Hyper};
use crate::program::Symbol;
use crate::{Cx, Scalar};

/// The formula of a cost on numbers of type S.
pub trait PlainCost<S> {
    fn value(&self, at: &ListPoint<S>) -> S;
}

impl<C: ListCost, S: Scalar> PlainCost<S> for C {
    fn value(&self, at: &ListPoint<S>) -> S {
        self.cost(at)
    }
}

/// A cost of any type.
pub trait AnyCost:
    PlainCost<f64>
    + PlainCost<Cx>
    + PlainCost<Hyper>
    + PlainCost<Wide<f64>>
    + PlainCost<Symbol>
    + PlainCost<Fingerprint>
    + Send
    + Sync
{
}

impl<C: ListCost> AnyCost for C {}
