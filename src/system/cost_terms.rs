//! Which terms J and the outputs have, how each is summed, and what it depends on.

use super::cost::{CostFactors, Costs, Depends, Term, Weights};
use super::formula::NodeView;
use super::plain::{add_costs, event_value};
use crate::model::element::Sum;
use crate::number::Real;
use crate::{Error, System};

impl System {
    pub(crate) fn costs(&self) -> &Costs {
        &self.0.costs
    }

    /// Whether any cost with a nonzero factor is evaluated before the last node.
    pub(crate) fn has_running_cost(&self, factors: &CostFactors) -> bool {
        factors.has_events() || factors.counting().any(|which| self.0.terms.running[which])
    }

    /// How each term of an output (0 for J) is summed, and its name.
    pub(crate) fn sums(&self, output: usize) -> impl Iterator<Item = (Sum, &str)> {
        self.0.costs.terms().filter(move |term| term.output == output).map(|term| (term.sum, term.name))
    }

    /// True if all terms of an output are evaluated at the end alone.
    pub(crate) fn is_terminal(&self, output: usize) -> bool {
        self.sums(1 + output).all(|(sum, _)| sum == Sum::Terminal)
    }

    /// True if all terms of an output are functions of q and v at this node alone, which is the last one of the motion if `is_last`.
    pub(crate) fn is_of_state(&self, output: usize, node: usize, is_last: bool) -> bool {
        let is_here = |sum| sum == Sum::Node(node) || is_last && sum == Sum::Terminal;
        let mut terms = self.0.costs.terms().filter(|term| term.output == 1 + output);
        terms.all(|term| is_here(term.sum) && term.uses.more_than_states() == Depends::Never)
    }

    /// The coordinates that the terms of an output (0 for J) are connected to.
    pub(crate) fn coordinates_of(&self, output: usize) -> Vec<usize> {
        let terms = self.0.costs.terms().filter(move |term| term.output == output);
        terms.flat_map(|term| term.to.q.iter().copied()).collect()
    }

    /// The name of an element or a cost that may depend explicitly on time.
    pub(crate) fn timed(&self) -> Option<&str> {
        let mut elements = self.0.formulas.elements.iter().filter(|element| element.formula.timed);
        let mut terms = self.0.costs.terms().filter(|term| term.uses.time() > Depends::Never);
        elements.next().map(|element| element.name.as_str()).or_else(|| terms.next().map(|term| term.name))
    }

    /// The name of a cost that depends on σ, p* or ṗ*, if there are constraints; costs that branch on values are not considered.
    pub(crate) fn cost_of_multipliers(&self) -> Option<&str> {
        let mut terms = self.0.costs.terms().filter(|term| self.0.m > 0 && term.uses.multipliers() == Depends::Always);
        terms.next().map(|term| term.name)
    }

    /// The names of the costs that may read multipliers of these equations, and the equations whose multipliers they read.
    pub(crate) fn costs_of_multipliers(&self, equations: &[usize]) -> (Vec<&str>, Vec<usize>) {
        let reads = |term: &Term, j: usize| term.uses.multipliers() > Depends::Never && term.to.sigma.contains(&j);
        let is_one = |term: &Term| equations.iter().any(|&j| reads(term, j));
        let costs = self.0.costs.terms().filter(is_one).map(|term| term.name).collect();
        let read = |j: &usize| self.0.costs.terms().any(|term| reads(&term, *j));
        (costs, equations.iter().copied().filter(read).collect())
    }

    /// The last single node at which a cost is evaluated, and the name of the cost.
    pub(crate) fn last_cost_node(&self) -> Option<(usize, &str)> {
        self.0.terms.last_node.as_ref().map(|(node, name)| (*node, name.as_str()))
    }

    /// # Errors
    /// A cost that reads an event which a motion with this number of events does not have.
    pub(crate) fn check_events(&self, events: usize) -> Result<(), Error> {
        let missing = |term: &Term| matches!(term.sum, Sum::Event(event) | Sum::AfterEvent(event) if event >= events);
        match self.0.terms.last_event.filter(|&last| last >= events).and_then(|_| self.0.costs.terms().find(missing)) {
            Some(Term { name, sum: Sum::Event(event) | Sum::AfterEvent(event), .. }) => {
                Err(Error::NoSuchEvent { term: name.into(), event, events })
            }
            _ => Ok(()),
        }
    }

    /// Whether any cost is summed with the weights of the scheme.
    pub(crate) fn has_integral(&self) -> bool {
        self.0.terms.integral
    }

    /// The order with which the sums of J approximate integrals; `None` if a term belongs to this grid alone.
    pub(crate) fn order_of_sums(&self) -> Option<usize> {
        let of = |sum: Sum| match sum {
            Sum::Integral | Sum::Terminal => Some(usize::MAX),
            Sum::Trapezoidal => Some(2),
            Sum::Rectangle => Some(1),
            Sum::Plain | Sum::AllNodes | Sum::Node(_) => None,
            Sum::Event(_) | Sum::AfterEvent(_) => Some(usize::MAX),
        };
        let terms = self.0.costs.terms().filter(|term| term.output == 0);
        terms.map(|term| of(term.sum)).try_fold(usize::MAX, |least, order| order.map(|order| least.min(order)))
    }

    /// Whether a cost with a factor is evaluated at this node alone ([`Sum::Node`](crate::Sum::Node)).
    pub(crate) fn has_reading(&self, node: usize, factors: &CostFactors) -> bool {
        self.0.costs.has_reading(node, factors)
    }

    /// Whether any cost may depend on rates of controls, which couple nodes.
    pub(crate) fn has_control_rates(&self) -> bool {
        self.0.terms.uses.control_rates() > Depends::Never
    }

    /// Adds all costs at one node, with their weights and factors, to J and to the outputs; outputs without a factor are skipped.
    pub(crate) fn add_costs<R: Real>(
        &self,
        at: &NodeView<R>,
        weights: &Weights<R>,
        factors: &CostFactors,
        add: &mut dyn FnMut(usize, R),
    ) {
        add_costs(&self.0.costs, (at, weights), factors, add);
    }

    /// The function of an event.
    pub(crate) fn event_value<R: Real>(&self, event: usize, at: &NodeView<R>) -> R {
        event_value(&self.0.costs, event, at)
    }

    /// Whether the function of an event may depend on v̇ or λ.
    pub(crate) fn event_reads_accelerations(&self, event: usize) -> bool {
        self.0.costs.of_event(event).is_some_and(|item| item.uses.accelerations() > Depends::Never)
    }

    /// Whether the costs that are summed with these weights depend on v̇ or λ.
    pub(crate) fn use_of_accelerations<R: Real>(&self, weights: &Weights<R>, factors: &CostFactors) -> Depends {
        if self.0.terms.uses.accelerations() == Depends::Never {
            return Depends::Never;
        }
        let has_value = |weight: R| (0..R::PARTS).any(|part| weight.part(part) != 0.0);
        let is_summed = |sum| weights.of(sum).is_some_and(|weight| has_value(weight) || sum.is_of_both_steps());
        self.0.costs.uses_here((weights.node(), weights.event()), &is_summed, factors).accelerations()
    }
}
