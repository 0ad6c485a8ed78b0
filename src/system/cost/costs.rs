//! [`Costs`]: all costs of a scene, indexed by the nodes at which they are evaluated.

use num_dual::Dual64;
use std::ops::Range;

use super::cost_factors::CostFactors;
use super::cost_formula::CostMemory;
use super::cost_program::CostPrograms;
use super::cost_second_order::CostSecondOrder;
use super::cost_use::{CostUse, Term};
use super::placed_cost::PlacedCost;
use super::rows::CostRows;
use super::suspect::Suspect;
use super::weights::Weights;
use crate::model::Param;
use crate::model::element::Sum;
use crate::number::Fingerprint;
use crate::system::formula::NodeView;

/// All costs of a scene.
#[derive(Clone, Default)]
pub struct Costs {
    items: Vec<PlacedCost>,
    /// Costs that may be evaluated at any node, sorted by output, so that only the requested outputs are visited.
    anywhere: Vec<(usize, usize)>,
    /// Costs that are evaluated at a single node, sorted by node and output, so that each node visits only its own, even if there are many.
    at_node: Vec<((usize, usize), usize)>,
}

impl Costs {
    pub fn push(&mut self, item: PlacedCost) {
        self.items.push(item);
    }

    fn arrange(&mut self) {
        for (index, item) in self.items.iter().enumerate() {
            match item.sum {
                Sum::Node(node) => self.at_node.push(((node, item.output), index)),
                _ => self.anywhere.push((item.output, index)),
            }
        }
        self.anywhere.sort_unstable();
        self.at_node.sort_unstable();
    }

    /// The indices of the costs that may be evaluated at a given node (or between given nodes, for `None`) for some of the outputs.
    fn here(&self, node: Option<usize>, outputs: Range<usize>) -> impl Iterator<Item = usize> + '_ {
        let at_node = node.map_or(&[][..], |node| among(&self.at_node, (node, outputs.start)..(node, outputs.end)));
        let anywhere = among(&self.anywhere, outputs).iter().map(|(_, index)| *index);
        anywhere.chain(at_node.iter().map(|(_, index)| *index))
    }

    /// All costs.
    pub(in crate::system) fn items(&self) -> &[PlacedCost] {
        &self.items
    }

    /// The costs that may be evaluated at a given node (or between given nodes, for `None`) for some of the outputs.
    pub(in crate::system) fn items_here(
        &self,
        node: Option<usize>,
        outputs: Range<usize>,
    ) -> impl Iterator<Item = &PlacedCost> {
        self.here(node, outputs).map(|index| &self.items[index])
    }

    /// Replaces the parameters of all costs by means of `resolve`.
    pub fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param) {
        self.items.iter_mut().flat_map(|item| &mut item.of.to.b).for_each(|b| *b = resolve(*b));
    }

    /// Sorts and records all costs, and compiles their programs unless programs are disabled.
    pub fn prepare(&mut self, at: &NodeView<f64>, without_programs: bool) {
        self.arrange();
        let mut programs = (!without_programs).then(CostPrograms::default);
        self.items.iter_mut().fold(0, |offset, item| item.prepare(at, programs.as_mut(), offset));
    }

    /// Sets the design variables and, if formulas have `changed`, records them again. Returns whether the programs of all costs still apply.
    pub fn fix(&self, at: &NodeView<f64>, changed: bool, memory: &mut CostMemory) -> bool {
        let programs = self.items.iter().filter_map(|item| Some((item, item.formula.as_ref()?)));
        let broken = programs.filter(|(item, formula)| {
            let now = changed.then(|| item.of.record(at).ok()).flatten();
            let constants: Vec<f64> = item.of.to.constants(at.design).collect();
            changed && now.is_none() || !formula.fix(&constants, now.as_ref(), memory)
        });
        // Visits all costs, even after one whose program fails, so that the others receive their constants.
        broken.count() == 0
    }

    /// Adds the formulas of all recorded costs to a fingerprint.
    pub fn fingerprint(&self, sum: &mut Fingerprint) {
        self.items.iter().for_each(|item| item.of.fingerprint(sum));
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
    pub fn uses_here(&self, node: Option<usize>, is_summed: &dyn Fn(Sum) -> bool, factors: &CostFactors) -> CostUse {
        let here = self.items_here(node, factors.some());
        let summed = here.filter(|item| factors.of(item.output) != 0.0 && is_summed(item.sum));
        summed.fold(CostUse::NONE, |uses, item| uses.and(item.uses))
    }

    /// Adds values and derivatives.
    pub fn gradient(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) {
        self.items_here(weights.node(), rows.factors.some()).for_each(|item| item.gradient(at, weights, rows));
    }

    /// The programs for second derivatives of all costs that can be recorded.
    pub fn second_order(&self, at: &NodeView<f64>) -> Vec<Option<CostSecondOrder>> {
        self.items.iter().map(|item| item.second_order(at)).collect()
    }

    /// Sets the design variables in these programs.
    pub fn fix_second_order(&self, design: &[f64], programs: &mut [Option<CostSecondOrder>]) {
        for (item, program) in self.items.iter().zip(programs) {
            program.iter_mut().for_each(|program| program.fix(item.of.to.constants(design)));
        }
    }

    /// Adds the changes of values and derivatives along a direction of the arguments and of the weights, by means of these programs.
    pub fn gradient_along(
        &self,
        programs: &mut [Option<CostSecondOrder>],
        at: (&NodeView<f64>, &NodeView<f64>),
        weights: &Weights<Dual64>,
        rows: &mut CostRows,
    ) {
        let here = self.here(weights.node(), rows.factors.some());
        here.for_each(|index| self.items[index].gradient_along(&mut programs[index], at, weights, rows));
    }

    /// The first cost whose value or derivatives are not finite; `rows` is overwritten.
    pub fn find_not_finite(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) -> Option<Suspect<'_>> {
        let item = self.items.iter().find(|item| {
            rows.clear();
            item.gradient(at, weights, rows);
            item.clear_others(at, rows);
            !rows.is_finite()
        })?;
        Some(Suspect { element: &item.of.name, arguments: item.to_blame(at).unwrap_or_else(|| rows.bad_arguments()) })
    }

    /// The first cost whose derivatives along a direction are not finite; `rows` is overwritten.
    pub fn find_not_finite_along(
        &self,
        programs: &mut [Option<CostSecondOrder>],
        at: (&NodeView<f64>, &NodeView<f64>),
        weights: &Weights<Dual64>,
        rows: &mut CostRows,
    ) -> Option<Suspect<'_>> {
        let costs = self.items.iter().zip(programs).map(|(item, program)| (item.of.name.as_str(), (item, program)));
        Suspect::first(costs, rows, |(item, program), rows| {
            item.gradient_along(program, at, weights, rows);
            item.clear_others(at.0, rows);
        })
    }
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
    use crate::system::Connections;

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
        let here = |node| costs.here(node, 0..1).collect::<Vec<usize>>();
        assert_eq!([Some(0), Some(900), Some(901), None].map(here), [vec![2, 5], vec![2, 5, 3], vec![2, 5], vec![2, 5]]);
        assert_eq!((here(Some(3)), here(Some(7))), (vec![2, 5, 1, 4], vec![2, 5, 0]));
    }

    #[test]
    fn of_many_outputs_those_are_looked_at_that_are_asked_for() {
        let costs =
            arranged(&[2, 0, 1, 2, 0, 1].map(|output| (if output == 1 { Sum::Node(4) } else { Sum::Integral }, output)));
        let here = |outputs| costs.here(Some(4), outputs).collect::<Vec<usize>>();
        assert_eq!([0..1, 1..2, 2..3, 3..4].map(here), [vec![1, 4], vec![2, 5], vec![0, 3], vec![]]);
        assert_eq!((here(1..3), here(0..3)), (vec![0, 3, 2, 5], vec![1, 4, 0, 3, 2, 5]));
    }
}
