//! [`Terms`]: the terms that J and the outputs are sums of, how each is summed, and which quantities of a node it needs.

use super::System;
use super::connections::Connections;
use super::cost_factors::CostFactors;
use super::costs::Costs;
use super::plain::add_costs;
use super::shape::Slot;
use super::view::NodeView;
use super::weights::Weights;
use crate::model::element::Sum;
use crate::number::Real;
use crate::program::Obstacle;

/// Description of a cost without its formula.
pub struct Term<'a> {
    pub name: &'a str,
    /// 0 for J, or 1 + the number of the output.
    pub output: usize,
    pub sum: Sum,
    pub uses: CostUse,
    pub has_program: bool,
    /// The reason why the cost has no program, unless programs were disabled.
    pub obstacle: Option<Obstacle>,
    pub to: &'a Connections,
}

/// Properties of all costs together.
#[derive(Clone)]
pub struct Terms {
    /// Whether J (first) and each output have a term before the last node.
    running: Vec<bool>,
    /// Whether any cost is summed with the weights of the scheme.
    integral: bool,
    /// The last single node at which a cost is evaluated, and the name of the cost.
    last_node: Option<(usize, String)>,
    /// The quantities that any of the costs needs.
    uses: CostUse,
}

impl Terms {
    pub fn new(costs: &Costs, outputs: usize) -> Self {
        let all: Vec<Term> = costs.terms().collect();
        let mut running = vec![false; 1 + outputs];
        all.iter().filter(|term| term.sum != Sum::Terminal).for_each(|term| running[term.output] = true);
        let single =
            all.iter().filter_map(|term| if let Sum::Node(node) = term.sum { Some((node, term.name)) } else { None });
        let last_node = single.max_by_key(|(node, _)| *node).map(|(node, name)| (node, name.to_string()));
        let integral = all.iter().any(|term| term.sum == Sum::Integral);
        let uses = all.iter().fold(CostUse::NONE, |uses, term| uses.and(term.uses));
        Terms { running, integral, last_node, uses }
    }
}

/// Whether a cost depends on a quantity; `Perhaps` if its formula cannot be recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Depends {
    Never,
    Perhaps,
    Always,
}

/// Quantities of a node, other than y and u, that costs need.
#[derive(Clone, Copy, Debug)]
pub struct CostUse {
    /// v̇ or λ.
    pub accelerations: Depends,
    /// u̇.
    pub control_rates: Depends,
    /// t.
    pub time: Depends,
    /// σ, or p* or ṗ*, which contain it.
    pub multipliers: Depends,
}

impl CostUse {
    pub const NONE: Self = CostUse::all(Depends::Never);
    pub const UNKNOWN: Self = CostUse::all(Depends::Perhaps);

    const fn all(depends: Depends) -> Self {
        CostUse { accelerations: depends, control_rates: depends, time: depends, multipliers: depends }
    }

    /// The quantities needed by a cost that depends on these arguments.
    pub fn of(arguments: impl Iterator<Item = Slot>) -> Self {
        arguments.fold(CostUse::NONE, |uses, of| match of {
            Slot::VDot(_) | Slot::Lambda(_) => CostUse { accelerations: Depends::Always, ..uses },
            Slot::UDot(_) => CostUse { control_rates: Depends::Always, ..uses },
            Slot::T => CostUse { time: Depends::Always, ..uses },
            Slot::Sigma(_) | Slot::PStar(_) | Slot::PStarDot(_) => CostUse { multipliers: Depends::Always, ..uses },
            _ => uses,
        })
    }

    /// The quantities needed by either of two costs.
    pub fn and(self, other: CostUse) -> Self {
        CostUse {
            accelerations: self.accelerations.max(other.accelerations),
            control_rates: self.control_rates.max(other.control_rates),
            time: self.time.max(other.time),
            multipliers: self.multipliers.max(other.multipliers),
        }
    }
}

impl System {
    pub(crate) fn costs(&self) -> &Costs {
        &self.costs
    }

    /// Whether any cost with a nonzero factor is evaluated before the last node.
    pub(crate) fn has_running_cost(&self, factors: &CostFactors) -> bool {
        factors.counting().any(|which| self.terms.running[which])
    }

    /// How each term of an output (0 for J) is summed, and its name.
    pub(crate) fn sums(&self, output: usize) -> impl Iterator<Item = (Sum, &str)> {
        self.costs.terms().filter(move |term| term.output == output).map(|term| (term.sum, term.name))
    }

    /// The name of an element or a cost that may depend explicitly on time.
    pub(crate) fn timed(&self) -> Option<&str> {
        let mut elements = self.formulas.elements.iter().filter(|element| element.formula.timed);
        let mut terms = self.costs.terms().filter(|term| term.uses.time > Depends::Never);
        elements.next().map(|element| element.name.as_str()).or_else(|| terms.next().map(|term| term.name))
    }

    /// The name of a cost that depends on σ, p* or ṗ*, if there are constraints; costs that branch on values are not considered.
    pub(crate) fn cost_of_multipliers(&self) -> Option<&str> {
        let mut terms = self.costs.terms().filter(|term| self.m > 0 && term.uses.multipliers == Depends::Always);
        terms.next().map(|term| term.name)
    }

    /// The names of the costs that may read multipliers of these equations, and the equations whose multipliers they read.
    pub(crate) fn costs_of_multipliers(&self, equations: &[usize]) -> (Vec<&str>, Vec<usize>) {
        let reads = |term: &Term, j: usize| term.uses.multipliers > Depends::Never && term.to.sigma.contains(&j);
        let is_one = |term: &Term| equations.iter().any(|&j| reads(term, j));
        let costs = self.costs.terms().filter(is_one).map(|term| term.name).collect();
        let read = |j: &usize| self.costs.terms().any(|term| reads(&term, *j));
        (costs, equations.iter().copied().filter(read).collect())
    }

    /// The last single node at which a cost is evaluated, and the name of the cost.
    pub(crate) fn last_cost_node(&self) -> Option<(usize, &str)> {
        self.terms.last_node.as_ref().map(|(node, name)| (*node, name.as_str()))
    }

    /// Whether any cost is summed with the weights of the scheme.
    pub(crate) fn has_integral(&self) -> bool {
        self.terms.integral
    }

    /// Whether any cost may depend on rates of controls, which couple nodes.
    pub(crate) fn has_control_rates(&self) -> bool {
        self.terms.uses.control_rates > Depends::Never
    }

    /// Adds all costs at one node, with their weights and factors, to J and to the outputs; outputs without a factor are skipped.
    pub(crate) fn add_costs<R: Real>(
        &self,
        at: &NodeView<R>,
        weights: &Weights<R>,
        factors: &CostFactors,
        add: &mut dyn FnMut(usize, R),
    ) {
        add_costs(&self.costs, (at, weights), factors, add);
    }

    /// Whether the costs that are summed with these weights depend on v̇ or λ.
    pub(crate) fn use_of_accelerations<R: Real>(&self, weights: &Weights<R>, factors: &CostFactors) -> Depends {
        if self.terms.uses.accelerations == Depends::Never {
            return Depends::Never;
        }
        let has_value = |weight: R| (0..R::PARTS).any(|part| weight.part(part) != 0.0);
        let is_summed = |sum| weights.of(sum).is_some_and(|weight| has_value(weight) || sum.is_of_both_steps());
        self.costs.uses_here(weights.node(), &is_summed, factors).accelerations
    }
}
