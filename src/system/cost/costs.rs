//! [`Costs`]: all costs of a scene, indexed by the nodes at which they are evaluated.

use std::any::TypeId;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use super::cost_factors::{CostFactors, EVENTS};
use super::cost_programs::CostPrograms;
use super::cost_use::{CostUse, Depends, Term};
use super::placed_cost::{PlacedCost, Recorded};
use super::rows::CostRows;
use super::weights::{Occurring, Weights};
use crate::Error;
use crate::model::Param;
use crate::model::element::Sum;
use crate::number::{Fingerprint, Real};
use crate::system::formula::{Argument, NodeView, Shape};

/// All costs of a scene.
#[derive(Clone, Default)]
pub struct Costs {
    items: Vec<PlacedCost>,
    /// Like costs: those with the same program, output and way of summing, which are evaluated side by side.
    batches: Vec<Vec<usize>>,
    /// Batches that may be evaluated at any node, sorted by output, so that only the requested outputs are visited.
    anywhere: Vec<(usize, usize)>,
    /// Batches that are evaluated at a single node, sorted by node and output, so that each node visits only its own, even if there are many.
    at_node: Vec<((usize, usize), usize)>,
    /// One cost for each of the different formulas that were recorded.
    recorded: Vec<usize>,
}

/// A key that is equal for costs with the same formula.
#[derive(PartialEq, Eq, Hash)]
enum Same {
    /// A type of which all values are equal.
    Type(TypeId, Shape),
    /// The address of a formula that they share.
    Formula(*const ()),
}

/// A formula that is not finite, and the arguments that cause it.
pub struct Suspect<'a> {
    pub element: &'a str,
    pub arguments: Vec<Argument>,
}

/// A state, and a direction along which changes are computed.
pub type Along<'a> = (&'a NodeView<'a, f64>, Option<&'a NodeView<'a, f64>>);

impl Costs {
    /// Adds a cost and returns its number.
    pub fn push(&mut self, item: PlacedCost) -> usize {
        self.items.push(item);
        self.items.len() - 1
    }

    #[cfg(feature = "files")]
    pub fn item(&self, which: usize) -> &PlacedCost {
        &self.items[which]
    }

    fn arrange(&mut self) {
        let mut known = HashMap::new();
        for (index, item) in self.items.iter().enumerate() {
            let next = self.batches.len();
            let like = item.formula.as_ref().map(|formula| (item.output, item.sum, Arc::as_ptr(formula)));
            let batch = like.map_or(next, |like| *known.entry(like).or_insert(next));
            if batch == next {
                self.batches.push(Vec::new());
                match item.sum {
                    Sum::Node(node) => self.at_node.push(((node, item.output), batch)),
                    _ => self.anywhere.push((item.output, batch)),
                }
            }
            self.batches[batch].push(index);
        }
        self.anywhere.sort_unstable();
        self.at_node.sort_unstable();
    }

    /// The number of batches of like costs.
    pub fn batches(&self) -> usize {
        self.batches.len()
    }

    /// The indices of the batches that may be evaluated at a given node (or between given nodes, for `None`) with these factors.
    fn here(&self, node: Option<usize>, factors: &CostFactors) -> impl Iterator<Item = usize> + '_ {
        let outputs = factors.some();
        let at_node = node.map_or(&[][..], |node| among(&self.at_node, (node, outputs.start)..(node, outputs.end)));
        let of_events = if factors.has_events() { among(&self.anywhere, EVENTS..usize::MAX) } else { &[] };
        let anywhere = among(&self.anywhere, outputs).iter().chain(of_events).map(|(_, index)| *index);
        anywhere.chain(at_node.iter().map(|(_, index)| *index))
    }

    /// Whether a cost with a factor is evaluated at this node alone.
    pub fn has_reading(&self, node: usize, factors: &CostFactors) -> bool {
        let Range { start, end } = factors.some();
        !among(&self.at_node, (node, start)..(node, end)).is_empty()
    }

    /// All costs.
    pub(in crate::system) fn items(&self) -> &[PlacedCost] {
        &self.items
    }

    /// The costs that may be evaluated at a given node (or between given nodes, for `None`) with these factors.
    pub(in crate::system) fn items_here(
        &self,
        node: Option<usize>,
        factors: &CostFactors,
    ) -> impl Iterator<Item = &PlacedCost> {
        self.here(node, factors).flat_map(|batch| &self.batches[batch]).map(|&index| &self.items[index])
    }

    /// Replaces the parameters of all costs by means of `resolve`.
    pub fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param) {
        self.items.iter_mut().flat_map(|item| &mut item.of.to.b).for_each(|b| *b = resolve(*b));
    }

    /// Records and sorts all costs, and compiles their programs unless programs are disabled.
    pub fn prepare(&mut self, at: &NodeView<f64>, without_programs: bool) {
        let mut known = (!without_programs).then(Recorded::default);
        self.items.iter_mut().for_each(|item| item.prepare(at, known.as_mut()));
        self.arrange();
        let mut known = HashSet::new();
        let recorded = self.items.iter().enumerate().filter(|(_, item)| item.of.depends.is_some());
        self.recorded = recorded.filter(|(_, item)| known.insert(same(item))).map(|(index, _)| index).collect();
    }

    /// # Errors
    /// The function of an event that depends on u̇.
    pub fn check_events(&self) -> Result<(), Error> {
        let reads = |item: &&PlacedCost| item.output >= EVENTS && item.uses.control_rates() == Depends::Always;
        let event = self.items.iter().find(reads).map(|item| item.of.name.clone());
        event.map_or(Ok(()), |event| Err(Error::EventArguments { event }))
    }

    /// The function of an event.
    pub(in crate::system) fn of_event(&self, event: usize) -> Option<&PlacedCost> {
        let which = EVENTS + event;
        let batch = among(&self.anywhere, which..which + 1).first().map(|(_, batch)| &self.batches[*batch])?;
        batch.first().map(|&index| &self.items[index])
    }

    /// Adds the formulas of all recorded costs to a fingerprint, each formula once.
    pub fn fingerprint(&self, sum: &mut Fingerprint) {
        self.recorded.iter().for_each(|&index| self.items[index].of.fingerprint(sum));
    }

    /// The first cost that depends on other arguments now than when it was compiled.
    pub fn find_changed(&self, at: &NodeView<f64>) -> Option<&str> {
        let depends = |item: &PlacedCost| item.of.record(at).map(|(template, _)| item.of.depends(&template)).ok();
        let mut changed = self.items.iter().filter(|item| item.of.depends.is_some() && depends(item) != item.of.depends);
        changed.next().map(|item| item.of.name.as_str())
    }

    /// Descriptions of all costs, without their formulas.
    pub fn terms(&self) -> impl Iterator<Item = Term<'_>> {
        self.items.iter().map(PlacedCost::term)
    }

    /// The quantities needed by the costs that are summed at a given node, or between given nodes.
    pub fn uses_here(
        &self,
        (node, event): (Option<usize>, Option<Occurring>),
        is_summed: &dyn Fn(Sum) -> bool,
        factors: &CostFactors,
    ) -> CostUse {
        let here = self.items_here(node, factors);
        let summed = here.filter(|item| factors.here(item.output, event) != 0.0 && is_summed(item.sum));
        summed.fold(CostUse::NONE, |uses, item| uses.and(item.uses))
    }

    /// Adds values and derivatives; with the weights of a direction, their changes along it.
    pub fn add<R: Real>(&self, programs: &mut CostPrograms, (at, along): Along, weights: &Weights<R>, rows: &mut CostRows) {
        let mut is_loaded = false;
        for which in self.here(weights.node(), &rows.factors) {
            let batch = &self.batches[which];
            let like = &self.items[batch[0]];
            let Some(weight) = like.weight(weights, &rows.factors) else { continue };
            if programs.prepare((which, batch), &self.items, at) || !is_loaded {
                programs.load(at, along);
                is_loaded = true;
            }
            let Some((program, point)) = programs.of(which) else {
                batch.iter().for_each(|&index| self.items[index].add((at, along), &weight, rows));
                continue;
            };
            let mut values = [0.0; 2];
            program.run(point, |(order, of), x| match of {
                None => values[*order] += x,
                Some((argument, factor)) => rows.add(*argument, weight.of[*order] * factor * x),
            });
            like.add_values(values, &weight, batch.len(), rows);
        }
    }

    /// The first cost whose value or derivatives, or whose changes along a direction, are not finite; `rows` is overwritten.
    pub fn find_not_finite<R: Real>(&self, of: Along, weights: &Weights<R>, rows: &mut CostRows) -> Option<Suspect<'_>> {
        let item = self.items.iter().find(|item| {
            rows.clear();
            item.weight(weights, &rows.factors).into_iter().for_each(|weight| item.add(of, &weight, rows));
            item.clear_others(of.0, rows);
            !rows.is_finite()
        })?;
        Some(Suspect { element: &item.of.name, arguments: item.to_blame(of.0).unwrap_or_else(|| rows.bad_arguments()) })
    }
}

/// The key of the formula of a cost.
fn same(PlacedCost { of, .. }: &PlacedCost) -> Same {
    let address = Same::Formula(Arc::as_ptr(&of.formula).cast());
    of.formula.only_value_of().map_or(address, |only| Same::Type(only, of.shape))
}

/// The items of a sorted list whose keys lie in a range.
fn among<K: Ord>(list: &[(K, usize)], keys: Range<K>) -> &[(K, usize)] {
    let first = list.partition_point(|(key, _)| *key < keys.start);
    let rest = &list[first..];
    &rest[..rest.partition_point(|(key, _)| *key < keys.end)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scalar;
    use crate::model::element::{ListCost, ListPoint};
    use crate::system::{Connections, CostOfLists};

    struct Nothing;
    impl ListCost for Nothing {
        fn cost<S: Scalar>(&self, _: &ListPoint<S>) -> S {
            S::zero()
        }
    }

    fn arranged(sums: &[(Sum, usize)]) -> Costs {
        let mut costs = Costs::default();
        for &(sum, output) in sums {
            costs.push(PlacedCost::new(("of a node", output), (Nothing, sum), Connections::default()));
        }
        costs.arrange();
        costs
    }

    #[test]
    fn a_node_looks_at_its_own_readings_and_at_what_counts_anywhere() {
        let sums = [Sum::Node(7), Sum::Node(3), Sum::Integral, Sum::Node(900), Sum::Node(3), Sum::Terminal];
        let costs = arranged(&sums.map(|sum| (sum, 0)));
        let here = |node| costs.here(node, &CostFactors::of_cost(0)).collect::<Vec<usize>>();
        assert_eq!([Some(0), Some(900), Some(901), None].map(here), [vec![2, 5], vec![2, 5, 3], vec![2, 5], vec![2, 5]]);
        assert_eq!((here(Some(3)), here(Some(7))), (vec![2, 5, 1, 4], vec![2, 5, 0]));
    }

    #[test]
    fn like_costs_are_evaluated_side_by_side_if_they_are_summed_alike() {
        let sums = [(Sum::Node(3), 0), (Sum::Integral, 0), (Sum::Node(3), 0), (Sum::Integral, 1), (Sum::Integral, 0)];
        let batches = |without_programs| {
            let mut costs = Costs::default();
            for (sum, output) in sums {
                costs.push(PlacedCost::new(("", output), (Nothing, sum), Connections::default()));
            }
            costs.prepare(&NodeView::of_equations([&[]; 3], (&[], 0.0, &[])), without_programs);
            costs.batches
        };
        assert_eq!(batches(false), [vec![0, 2], vec![1, 4], vec![3]]);
        assert_eq!(batches(true), [[0], [1], [2], [3], [4]]);
    }

    struct Number(f64);
    impl ListCost for Number {
        fn cost<S: Scalar>(&self, _: &ListPoint<S>) -> S {
            S::from(self.0)
        }
    }

    #[test]
    fn formulas_are_recorded_again_once_for_all_places_where_they_are() {
        let (mut costs, shape) = (Costs::default(), Connections::default().shape());
        let shared = CostOfLists::shared(Number(1.0), shape);
        for node in 0..3 {
            let sum = Sum::Node(node);
            costs.push(PlacedCost::new(("without fields", node), (Nothing, sum), Connections::default()));
            costs.push(PlacedCost::new(("with a field", node), (Number(node as f64), sum), Connections::default()));
            costs.push(PlacedCost::of(("shared", node, sum), shared.clone(), Connections::default()));
        }
        costs.prepare(&NodeView::of_equations([&[]; 3], (&[], 0.0, &[])), false);
        assert_eq!(costs.recorded, [0, 1, 2, 4, 7]);
    }

    #[test]
    fn of_many_outputs_those_are_looked_at_that_are_asked_for() {
        let costs =
            arranged(&[2, 0, 1, 2, 0, 1].map(|output| (if output == 1 { Sum::Node(4) } else { Sum::Integral }, output)));
        let here = |which| costs.here(Some(4), &CostFactors::of_one(which, 3)).collect::<Vec<usize>>();
        assert_eq!([0, 1, 2, 3].map(here), [vec![1, 4], vec![2, 5], vec![0, 3], vec![]]);
        let mut factors = CostFactors::of_outputs(2);
        let of = |factors: &CostFactors| costs.here(Some(4), factors).collect::<Vec<usize>>();
        let outputs = of(&factors);
        factors.weigh(1.0, &[1.0; 2]);
        assert_eq!((outputs, of(&factors)), (vec![0, 3, 2, 5], vec![1, 4, 0, 3, 2, 5]));
    }
}
