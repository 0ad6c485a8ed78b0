//! [`PlacedCost`]: a cost with its arguments and its program; evaluates its value and derivatives at a node.

use std::sync::Arc;

use num_dual::Dual64;

use super::argument::{Argument, to_blame};
use super::cost::{CostRows, Slopes};
use super::cost_formula::{CostFormula, Partial};
use super::cost_second_order::CostSecondOrder;
use super::cost_shape::{CostShape, Of};
use super::cost_terms::{CostUse, Term};
use super::jet::Number;
use super::plain_cost::{AnyCost, PlainCost};
use super::typed::{SEEDS, Wide, with_memory};
use super::view::NodeView;
use super::weights::{Beside, Weights};
use crate::Scalar;
use crate::model::Param;
use crate::model::element::{ListCost, Sum};
use crate::number::{Fingerprint, hyper, hyper_parts};
use crate::program::{Obstacle, Symbol, Template, record, record_branch};

/// A cost and the arguments it is connected to.
#[derive(Clone)]
pub struct PlacedCost {
    pub name: String,
    /// 0 for J, or 1 + the number of the output.
    pub(super) output: usize,
    pub(super) cost: Arc<dyn AnyCost>,
    pub(super) sum: Sum,
    pub(super) shape: CostShape,
    pub(super) b: Vec<Param>,
    pub(super) formula: Option<CostFormula>,
    /// The reason why the cost has no program, unless programs were disabled.
    pub(super) obstacle: Option<Obstacle>,
    pub(super) uses: CostUse,
    /// Whether the cost depends on each argument, if it could be recorded.
    pub(super) depends: Option<Vec<bool>>,
}

impl PlacedCost {
    pub fn new((name, output): (&str, usize), (cost, sum): (impl ListCost, Sum), shape: CostShape, b: Vec<Param>) -> Self {
        let (name, cost, uses) = (name.to_string(), Arc::new(cost), CostUse::UNKNOWN);
        PlacedCost { name, output, cost, sum, shape, b, formula: None, obstacle: None, uses, depends: None }
    }

    /// Evaluates the cost for given arguments and constants, by their numbers.
    pub(super) fn evaluate<S: Scalar>(
        &self,
        cost: &dyn PlainCost<S>,
        argument: impl Fn(usize) -> S,
        constant: impl Fn(usize) -> S,
    ) -> S {
        let mut value = S::zero();
        with_memory(self.shape.len() + self.b.len(), &mut |all: &mut [S]| {
            let (arguments, constants) = all.split_at_mut(self.shape.len());
            arguments.iter_mut().enumerate().for_each(|(i, x)| *x = argument(i));
            constants.iter_mut().enumerate().for_each(|(p, x)| *x = constant(p));
            value = cost.value(&self.shape.point(arguments, constants));
        });
        value
    }

    pub(super) fn argument<R: Number>(&self, at: &NodeView<R>, which: usize) -> R {
        let (list, place) = self.shape.places[which];
        let lists = [at.q, at.v, at.p_star, at.p_star_dot, at.v_dot, at.sigma, at.lambda, at.u, at.u_dot];
        // Missing quantities are not used by the cost.
        if list == Of::Time { at.t } else { lists[list as usize].get(place).copied().unwrap_or(R::zero()) }
    }

    /// Records the formula; also returns the numbers in it. Formulas that branch on values are recorded at `at`.
    pub(super) fn record(&self, at: &NodeView<f64>) -> Result<(Template, Vec<f64>), Obstacle> {
        let (graph, results) = record(|put| put(self.symbol(|of| self.read(at, of))))?;
        Ok(Template::new(&graph, &results, self.b.len()))
    }

    /// Evaluates the formula on symbols with these values.
    pub(super) fn symbol(&self, value: impl Fn(Partial) -> f64) -> Symbol {
        let argument = |i: usize| Symbol::input(i, value(Partial::Argument(i)));
        self.evaluate(&*self.cost, argument, |p| Symbol::parameter(p, value(Partial::Constant(p))))
    }

    pub(super) fn read(&self, at: &NodeView<f64>, of: Partial) -> f64 {
        match of {
            Partial::Argument(i) => self.argument(at, i),
            Partial::Constant(p) => self.b[p].value(at.design),
        }
    }

    /// The arguments that cause the cost not to be finite, or `None` if it is finite.
    pub(super) fn to_blame(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        let value = |changed: Option<(Partial, f64)>| {
            let read = |of: Partial| changed.filter(|(other, _)| *other == of).map_or_else(|| self.read(at, of), |(_, x)| x);
            self.evaluate::<f64>(&*self.cost, |i| read(Partial::Argument(i)), |p| read(Partial::Constant(p)))
        };
        if value(None).is_finite() {
            return None;
        }
        let graph = record_branch(|put| put(self.symbol(|of| self.read(at, of))));
        let depends =
            graph.map(|(graph, results)| Template::new(&graph, &results, self.b.len()).0.depends(self.shape.len()));
        let depends = depends.unwrap_or_else(|| vec![true; self.shape.len()]);
        let argument = |of: Partial| match of {
            Partial::Argument(i) => Some((of, Argument::of_cost(self.shape.places[i]))),
            Partial::Constant(p) => Some((of, Argument::Design(self.b[p].bound()?.0))),
        };
        let all = Partial::all(&depends, &Param::which_are_bound(&self.b)).into_iter().filter_map(argument).collect();
        Some(to_blame(all, |of, x| value(Some((of, x))).is_finite()))
    }

    /// Clears derivatives with respect to arguments on which the cost does not depend, which may be 0 · NaN, if a derivative is not finite.
    pub(super) fn clear_others(&self, at: &NodeView<f64>, rows: &mut CostRows) {
        let Some((graph, results)) = record_branch(|put| put(self.symbol(|of| self.read(at, of)))) else { return };
        let depends = Template::new(&graph, &results, self.b.len()).0.depends(self.shape.len());
        let all = rows.clone();
        let (_, mut slopes) = rows.memory_and_slopes();
        let others = self.shape.places.iter().zip(depends).filter(|(_, depends)| !depends);
        others.for_each(|(place, _)| slopes.clear(*place));
        if rows.is_finite() {
            *rows = all;
        }
    }

    pub(super) fn find_uses(&self) -> CostUse {
        let Some(depends) = &self.depends else { return CostUse::UNKNOWN };
        CostUse::of(depends.iter().zip(&self.shape.places).filter(|(depends, _)| **depends).map(|(_, (of, _))| *of))
    }

    /// Description of the cost without its formula.
    pub(super) fn term(&self) -> Term<'_> {
        let PlacedCost { name, output, sum, uses, obstacle, shape, .. } = self;
        let has_program = self.formula.is_some();
        Term { name, output: *output, sum: *sum, uses: *uses, has_program, obstacle: *obstacle, shape }
    }

    pub(super) fn fingerprint(&self, sum: &mut Fingerprint) {
        if self.depends.is_some() {
            let constant = |p: usize| Fingerprint::input(self.shape.len() + p);
            sum.join(self.evaluate(&*self.cost, Fingerprint::input, constant));
        }
    }

    pub(super) fn gradient(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) {
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
        rows.has_read_state |= self.shape.has_state();
        let [before, after] = [side.has_before(), side.has_after()].map(|counts| if counts { value } else { 0.0 });
        match self.sum {
            Sum::Rectangle => rows.step_after += after,
            Sum::Trapezoidal => {
                rows.step_before += 0.5 * before;
                rows.step_after += 0.5 * after;
            }
            Sum::Integral => {
                rows.integrand_before += before;
                rows.integrand_after += after;
            }
            Sum::Plain | Sum::AllNodes | Sum::Terminal | Sum::Node(_) => {}
        }
    }

    /// Adds the change of value and derivatives along a direction.
    pub(super) fn gradient_along(
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
        let put = |of: Partial, [slope, change]: [f64; 2]| {
            self.add_partial(of, 1.0, factor * (weight.re * change + weight.eps * slope), &mut slopes);
        };
        let rate_of_constant = |p: usize| self.b[p].bound().map_or(0.0, |(place, factor)| factor * along.design[place]);
        let rate = |which| self.argument(along, which);
        let [value, change] = match program {
            Some(program) => program.evaluate(|which| self.argument(at, which), rate, rate_of_constant, put),
            None => self.dual_gradient_along(at, rate, rate_of_constant, put),
        };
        rows.value += factor * (weight.re * change + weight.eps * value);
        self.add_by_steps(factor * change, weights.side, rows);
    }

    /// h and its change along a direction, and each partial derivative with its change, by hyper-dual numbers.
    fn dual_gradient_along(
        &self,
        at: &NodeView<f64>,
        rate: impl Fn(usize) -> f64,
        rate_of_constant: impl Fn(usize) -> f64,
        mut put: impl FnMut(Partial, [f64; 2]),
    ) -> [f64; 2] {
        let evaluate = |of: Option<Partial>| {
            let seeded = |is_seed: bool, x: f64, rate: f64| hyper(x, if is_seed { 1.0 } else { 0.0 }, rate, 0.0);
            let argument = |i: usize| seeded(of == Some(Partial::Argument(i)), self.argument(at, i), rate(i));
            let constant =
                |p: usize| seeded(of == Some(Partial::Constant(p)), self.b[p].value(at.design), rate_of_constant(p));
            hyper_parts(&self.evaluate(&*self.cost, argument, constant))
        };
        for of in self.partials() {
            let [_, slope, _, change] = evaluate(Some(of));
            put(of, [slope, change]);
        }
        let [value, _, change, _] = evaluate(None);
        [value, change]
    }

    /// Evaluates value and gradient by the program.
    fn program_gradient(&self, formula: &CostFormula, at: &NodeView<f64>, weight: f64, rows: &mut CostRows) -> f64 {
        let (memory, mut slopes) = rows.memory_and_slopes();
        let put = |of, slope| self.add_partial(of, weight, slope, &mut slopes);
        formula.evaluate(memory, |which| self.argument(at, which), put)
    }

    /// Adds a partial derivative, multiplied by the weight.
    #[inline]
    fn add_partial(&self, of: Partial, weight: f64, slope: f64, slopes: &mut Slopes) {
        match of {
            Partial::Argument(which) => slopes.add(self.shape.places[which], weight * slope),
            Partial::Constant(p) => {
                if let Some((design, factor)) = self.b[p].bound() {
                    slopes.design[design] += weight * factor * slope;
                }
            }
        }
    }

    /// The variables of differentiation for a cost without a program.
    fn partials(&self) -> Vec<Partial> {
        Partial::all(&vec![true; self.shape.len()], &Param::which_are_bound(&self.b))
    }

    /// Evaluates value and gradient by dual numbers, a few derivatives at a time.
    fn dual_gradient(&self, at: &NodeView<f64>, weight: f64, rows: &mut CostRows) -> f64 {
        let (_, mut slopes) = rows.memory_and_slopes();
        for seeds in self.partials().chunks(SEEDS) {
            let seeded = |of: Partial, value: f64| match seeds.iter().position(|seed| *seed == of) {
                Some(k) => Wide::from_re(value).derivative(k),
                None => Wide::from_re(value),
            };
            let argument = |i: usize| seeded(Partial::Argument(i), self.argument(at, i));
            let cost = self
                .evaluate::<Wide<f64>>(&*self.cost, argument, |p| seeded(Partial::Constant(p), self.b[p].value(at.design)));
            for (k, of) in seeds.iter().enumerate() {
                self.add_partial(*of, weight, cost.eps.0.map_or(0.0, |eps| eps[k]), &mut slopes);
            }
        }
        self.value(&*self.cost, at)
    }

    /// Evaluates h by its formula on a given number type.
    pub(super) fn value<R: Number>(&self, cost: &dyn PlainCost<R>, at: &NodeView<R>) -> R {
        self.evaluate(cost, |which| self.argument(at, which), |p| self.b[p].value(at.design))
    }
}
