//! [`PlacedCost`]: one cost, its program, and its value and derivatives at a node.

use std::sync::Arc;

use num_dual::Dual64;

use super::cost_formula::CostFormula;
use super::cost_program::CostPrograms;
use super::cost_second_order::CostSecondOrder;
use super::cost_use::{CostUse, Term};
use super::rows::CostRows;
use super::weights::{Beside, Weights, slopes};
use crate::model::element::{ListCost, Sum};
use crate::number::{Hyper, hyper, hyper_parts};
use crate::program::Obstacle;
use crate::system::formula::{
    AnyCost, Argument, Connections, CostOfLists, NodeView, Number, Placed, SEEDS, Shape, Slot, Values, Wide, value,
};

/// A cost and the arguments it is connected to.
#[derive(Clone)]
pub struct PlacedCost {
    pub of: Placed<dyn AnyCost>,
    /// 0 for J, or 1 + the number of the output.
    pub(in crate::system) output: usize,
    pub(in crate::system) sum: Sum,
    /// The derivatives of its weight with respect to the lengths of the steps before and after a node, for each [`Beside`].
    by_lengths: [[f64; 2]; 3],
    pub(in crate::system) formula: Option<CostFormula>,
    /// The scene's arguments of the partial derivatives of the program, with the factors between the two.
    partials: Vec<(Argument, f64)>,
    /// Why there is no program; `None` if there is one or none was requested.
    pub(in crate::system) obstacle: Option<Obstacle>,
    pub(in crate::system) uses: CostUse,
}

impl PlacedCost {
    pub fn new((name, output): (&str, usize), (cost, sum): (impl ListCost, Sum), to: Connections) -> Self {
        let shape = Shape { n: to.q.len(), m: to.sigma.len(), k: to.u.len(), p: to.b.len() };
        let formula: Arc<dyn AnyCost> = Arc::new(CostOfLists { cost, shape });
        let of = Placed { name: name.to_string(), formula, shape, to, slots: shape.of_cost().collect(), depends: None };
        let by_lengths = [Beside::Both, Beside::Before, Beside::After].map(|side| slopes(sum, side));
        PlacedCost {
            of,
            output,
            sum,
            by_lengths,
            formula: None,
            partials: Vec::new(),
            obstacle: None,
            uses: CostUse::UNKNOWN,
        }
    }

    /// Records the formula and compiles its program, unless there are to be no `programs`. `offset` is the first index that it may use in the memory of all
    /// costs; returns the one after the last.
    pub(in crate::system) fn prepare(
        &mut self,
        at: &NodeView<f64>,
        programs: Option<&mut CostPrograms>,
        offset: usize,
    ) -> usize {
        let recorded = self.of.record(at);
        self.of.depends = recorded.as_ref().ok().map(|(template, _)| self.of.depends(template));
        (self.uses, self.obstacle) = (self.find_uses(), recorded.as_ref().err().copied());
        let (Some(programs), Ok((template, numbers))) = (programs, recorded) else { return offset };
        let program = programs.of(&template, self.of.shape, self.variables());
        (self.obstacle, self.formula) =
            (program.as_ref().err().copied(), program.ok().map(|program| CostFormula::new(program, numbers, offset)));
        let partials = self.formula.iter().flat_map(|formula| &formula.program.partials);
        self.partials = partials.map(|slot| self.of.to.argument(*slot)).collect();
        self.formula.as_ref().map_or(offset, CostFormula::end)
    }

    /// The arguments of the partial derivatives: those that the formula depends on, as far as is known, and the constants that are bound.
    fn variables(&self) -> Vec<Slot> {
        let all = || vec![true; self.of.slots.len()];
        self.of.variables(&self.of.depends.clone().unwrap_or_else(all))
    }

    /// The program for second-order sweeps.
    pub(in crate::system) fn second_order(&self, at: &NodeView<f64>) -> Option<CostSecondOrder> {
        self.formula.as_ref()?;
        CostSecondOrder::new(self.of.record(at).ok()?, self.of.shape, self.variables())
    }

    /// The arguments that cause the value not to be finite; `None` if it is finite.
    pub(in crate::system) fn to_blame(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        self.of.to_blame(at, |read| value::<f64>(&*self.of.formula, read).is_finite())
    }

    /// Clears derivatives by arguments that the cost does not depend on there, if others are not finite: dual numbers make 0 · NaN of them.
    pub(in crate::system) fn clear_others(&self, at: &NodeView<f64>, rows: &mut CostRows) {
        let Some((template, _)) = self.of.record_branch(at) else { return };
        let all = rows.clone();
        let (_, mut slopes) = rows.memory_and_slopes();
        let others = self.of.slots.iter().zip(self.of.depends(&template)).filter(|(_, depends)| !depends);
        others.for_each(|(slot, _)| *slopes.of(self.of.to.argument(*slot).0) = 0.0);
        if rows.is_finite() {
            *rows = all;
        }
    }

    fn find_uses(&self) -> CostUse {
        let Some(depends) = &self.of.depends else { return CostUse::UNKNOWN };
        CostUse::of(self.of.slots.iter().zip(depends).filter(|(_, depends)| **depends).map(|(slot, _)| *slot))
    }

    /// Description of the cost without its formula.
    pub(in crate::system) fn term(&self) -> Term<'_> {
        let PlacedCost { of, output, sum, uses, obstacle, formula, .. } = self;
        let has_program = formula.is_some();
        Term { name: &of.name, output: *output, sum: *sum, uses: *uses, has_program, obstacle: *obstacle, to: &of.to }
    }

    pub(in crate::system) fn gradient(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) {
        let factor = rows.factors.of(self.output);
        if factor == 0.0 {
            return;
        }
        // For adjacent steps of opposite direction the weight may vanish although its derivatives do not.
        let is_summed = |weight: &f64| *weight != 0.0 || self.sum.is_of_both_steps();
        let Some(weight) = weights.of(self.sum).filter(is_summed) else { return };
        let value = factor
            * match &self.formula {
                Some(formula) if rows.memory.is_ready => self.program_gradient(formula, at, weight * factor, rows),
                _ => self.dual_gradient(at, weight * factor, rows),
            };
        rows.value += weight * value;
        self.add_by_steps(value, weights.side, rows);
    }

    /// Adds h to the derivatives with respect to the lengths of steps on which its weight depends.
    fn add_by_steps(&self, value: f64, side: Beside, rows: &mut CostRows) {
        rows.evaluations += 1;
        rows.has_read_state |= self.of.shape.n + self.of.shape.m > 0;
        let [before, after] = self.by_lengths[side as usize].map(|slope| slope * value);
        if self.sum == Sum::Integral {
            rows.integrand_before += before;
            rows.integrand_after += after;
        } else {
            rows.step_before += before;
            rows.step_after += after;
        }
    }

    /// Adds the change of value and derivatives along a direction.
    pub(in crate::system) fn gradient_along(
        &self,
        program: &mut Option<CostSecondOrder>,
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        weights: &Weights<Dual64>,
        rows: &mut CostRows,
    ) {
        let factor = rows.factors.of(self.output);
        let is_summed = |weight: &Dual64| weight.re != 0.0 || weight.eps != 0.0 || self.sum.is_of_both_steps();
        let Some(weight) = weights.of(self.sum).filter(is_summed).filter(|_| factor != 0.0) else { return };
        let (_, mut slopes) = rows.memory_and_slopes();
        let put = |slot: Slot, [slope, change]: [f64; 2]| {
            let (argument, multiple) = self.of.to.argument(slot);
            *slopes.of(argument) += multiple * factor * (weight.re * change + weight.eps * slope);
        };
        let (read, rate) = (|slot| self.of.to.read(at, slot), |slot| self.of.to.rate(along, slot));
        let [value, change] = match program {
            Some(program) => program.evaluate(read, rate, put),
            None => self.dual_gradient_along(read, rate, put),
        };
        rows.value += factor * (weight.re * change + weight.eps * value);
        self.add_by_steps(factor * change, weights.side, rows);
    }

    /// Computes h and its change along a direction, and each partial derivative with its change, by hyper-dual numbers.
    fn dual_gradient_along(
        &self,
        read: impl Fn(Slot) -> f64,
        rate: impl Fn(Slot) -> f64,
        mut put: impl FnMut(Slot, [f64; 2]),
    ) -> [f64; 2] {
        let evaluate = |of: Option<Slot>| {
            let number = |slot| hyper(read(slot), f64::from(of == Some(slot)), rate(slot), 0.0);
            hyper_parts(&value::<Hyper>(&*self.of.formula, &number))
        };
        for slot in self.all_variables() {
            let [_, slope, _, change] = evaluate(Some(slot));
            put(slot, [slope, change]);
        }
        let [value, _, change, _] = evaluate(None);
        [value, change]
    }

    /// Evaluates value and gradient by the program.
    fn program_gradient(&self, formula: &CostFormula, at: &NodeView<f64>, weight: f64, rows: &mut CostRows) -> f64 {
        let (memory, mut slopes) = rows.memory_and_slopes();
        formula.evaluate(
            memory,
            |slot| self.of.to.read(at, slot),
            |k, slope| {
                let (argument, factor) = self.partials[k];
                *slopes.of(argument) += weight * factor * slope;
            },
        )
    }

    /// The variables of derivatives without a program.
    fn all_variables(&self) -> Vec<Slot> {
        self.of.variables(&vec![true; self.of.slots.len()])
    }

    /// Evaluates value and gradient by dual numbers, a few derivatives at a time.
    fn dual_gradient(&self, at: &NodeView<f64>, weight: f64, rows: &mut CostRows) -> f64 {
        let (_, mut slopes) = rows.memory_and_slopes();
        for seeds in self.all_variables().chunks(SEEDS) {
            let number = |slot| {
                let x = Wide::from_re(self.of.to.read(at, slot));
                seeds.iter().position(|seed| *seed == slot).map_or(x, |k| x.derivative(k))
            };
            let cost = value::<Wide<f64>>(&*self.of.formula, &number);
            for (k, slot) in seeds.iter().enumerate() {
                let (argument, factor) = self.of.to.argument(*slot);
                *slopes.of(argument) += weight * factor * cost.eps.0.map_or(0.0, |eps| eps[k]);
            }
        }
        value(&*self.of.formula, &|slot| self.of.to.read(at, slot))
    }

    /// Evaluates h by its formula on any number type.
    pub(in crate::system) fn value<R: Number>(&self, cost: &dyn Values<R>, at: &NodeView<R>) -> R {
        value(cost, &|slot| self.of.to.read(at, slot))
    }
}
