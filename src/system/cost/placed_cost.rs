//! [`PlacedCost`]: one cost, its program, and its value and derivatives at a node.

use std::collections::HashMap;
use std::sync::Arc;

use super::cost_factors::CostFactors;
use super::cost_programs::CostFormula;
use super::cost_use::{CostUse, Term};
use super::rows::CostRows;
use super::weights::{Beside, Weights, slopes};
use crate::model::element::{ListCost, Sum};
use crate::number::{Real, Slope, slope, with_slope};
use crate::program::{Obstacle, Template};
#[cfg(feature = "files")]
use crate::system::formula::GraphFormula;
use crate::system::formula::{
    AnyCost, Argument, Connections, CostOfLists, NodeView, Number, Placed, SEEDS, Shape, Slot, Values, Wide,
};

/// A cost and the arguments it is connected to.
#[derive(Clone)]
pub struct PlacedCost {
    pub of: Placed<dyn AnyCost>,
    /// 0 for J, 1 + the number of the output, or [`EVENTS`](super::cost_factors::EVENTS) + the number of the function of an event.
    pub(in crate::system) output: usize,
    pub(in crate::system) sum: Sum,
    /// The derivatives of its weight with respect to the lengths of the steps before and after a node, for each [`Beside`].
    by_lengths: [[f64; 2]; 3],
    /// The program, and the numbers in the formula.
    pub(in crate::system) formula: Option<Arc<CostFormula>>,
    pub(in crate::system) numbers: Vec<f64>,
    /// Why there is no program; `None` if there is one or none was requested.
    pub(in crate::system) obstacle: Option<Obstacle>,
    pub(in crate::system) uses: CostUse,
}

/// The weight of a cost h in the sum of a node.
pub(in crate::system) struct Weight {
    /// The factors of h and of its change.
    pub of: [f64; 2],
    factor: f64,
    /// 0 for the sum itself, 1 for its change along a direction.
    order: usize,
    side: Beside,
}

/// The compiled formulas by shape, variables of the derivatives and recording; `None` if a program is too long.
pub(in crate::system) type Recorded = HashMap<(Shape, Vec<Slot>, Template), Option<Arc<CostFormula>>>;

impl PlacedCost {
    pub fn new((name, output): (&str, usize), (cost, sum): (impl ListCost, Sum), to: Connections) -> Self {
        let shape = to.shape();
        Self::of((name, output, sum), CostOfLists::shared(cost, shape), to)
    }

    /// A cost whose formula is a graph.
    #[cfg(feature = "files")]
    pub fn of_formula(what: (&str, usize, Sum), formula: Arc<GraphFormula>, to: Connections) -> Self {
        let mut cost = Self::of(what, formula, to);
        cost.of.is_graph = true;
        cost
    }

    /// A cost whose formula others may share.
    pub fn of((name, output, sum): (&str, usize, Sum), formula: Arc<dyn AnyCost>, to: Connections) -> Self {
        let shape = to.shape();
        let (name, slots) = (name.to_string(), shape.of_cost().collect());
        let of = Placed { name, formula, shape, to, slots, depends: None, is_graph: false };
        let by_lengths = [Beside::Both, Beside::Before, Beside::After].map(|side| slopes(sum, side));
        let (formula, numbers, obstacle, uses) = (None, Vec::new(), None, CostUse::UNKNOWN);
        PlacedCost { of, output, sum, by_lengths, formula, numbers, obstacle, uses }
    }

    /// The number of what it is summed to, and how it is summed.
    #[cfg(feature = "files")]
    pub fn summed(&self) -> (usize, Sum) {
        (self.output, self.sum)
    }

    /// Records the formula, and compiles it unless there are to be no programs or `known` contains it.
    pub(in crate::system) fn prepare(&mut self, at: &NodeView<f64>, known: Option<&mut Recorded>) {
        let recorded = self.of.record(at);
        self.of.depends = recorded.as_ref().ok().map(|(template, _)| self.of.depends(template));
        self.obstacle = recorded.as_ref().err().copied();
        if let Some(depends) = &self.of.depends {
            self.uses =
                CostUse::of(self.of.slots.iter().zip(depends).filter(|(_, depends)| **depends).map(|(slot, _)| *slot));
        }
        if let (Some(known), Ok((template, numbers))) = (known, recorded) {
            let formula =
                known.entry((self.of.shape, self.of.variables(self.of.depends.as_deref().unwrap_or_default()), template));
            let formula = formula.or_insert_with_key(|recorded| CostFormula::new(recorded.clone()).map(Arc::new));
            (self.formula, self.numbers) = (formula.clone(), numbers);
            self.obstacle = self.formula.is_none().then_some(Obstacle::IsTooLong);
        }
    }

    /// The arguments that cause the value not to be finite; `None` if it is finite.
    pub(in crate::system) fn to_blame(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        self.of.to_blame(at, |read| {
            let mut is_finite = true;
            Values::<f64>::values(&*self.of.formula, read, &mut |value| is_finite = value.is_finite());
            is_finite
        })
    }

    /// Clears derivatives by arguments that the cost does not depend on there, if others are not finite: dual numbers make 0 · NaN of them.
    pub(in crate::system) fn clear_others(&self, at: &NodeView<f64>, rows: &mut CostRows) {
        let Some((template, _)) = self.of.record_branch(at) else { return };
        let all = rows.clone();
        let others = self.of.slots.iter().zip(self.of.depends(&template)).filter(|(_, depends)| !depends);
        others.for_each(|(slot, _)| *rows.of(self.of.to.argument(*slot).0) = 0.0);
        if rows.is_finite() {
            *rows = all;
        }
    }

    /// Description of the cost without its formula.
    pub(in crate::system) fn term(&self) -> Term<'_> {
        let PlacedCost { of, output, sum, uses, obstacle, formula, .. } = self;
        let has_program = formula.is_some();
        Term { name: &of.name, output: *output, sum: *sum, uses: *uses, has_program, obstacle: *obstacle, to: &of.to }
    }

    /// The weight of the cost at a node or stage: the factors of the highest part of weight × value. `None` if it is not summed there.
    pub(in crate::system) fn weight<R: Real>(&self, weights: &Weights<R>, factors: &CostFactors) -> Option<Weight> {
        let factor = factors.here(self.output, weights.event());
        // For adjacent steps of opposite direction the weight may vanish although its derivatives do not.
        let is_summed = |weight: &R| (0..R::PARTS).any(|part| weight.part(part) != 0.0) || self.sum.is_of_both_steps();
        let weight = weights.of(self.sum).filter(is_summed).filter(|_| factor != 0.0)?;
        let order = R::PARTS - 1;
        let of = std::array::from_fn(|part| if part > order { 0.0 } else { factor * weight.part(order - part) });
        Some(Weight { of, factor, order, side: weights.side })
    }

    /// Adds the sums of h and of its change over `count` like costs, and the derivatives with respect to the lengths of steps on which the weight depends.
    pub(in crate::system) fn add_values(&self, values: [f64; 2], weight: &Weight, count: usize, rows: &mut CostRows) {
        rows.value += weight.of[0] * values[0] + weight.of[1] * values[1];
        rows.evaluations += count;
        rows.has_read_state |= self.of.shape.n + self.of.shape.m > 0;
        let to = if self.sum == Sum::Integral { &mut rows.integrands } else { &mut rows.steps };
        let by_lengths = to.iter_mut().zip(self.by_lengths[weight.side as usize]);
        by_lengths.for_each(|(to, slope)| *to += slope * weight.factor * values[weight.order]);
    }

    /// Adds value and derivatives, or their changes along a direction, by dual numbers.
    pub(in crate::system) fn add(
        &self,
        (at, along): (&NodeView<f64>, Option<&NodeView<f64>>),
        weight: &Weight,
        rows: &mut CostRows,
    ) {
        let mut put = |slot: Slot, parts: [f64; 2]| {
            let (argument, factor) = self.of.to.argument(slot);
            rows.add(argument, factor * (weight.of[0] * parts[0] + weight.of[1] * parts[1]));
        };
        let (to, parts) = (&self.of.to, |x: &Slope| [x.re, slope(x)]);
        let values = match along {
            None => [self.gradient::<f64>(&|slot| to.read(at, slot), &mut |slot, x| put(slot, [x, 0.0])), 0.0],
            Some(along) => {
                let read = |slot| with_slope(to.read(at, slot), to.rate(along, slot));
                parts(&self.gradient(&read, &mut |slot, x| put(slot, parts(&x))))
            }
        };
        self.add_values(values, weight, 1, rows);
    }

    /// Computes the value and passes each partial derivative to `put`, a few derivatives at a time.
    fn gradient<R: Number>(&self, read: &dyn Fn(Slot) -> R, put: &mut dyn FnMut(Slot, R)) -> R
    where
        dyn AnyCost: Values<Wide<R>>,
    {
        let (variables, mut value) = (self.of.variables(&vec![true; self.of.slots.len()]), R::zero());
        for seeds in variables.chunks(SEEDS) {
            let number = |slot| {
                let x = Wide::from_re(read(slot));
                seeds.iter().position(|seed| *seed == slot).map_or(x, |k| x.derivative(k))
            };
            Values::<Wide<R>>::values(&*self.of.formula, &number, &mut |cost| {
                value = cost.re;
                let slopes = cost.eps.0.iter().flatten();
                seeds.iter().zip(slopes).for_each(|(slot, slope)| put(*slot, *slope));
            });
        }
        value
    }
}
