//! [`Costs`]: all costs of one type, and which of them count at a node.

use num_dual::Dual64;
use std::any::Any;
use std::ops::Range;

use super::blame::Suspect;
use super::cost::{AnyCosts, CostRows, PlainCosts};
use super::cost_factors::CostFactors;
use super::cost_formula::{CostFormula, CostMemory};
use super::cost_second_order::CostSecondOrder;
use super::placed_cost::PlacedCost;
use super::terms::{CostUse, Term};
use super::view::NodeView;
use super::weights::Weights;
use crate::model::Param;
use crate::model::element::{ListCost, Sum};
use crate::number::{Fingerprint, Real};

/// All costs of one type.
pub struct Costs<C> {
    items: Vec<PlacedCost<C>>,
    /// Those that may count anywhere, by the output that they belong to: of many outputs, only those need to be looked at that are asked for.
    anywhere: Vec<(usize, usize)>,
    /// Those that count at a single node, by that node and their output: with a reading at each of many, nodes need not look at all.
    at_node: Vec<((usize, usize), usize)>,
}

impl<C> Default for Costs<C> {
    fn default() -> Self {
        Costs { items: Vec::new(), anywhere: Vec::new(), at_node: Vec::new() }
    }
}

impl<C: ListCost> Costs<C> {
    pub fn push(&mut self, item: PlacedCost<C>) {
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

    /// The costs that may count at a given node, or between given nodes, for some of the outputs, by their numbers.
    fn here(&self, node: Option<usize>, outputs: Range<usize>) -> impl Iterator<Item = usize> + '_ {
        let at_node = node.map_or(&[][..], |node| among(&self.at_node, (node, outputs.start)..(node, outputs.end)));
        let anywhere = among(&self.anywhere, outputs).iter().map(|(_, index)| *index);
        anywhere.chain(at_node.iter().map(|(_, index)| *index))
    }
}

/// Those of a sorted list whose keys are in a range.
fn among<K: Ord>(list: &[(K, usize)], keys: Range<K>) -> &[(K, usize)] {
    let first = list.partition_point(|(key, _)| *key < keys.start);
    let rest = &list[first..];
    &rest[..rest.partition_point(|(key, _)| *key < keys.end)]
}

impl<C: ListCost, R: Real> PlainCosts<R> for Costs<C> {
    fn add(&self, at: &NodeView<R>, weights: &Weights<R>, factors: &CostFactors, add: &mut dyn FnMut(usize, R)) {
        for item in self.here(weights.node(), factors.some()).map(|index| &self.items[index]) {
            let factor = factors.of(item.output);
            let Some(weight) = weights.of(item.sum).filter(|_| factor != 0.0) else { continue };
            if (0..R::PARTS).any(|part| weight.part(part) != 0.0) {
                add(item.output, item.value(at) * weight * factor);
            }
        }
    }
}

impl<C: ListCost> AnyCosts for Costs<C> {
    fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param) {
        self.items.iter_mut().flat_map(|item| &mut item.b).for_each(|b| *b = resolve(*b));
    }

    fn prepare(&mut self, at: &NodeView<f64>, without_programs: bool, fixed: &mut usize) {
        self.arrange();
        for item in &mut self.items {
            let recorded = item.record(at);
            item.uses = item.find_uses(recorded.as_ref().ok().map(|(template, _)| template));
            if !without_programs {
                let bound = Param::which_are_bound(&item.b);
                let formula = recorded.and_then(|recorded| CostFormula::new(recorded, item.shape.len(), &bound, *fixed));
                (item.obstacle, item.formula) = (formula.as_ref().err().copied(), formula.ok());
                *fixed = item.formula.as_ref().map_or(*fixed, CostFormula::end);
            }
        }
    }

    fn fix(&self, at: &NodeView<f64>, changed: bool, memory: &mut CostMemory) -> usize {
        let programs = self.items.iter().filter_map(|item| Some((item, item.formula.as_ref()?)));
        let broken = programs.filter(|(item, formula)| {
            let now = changed.then(|| item.record(at).ok()).flatten();
            let constants: Vec<f64> = item.b.iter().map(|b| b.value(at.design)).collect();
            changed && now.is_none() || !formula.fix(&constants, now.as_ref(), memory)
        });
        broken.count()
    }

    fn fingerprint(&self, sum: &mut Fingerprint) {
        self.items.iter().for_each(|item| item.fingerprint(sum));
    }

    fn find_changed(&self, at: &NodeView<f64>) -> Option<&str> {
        let programs = self.items.iter().filter_map(|item| Some((item, item.formula.as_ref()?)));
        let depends = |item: &PlacedCost<C>| item.record(at).map(|(template, _)| template.depends(item.shape.len()));
        let mut changed = programs.filter(|(item, formula)| depends(item).as_ref() != Ok(&formula.depends));
        changed.next().map(|(item, _)| item.name.as_str())
    }

    fn terms(&self) -> Vec<Term<'_>> {
        self.items.iter().map(PlacedCost::term).collect()
    }

    fn uses_here(&self, node: Option<usize>, is_summed: &dyn Fn(Sum) -> bool, factors: &CostFactors) -> CostUse {
        let here = self.here(node, factors.some()).map(|index| &self.items[index]);
        let summed = here.filter(|item| factors.of(item.output) != 0.0 && is_summed(item.sum));
        summed.fold(CostUse::NONE, |uses, item| uses.and(item.uses))
    }

    fn gradient(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) {
        let here = self.here(weights.node(), rows.factors.some());
        here.for_each(|index| self.items[index].gradient(at, weights, rows));
    }

    fn second_order(&self, at: &NodeView<f64>) -> Vec<Option<CostSecondOrder>> {
        let of = |item: &PlacedCost<C>| {
            item.formula.as_ref()?;
            let bound = Param::which_are_bound(&item.b);
            CostSecondOrder::new(item.record(at).ok()?, item.shape.len(), &bound)
        };
        self.items.iter().map(of).collect()
    }

    fn fix_second_order(&self, design: &[f64], programs: &mut [Option<CostSecondOrder>]) {
        for (item, program) in self.items.iter().zip(programs) {
            program.iter_mut().for_each(|program| program.fix(item.b.iter().map(|b| b.value(design))));
        }
    }

    fn gradient_along(
        &self,
        programs: &mut [Option<CostSecondOrder>],
        at: (&NodeView<f64>, &NodeView<f64>),
        weights: &Weights<Dual64>,
        rows: &mut CostRows,
    ) {
        let here = self.here(weights.node(), rows.factors.some());
        here.for_each(|index| self.items[index].gradient_along(&mut programs[index], at, weights, rows));
    }

    fn find_not_finite(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) -> Option<Suspect<'_>> {
        let item = self.items.iter().find(|item| {
            rows.clear();
            item.gradient(at, weights, rows);
            item.clear_others(at, rows);
            !rows.is_finite()
        })?;
        Some(Suspect { element: &item.name, arguments: item.to_blame(at).unwrap_or_else(|| rows.bad_arguments()) })
    }

    fn find_not_finite_along(
        &self,
        programs: &mut [Option<CostSecondOrder>],
        at: (&NodeView<f64>, &NodeView<f64>),
        weights: &Weights<Dual64>,
        rows: &mut CostRows,
    ) -> Option<Suspect<'_>> {
        let costs = self.items.iter().zip(programs).map(|(item, program)| (item.name.as_str(), (item, program)));
        Suspect::first(costs, rows, |(item, program), rows| {
            item.gradient_along(program, at, weights, rows);
            item.clear_others(at.0, rows);
        })
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scalar;
    use crate::model::element::ListPoint;
    use crate::system::CostShape;

    struct Nothing;
    impl ListCost for Nothing {
        fn cost<S: Scalar>(&self, _: &ListPoint<S>) -> S {
            S::zero()
        }
    }

    fn arranged(sums: &[(Sum, usize)]) -> Costs<Nothing> {
        let mut costs = Costs::default();
        for &(sum, output) in sums {
            costs.push(PlacedCost::new(("of a node", output), (Nothing, sum), CostShape::new(&[], &[], &[]), Vec::new()));
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
