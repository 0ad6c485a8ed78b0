//! [`Weights`]: the factors with which costs are summed over the nodes and stages of a motion.

use crate::model::element::Sum;
use crate::number::Real;

/// The factor of h_i for each way of summing, at one node or stage.
#[derive(Clone, Copy, Debug)]
pub struct Weights<R> {
    /// Those of rules that know of the given nodes alone, at such a node.
    pub given: Option<GivenWeights<R>>,
    /// Δt b_s of the stages that are here.
    pub integral: R,
}

/// The factors at a given node.
#[derive(Clone, Copy, Debug)]
pub struct GivenWeights<R> {
    /// Its number.
    pub node: usize,
    pub plain: R,
    pub rectangle: R,
    pub trapezoidal: R,
    pub terminal: R,
}

impl<R: Real> Weights<R> {
    /// The factors between given nodes.
    pub fn between(integral: R) -> Self {
        Weights { given: None, integral }
    }

    /// The given node that this is, if it is one.
    pub fn node(&self) -> Option<usize> {
        self.given.as_ref().map(|given| given.node)
    }

    /// The same on other numbers.
    pub fn map<T>(&self, f: impl Fn(R) -> T) -> Weights<T> {
        let given = self.given.as_ref().map(|given| GivenWeights {
            node: given.node,
            plain: f(given.plain),
            rectangle: f(given.rectangle),
            trapezoidal: f(given.trapezoidal),
            terminal: f(given.terminal),
        });
        Weights { given, integral: f(self.integral) }
    }

    /// The factor for one way; none if it has nothing to do with this place.
    pub fn of(&self, sum: Sum) -> Option<R> {
        match (sum, &self.given) {
            (Sum::Integral, _) => Some(self.integral),
            (_, None) => None,
            (Sum::Plain, Some(given)) => Some(given.plain),
            (Sum::Rectangle, Some(given)) => Some(given.rectangle),
            (Sum::Trapezoidal, Some(given)) => Some(given.trapezoidal),
            (Sum::Terminal, Some(given)) => Some(given.terminal),
            (Sum::Node(node), Some(given)) => (node == given.node).then(R::one),
        }
    }
}

impl<R: Real> GivenWeights<R> {
    /// The factors at a node of this number between a given step of length `before` and one of length `after` (none at the ends).
    pub fn new(node: usize, before: Option<R>, after: Option<R>) -> Self {
        let (zero, one) = (R::zero(), R::one());
        let length = |step: Option<R>| step.unwrap_or(zero);
        GivenWeights {
            node,
            plain: if after.is_some() { one } else { zero },
            rectangle: length(after),
            trapezoidal: (length(before) + length(after)) * 0.5,
            terminal: if after.is_some() { zero } else { one },
        }
    }
}
