//! Events: what happens to a motion at a node, between the step that ends there and the next one.
//!
//! An event replaces the state at the end of the step by the known part of a node problem with h = 0,
//!
//! ```text
//!   (q, p̄, σ̄) = R((q, v, p*, ṗ*, σ)⁻, u, b, t),      then v and σ from Eq. (1a) and (1c) with p* = p̄, as at node 0
//! ```
//!
//! R is the reset map of the event. The forward and backward sweeps, products with the Hessian and motions in complex or dual numbers know an event
//! only by its [`ResetMap`]. A new event takes three steps: its data in [`Event`], a folder here with its reset map, and a line in [`reset_map`].

mod along;
mod backward;
mod forward;
#[cfg(test)]
pub(crate) mod impulse;
mod lifted;
mod restart;
mod switch;

pub(crate) use along::{Along, BackwardAlong, Tools};
pub(crate) use backward::{AfterRows, Backward, EarlierSigma};
pub(crate) use forward::{After, Forward};
pub(crate) use lifted::{Lifted, OnNumbers};

use num_dual::Dual64;

use crate::linear::Breakdown;
use crate::motion::{Event, Report, Trajectory};
use crate::node::StepFailure;
use crate::number::{Family, Hyper, Real};
use crate::{Cx, Error};

/// The reset map R of an event, with its derivatives.
pub(crate) trait ResetMap: OnNumbers<f64> + OnNumbers<Cx> + OnNumbers<Dual64> + OnNumbers<Hyper> {
    /// Computes (q, p̄, σ̄).
    fn forward(&self, of: Forward) -> Result<(), StepFailure>;

    /// Notes the event in the results of a motion.
    fn monitor(&self, node: usize, trajectory: &mut Trajectory, report: &mut Report);

    /// From the derivatives of J with respect to (q, p̄, σ̄) to those with respect to the end of the step and the inputs.
    fn backward(&self, of: &mut Backward) -> Result<(), Breakdown>;

    /// The derivative of (q, p̄, σ̄) along a direction.
    fn along(&self, of: Along) -> Result<(), Breakdown>;

    /// The derivative of [`backward`](Self::backward) along a direction.
    fn backward_along(&self, of: BackwardAlong) -> Result<(), Breakdown>;
}

/// The reset map of an event.
pub(crate) fn reset_map(event: &Event) -> &dyn ResetMap {
    match event {
        Event::Restart(restart) => restart,
        Event::Switch(restitution) => restitution,
        #[cfg(test)]
        Event::Impulse(impulse) => impulse,
    }
}

struct OfEvent<'a>(&'a dyn ResetMap);

impl<'a> Family for OfEvent<'a> {
    type Of<R: Real> = &'a dyn OnNumbers<R>;

    fn real(self) -> Self::Of<f64> {
        self.0
    }
    fn complex(self) -> Self::Of<Cx> {
        self.0
    }
    fn dual(self) -> Self::Of<Dual64> {
        self.0
    }
    fn hyper(self) -> Self::Of<Hyper> {
        self.0
    }
}

/// Computes (q, p̄, σ̄) of an event in complex or dual numbers.
pub(crate) fn lift<R: Real>(event: &Event, of: Lifted<R>) -> Result<(), Error> {
    R::of(OfEvent(reset_map(event))).reset(of)
}
