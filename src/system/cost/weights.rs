//! [`Weights`]: the factors with which costs are summed over the nodes and stages of a motion.

use num_dual::Dual64;

use crate::model::element::Sum;
use crate::number::Real;

/// The steps next to a node whose weights are counted; one at a time if costs depend on u̇, which jumps from one step to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    Both,
    Before,
    After,
}

impl Beside {
    /// The adjacent steps for which the costs at a node are evaluated, for a grid of `nodes` nodes: both together, or one after the other if u̇ jumps
    /// at the node.
    pub fn of(node: usize, nodes: usize, jumps: bool) -> &'static [Beside] {
        if jumps && node > 0 && node + 1 < nodes { &[Beside::Before, Beside::After] } else { &[Beside::Both] }
    }

    /// The step to which u̇ belongs, numbered by the node at its end.
    pub fn step(self, node: usize) -> usize {
        if self == Beside::After { node + 1 } else { node.max(1) }
    }

    pub fn has_before(self) -> bool {
        self != Beside::After
    }

    pub fn has_after(self) -> bool {
        self != Beside::Before
    }
}

/// The factor of h_i for each way of summing, at one node or stage.
#[derive(Clone, Copy, Debug)]
pub struct Weights<R> {
    /// The factors of rules that use only the given nodes; `None` elsewhere.
    pub given: Option<GivenWeights<R>>,
    /// Δt b_s, summed over the stages at this point.
    pub integral: R,
    /// The steps that are counted.
    pub side: Beside,
}

/// The factors at a given node.
#[derive(Clone, Copy, Debug)]
pub struct GivenWeights<R> {
    /// The number of the node; `None` if costs at this single node are counted in another motion.
    pub node: Option<usize>,
    pub plain: R,
    pub rectangle: R,
    pub trapezoidal: R,
    pub terminal: R,
    /// The event at this node.
    pub event: Option<Occurring>,
    /// The number of the event after whose steps of length zero this node is.
    pub after_event: Option<usize>,
}

/// An event at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occurring {
    /// Its number among the events of the motion.
    pub number: usize,
    /// The number of its function.
    pub function: usize,
}

/// The derivatives of the factor of h_i with respect to the lengths of the steps before and after the node, by dual numbers; for [`Sum::Integral`], with
/// respect to Δt b_s of each.
pub fn slopes(sum: Sum, side: Beside) -> [f64; 2] {
    [[1.0, 0.0], [0.0, 1.0]].map(|rates| {
        let [before, after] = rates.map(|rate| Dual64::new(1.0, rate));
        let counted = [side.has_before().then_some(before), side.has_after().then_some(after)];
        let integral = counted.into_iter().flatten().sum();
        let given = Some(GivenWeights::new(None, Some(before), Some(after), side));
        Weights { given, integral, side }.of(sum).map_or(0.0, |weight: Dual64| weight.eps)
    })
}

impl<R: Real> Weights<R> {
    /// The factors at a stage within a step.
    pub fn between(integral: R) -> Self {
        Weights { given: None, integral, side: Beside::Before }
    }

    /// The factor 1 for the costs that the trapezoidal rule integrates, 0 for all others.
    pub fn of_integrands() -> Self {
        let (zero, one) = (R::zero(), R::one());
        let given = GivenWeights {
            node: None,
            plain: zero,
            rectangle: zero,
            trapezoidal: one,
            terminal: zero,
            event: None,
            after_event: None,
        };
        Weights { given: Some(given), integral: one, side: Beside::After }
    }

    /// The number of the given node at this point, if costs at this single node are counted.
    pub fn node(&self) -> Option<usize> {
        self.given.as_ref().and_then(|given| given.node)
    }

    /// The event at this point.
    pub fn event(&self) -> Option<Occurring> {
        self.given.as_ref().and_then(|given| given.event)
    }

    /// Converts the factors to another number type.
    pub fn map<T>(&self, f: impl Fn(R) -> T) -> Weights<T> {
        let given = self.given.as_ref().map(|given| GivenWeights {
            node: given.node,
            plain: f(given.plain),
            rectangle: f(given.rectangle),
            trapezoidal: f(given.trapezoidal),
            terminal: f(given.terminal),
            event: given.event,
            after_event: given.after_event,
        });
        Weights { given, integral: f(self.integral), side: self.side }
    }

    /// The factor for one way of summing; `None` if it does not apply at this point.
    pub fn of(&self, sum: Sum) -> Option<R> {
        match (sum, &self.given) {
            (Sum::Integral, _) => Some(self.integral),
            (_, None) => None,
            (Sum::Plain, Some(given)) => Some(given.plain),
            (Sum::Rectangle, Some(given)) => Some(given.rectangle),
            (Sum::Trapezoidal, Some(given)) => Some(given.trapezoidal),
            (Sum::Terminal, Some(given)) => Some(given.terminal),
            (Sum::AllNodes, Some(given)) => (given.node.is_some() && self.side.has_before()).then(R::one),
            (Sum::Node(node), Some(given)) => (given.node == Some(node) && self.side.has_before()).then(R::one),
            (Sum::Event(number), Some(given)) => {
                (given.event.is_some_and(|event| event.number == number) && self.side.has_before()).then(R::one)
            }
            (Sum::AfterEvent(number), Some(given)) => {
                (given.after_event == Some(number) && self.side.has_before()).then(R::one)
            }
        }
    }
}

impl<R: Real> GivenWeights<R> {
    /// The factors at a node between steps of length `before` and `after` (`None` at the ends of the grid), restricted to the steps that are
    /// counted.
    pub fn new(node: Option<usize>, before: Option<R>, after: Option<R>, side: Beside) -> Self {
        let (zero, one) = (R::zero(), R::one());
        let [counted_before, counted] = [before.filter(|_| side.has_before()), after.filter(|_| side.has_after())];
        let length = |step: Option<R>| step.unwrap_or(zero);
        GivenWeights {
            node,
            plain: if counted.is_some() { one } else { zero },
            rectangle: length(counted),
            trapezoidal: (length(counted_before) + length(counted)) * 0.5,
            terminal: if after.is_some() { zero } else { one },
            event: None,
            after_event: None,
        }
    }
}
