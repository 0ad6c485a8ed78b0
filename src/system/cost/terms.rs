//! [`Terms`]: how the terms of J and the outputs are summed, and what any of them needs of a node.

use super::cost_factors::EVENTS;
use super::cost_use::{CostUse, Term};
use super::costs::Costs;
use crate::model::element::Sum;

/// Properties of all costs together.
pub struct Terms {
    /// Whether J (first) and each output have a term before the last node.
    pub(in crate::system) running: Vec<bool>,
    /// Whether any cost is summed with the weights of the scheme.
    pub(in crate::system) integral: bool,
    /// The last single node at which a cost is evaluated, and the name of the cost.
    pub(in crate::system) last_node: Option<(usize, String)>,
    /// The last event at which a cost is evaluated.
    pub(in crate::system) last_event: Option<usize>,
    /// The quantities that any of the costs needs.
    pub(in crate::system) uses: CostUse,
}

impl Terms {
    pub fn new(costs: &Costs, outputs: usize) -> Self {
        let all: Vec<Term> = costs.terms().collect();
        let mut running = vec![false; 1 + outputs];
        let before_the_end = all.iter().filter(|term| term.sum != Sum::Terminal && term.output < EVENTS);
        before_the_end.for_each(|term| running[term.output] = true);
        let single =
            all.iter().filter_map(|term| if let Sum::Node(node) = term.sum { Some((node, term.name)) } else { None });
        let last_node = single.max_by_key(|(node, _)| *node).map(|(node, name)| (node, name.to_string()));
        let of_event = |term: &Term| match term.sum {
            Sum::Event(event) | Sum::AfterEvent(event) => Some(event),
            _ => None,
        };
        let last_event = all.iter().filter_map(of_event).max();
        let integral = all.iter().any(|term| term.sum == Sum::Integral);
        let uses = all.iter().fold(CostUse::NONE, |uses, term| uses.and(term.uses));
        Terms { running, integral, last_node, last_event, uses }
    }
}
