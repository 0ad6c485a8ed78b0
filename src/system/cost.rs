//! Costs and their derivatives h_y, h_u, S_y at one node (Eq. 5, 8).

use nalgebra::SVector;
use num_dual::{Dual64, DualSVec64, gradient};
use std::any::Any;

use super::blame::{Argument, Suspect};
use super::cost_formula::{CostFormula, CostMemory, Partial};
use super::jet::{Slope, slope};
use super::view::NodeView;
use crate::model::Param;
use crate::model::element::{CostPoint, Sum};
use crate::number::Fingerprint;
use crate::number::Real;
use crate::program::{Obstacle, Symbol, Template, record};
use crate::{Cost, Cx, Scalar};

/// The factor of h_i for each way of summing, at one node or stage.
#[derive(Clone, Copy, Debug)]
pub struct Weights<R> {
    /// Those of rules that know of the given nodes alone, at such a node.
    pub given: Option<GivenWeights<R>>,
    /// Δt b_s of the stages that are here.
    pub integral: R,
}

/// The factors at a given node.
#[derive(Clone, Copy, Debug)]
pub struct GivenWeights<R> {
    pub plain: R,
    pub rectangle: R,
    pub trapezoidal: R,
    pub terminal: R,
}

impl<R: Real> Weights<R> {
    /// The factors between given nodes.
    pub fn between(integral: R) -> Self {
        Weights { given: None, integral }
    }

    /// The factor for one way; none if it has nothing to do with this place.
    fn of(&self, sum: Sum) -> Option<R> {
        match (sum, &self.given) {
            (Sum::Integral, _) => Some(self.integral),
            (_, None) => None,
            (Sum::Plain, Some(given)) => Some(given.plain),
            (Sum::Rectangle, Some(given)) => Some(given.rectangle),
            (Sum::Trapezoidal, Some(given)) => Some(given.trapezoidal),
            (Sum::Terminal, Some(given)) => Some(given.terminal),
        }
    }
}

impl<R: Real> GivenWeights<R> {
    /// The factors at a node between a given step of length `before` and one of length `after` (none at the ends).
    pub fn new(before: Option<R>, after: Option<R>) -> Self {
        let (zero, one) = (R::zero(), R::one());
        let length = |step: Option<R>| step.unwrap_or(zero);
        GivenWeights {
            plain: if after.is_some() { one } else { zero },
            rectangle: length(after),
            trapezoidal: (length(before) + length(after)) * 0.5,
            terminal: if after.is_some() { zero } else { one },
        }
    }
}

/// The cost at one node and its derivatives J_q, J_v, J_p*, J_ṗ*, J_σ, J_u, J_b, J_t.
#[derive(Clone, Debug, Default)]
pub struct CostRows {
    pub value: f64,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub p_star: Vec<f64>,
    pub p_star_dot: Vec<f64>,
    pub sigma: Vec<f64>,
    pub u: Vec<f64>,
    pub design: Vec<f64>,
    pub time: f64,
    /// Derivatives with respect to the length of the step before the node and of the one after it.
    pub step_before: f64,
    pub step_after: f64,
    /// Σ h of the costs that are summed with the weights of the scheme.
    pub integrand: f64,
    /// How many costs were evaluated.
    pub evaluations: usize,
    /// The factor of J, then those of the outputs: what is differentiated is their weighted sum.
    pub factors: Vec<f64>,
    pub memory: CostMemory,
}

impl CostRows {
    pub fn new((n, m, k): (usize, usize, usize), designs: usize, outputs: usize) -> Self {
        let zeros = |len| vec![0.0; len];
        CostRows {
            q: zeros(n),
            v: zeros(n),
            p_star: zeros(n),
            p_star_dot: zeros(n),
            sigma: zeros(m),
            u: zeros(k),
            design: zeros(designs),
            factors: factors_of(0, outputs),
            ..CostRows::default()
        }
    }

    pub fn is_finite(&self) -> bool {
        let lists = [&self.q, &self.v, &self.p_star, &self.p_star_dot, &self.sigma, &self.u, &self.design];
        let numbers = [self.value, self.time, self.step_before, self.step_after, self.integrand];
        lists.into_iter().flatten().chain(&numbers).all(|x| x.is_finite())
    }

    /// The arguments by which the derivatives are not finite.
    fn bad_arguments(&self) -> Vec<Argument> {
        let lists = [&self.q, &self.v, &self.p_star, &self.p_star_dot, &self.sigma, &self.u, &self.design];
        let kinds: [fn(usize) -> Argument; 7] = [
            Argument::Coordinate,
            Argument::Velocity,
            Argument::Momentum,
            Argument::Force,
            Argument::Multiplier,
            Argument::Control,
            Argument::Design,
        ];
        let bad = |list: &[f64]| (0..list.len()).filter(|&i| !list[i].is_finite()).collect::<Vec<_>>();
        let time = (!self.time.is_finite()).then_some(Argument::Time);
        lists.into_iter().zip(kinds).flat_map(|(list, of)| bad(list).into_iter().map(of)).chain(time).collect()
    }

    pub fn clear(&mut self) {
        let lists = [&mut self.q, &mut self.v, &mut self.p_star, &mut self.p_star_dot];
        lists.into_iter().chain([&mut self.sigma, &mut self.u, &mut self.design]).for_each(|list| list.fill(0.0));
        (self.value, self.time, self.step_before, self.step_after, self.integrand) = (0.0, 0.0, 0.0, 0.0, 0.0);
        self.evaluations = 0;
    }
}

/// The factors of J (0) and of so many outputs (from 1 on) that leave one of them alone.
pub fn factors_of(which: usize, outputs: usize) -> Vec<f64> {
    (0..=outputs).map(|k| if k == which { 1.0 } else { 0.0 }).collect()
}

/// Costs on numbers of type R.
pub trait PlainCosts<R: Real>: Send + Sync {
    /// The weighted sum of all costs of the batch at one node, each with the factor of J or of the output that it belongs to.
    fn value(&self, at: &NodeView<R>, weights: &Weights<R>, factors: &[f64]) -> R;
}

/// Costs in real numbers, with derivatives.
pub trait AnyCosts: PlainCosts<f64> + PlainCosts<Cx> + PlainCosts<Dual64> + Any {
    /// Resolves the parameters of every cost and makes its program, unless there shall be none; `fixed` counts what their preludes compute.
    /// Takes the parameters of all costs through `resolve`.
    fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param);
    fn prepare(&mut self, at: &NodeView<f64>, without_programs: bool, fixed: &mut usize);
    /// Takes over design variables, and formulas as they are now if they are `changed`; counts costs whose programs do not hold any more.
    fn fix(&self, at: &NodeView<f64>, changed: bool, memory: &mut CostMemory) -> usize;
    /// Joins what identifies the formulas that anything was concluded of.
    fn fingerprint(&self, sum: &mut Fingerprint);
    /// The first cost from whose formula other things would be concluded now.
    fn find_changed(&self, at: &NodeView<f64>) -> Option<&str>;
    /// Whether any of its costs has a value before the last node.
    fn is_running(&self) -> bool;
    /// Whether any of its costs is summed with the weights of the scheme.
    fn has_integral(&self) -> bool;
    /// Adds value and derivatives.
    fn gradient(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows);
    /// The first cost whose value or derivatives are not finite; `rows` is overwritten.
    fn find_not_finite(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) -> Option<Suspect<'_>>;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// One cost and what it is connected to.
pub struct PlacedCost<C, const N: usize, const M: usize, const K: usize, const P: usize> {
    pub name: String,
    /// 0 for J, or 1 + the number of the output.
    pub output: usize,
    pub cost: C,
    pub sum: Sum,
    pub q: [usize; N],
    pub sigma: [usize; M],
    pub u: [usize; K],
    pub b: [Param; P],
    formula: Option<CostFormula>,
}

impl<C, const N: usize, const M: usize, const K: usize, const P: usize> PlacedCost<C, N, M, K, P> {
    pub fn new(
        (name, output): (&str, usize),
        (cost, sum): (C, Sum),
        q: [usize; N],
        sigma: [usize; M],
        u: [usize; K],
        b: [Param; P],
    ) -> Self {
        PlacedCost { name: name.to_string(), output, cost, sum, q, sigma, u, b, formula: None }
    }
}

/// All costs of one type.
pub struct Costs<C, const N: usize, const M: usize, const K: usize, const P: usize> {
    pub items: Vec<PlacedCost<C, N, M, K, P>>,
}

impl<C, const N: usize, const M: usize, const K: usize, const P: usize> Default for Costs<C, N, M, K, P> {
    fn default() -> Self {
        Costs { items: Vec::new() }
    }
}

/// Numbers of a cost's arguments.
mod input {
    pub(super) const fn v(n: usize) -> usize {
        n
    }
    pub(super) const fn p_star(n: usize) -> usize {
        2 * n
    }
    pub(super) const fn p_star_dot(n: usize) -> usize {
        3 * n
    }
    pub(super) const fn sigma(n: usize) -> usize {
        4 * n
    }
    pub(super) const fn u(n: usize, m: usize) -> usize {
        4 * n + m
    }
    pub(super) const fn t(n: usize, m: usize, k: usize) -> usize {
        4 * n + m + k
    }
}

type Point<S, const N: usize, const M: usize, const K: usize> = CostPoint<S, N, M, K>;

fn lift<S: Scalar, const N: usize, const M: usize, const K: usize>(at: &Point<f64, N, M, K>) -> Point<S, N, M, K> {
    CostPoint {
        q: at.q.map(S::from),
        v: at.v.map(S::from),
        p_star: at.p_star.map(S::from),
        p_star_dot: at.p_star_dot.map(S::from),
        sigma: at.sigma.map(S::from),
        u: at.u.map(S::from),
        t: S::from(at.t),
    }
}

impl<C: Cost<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedCost<C, N, M, K, P> {
    fn local<R: Real>(&self, at: &NodeView<R>) -> Point<R, N, M, K> {
        let gather = |from: &[R]| SVector::from_fn(|i, _| from[self.q[i]]);
        CostPoint {
            q: gather(at.q),
            v: gather(at.v),
            p_star: gather(at.p_star),
            p_star_dot: gather(at.p_star_dot),
            sigma: SVector::from_fn(|j, _| at.sigma[self.sigma[j]]),
            u: SVector::from_fn(|k, _| at.u[self.u[k]]),
            t: at.t,
        }
    }

    fn b<R: Real>(&self, design: &[R]) -> SVector<R, P> {
        SVector::from_fn(|p, _| self.b[p].value(design))
    }

    /// Its formula, and the numbers in it; the values are for one that looks at them.
    fn record(&self, at: &NodeView<f64>) -> Result<(Template, Vec<f64>), Obstacle> {
        let value = |i: usize| if i < 2 * N { [at.q, at.v][i / N][self.q[i % N]] } else { 0.0 };
        let (graph, results) = record(|put| {
            let point = Self::inputs(|i| Symbol::input(i, if i == input::t(N, M, K) { at.t } else { value(i) }));
            let b = SVector::from_fn(|p, _| Symbol::parameter(p, self.b[p].value(at.design)));
            put(self.cost.cost(&point, &b));
        })?;
        Ok(Template::new(&graph, &results, P))
    }

    /// A point made of numbered inputs.
    fn inputs<S: Scalar>(input: impl Fn(usize) -> S) -> Point<S, N, M, K> {
        let part = |offset: usize| SVector::from_fn(|i, _| input(offset + i));
        CostPoint {
            q: part(0),
            v: part(input::v(N)),
            p_star: part(input::p_star(N)),
            p_star_dot: part(input::p_star_dot(N)),
            sigma: SVector::from_fn(|j, _| input(input::sigma(N) + j)),
            u: SVector::from_fn(|k, _| input(input::u(N, M) + k)),
            t: input(input::t(N, M, K)),
        }
    }

    fn fingerprint(&self, sum: &mut Fingerprint) {
        if self.formula.is_some() {
            let b = SVector::from_fn(|p, _| Fingerprint::input(input::t(N, M, K) + 1 + p));
            sum.join(self.cost.cost(&Self::inputs(Fingerprint::input), &b));
        }
    }

    /// The gradient with respect to one part of the point, chosen by `set`.
    fn part<const L: usize>(
        &self,
        x: &SVector<f64, L>,
        at: &Point<f64, N, M, K>,
        b: &SVector<f64, P>,
        set: impl Fn(&mut Point<DualSVec64<L>, N, M, K>, SVector<DualSVec64<L>, L>),
    ) -> SVector<f64, L> {
        let (_, gradient) = gradient(
            |x: SVector<DualSVec64<L>, L>| {
                let mut point = lift(at);
                set(&mut point, x);
                self.cost.cost(&point, &b.map(From::from))
            },
            x,
        );
        gradient
    }

    fn gradient(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) {
        // A weight of adjacent steps may vanish between a step forth and a step back; its derivatives do not.
        let is_of_both_steps = matches!(self.sum, Sum::Trapezoidal | Sum::Integral);
        let factor = rows.factors[self.output];
        if factor == 0.0 {
            return;
        }
        let Some(weight) = weights.of(self.sum).filter(|weight| *weight != 0.0 || is_of_both_steps) else { return };
        let value = factor
            * match &self.formula {
                Some(formula) if rows.memory.is_ready => self.program_gradient(formula, at, weight * factor, rows),
                _ => self.dual_gradient(at, weight * factor, rows),
            };
        rows.value += weight * value;
        rows.evaluations += 1;
        match self.sum {
            Sum::Rectangle => rows.step_after += value,
            Sum::Trapezoidal => {
                rows.step_before += 0.5 * value;
                rows.step_after += 0.5 * value;
            }
            Sum::Integral => rows.integrand += value,
            Sum::Plain | Sum::Terminal => {}
        }
    }

    /// Value and gradient by the program.
    fn program_gradient(&self, formula: &CostFormula, at: &NodeView<f64>, weight: f64, rows: &mut CostRows) -> f64 {
        let argument = |which: usize| match which {
            i if i < 4 * N => [at.q, at.v, at.p_star, at.p_star_dot][i / N][self.q[i % N]],
            i if i < input::u(N, M) => at.sigma[self.sigma[i - input::sigma(N)]],
            i if i < input::t(N, M, K) => at.u[self.u[i - input::u(N, M)]],
            _ => at.t,
        };
        let CostRows { q, v, p_star, p_star_dot, sigma, u, design, time, memory, .. } = rows;
        formula.evaluate(memory, argument, |of, slope| match of {
            Partial::Argument(i) if i < 4 * N => [&mut *q, v, p_star, p_star_dot][i / N][self.q[i % N]] += weight * slope,
            Partial::Argument(i) if i < input::u(N, M) => sigma[self.sigma[i - input::sigma(N)]] += weight * slope,
            Partial::Argument(i) if i < input::t(N, M, K) => u[self.u[i - input::u(N, M)]] += weight * slope,
            Partial::Argument(_) => *time += weight * slope,
            Partial::Constant(p) => {
                if let Some((which, factor)) = self.b[p].bound() {
                    design[which] += weight * factor * slope;
                }
            }
        })
    }

    /// Value and gradient by dual numbers, part by part.
    fn dual_gradient(&self, at: &NodeView<f64>, weight: f64, rows: &mut CostRows) -> f64 {
        let (p, b) = (&self.local(at), &self.b(at.design));
        add(&mut rows.q, &self.q, weight, &self.part(&p.q, p, b, |point, x| point.q = x));
        add(&mut rows.v, &self.q, weight, &self.part(&p.v, p, b, |point, x| point.v = x));
        add(&mut rows.p_star, &self.q, weight, &self.part(&p.p_star, p, b, |point, x| point.p_star = x));
        add(&mut rows.p_star_dot, &self.q, weight, &self.part(&p.p_star_dot, p, b, |point, x| point.p_star_dot = x));
        add(&mut rows.sigma, &self.sigma, weight, &self.part(&p.sigma, p, b, |point, x| point.sigma = x));
        add(&mut rows.u, &self.u, weight, &self.part(&p.u, p, b, |point, x| point.u = x));
        rows.time += weight * self.part(&SVector::from([p.t]), p, b, |point, x| point.t = x[0])[0];
        for (i, (design, factor)) in self.b.iter().enumerate().filter_map(|(i, b)| Some((i, b.bound()?))) {
            let mut b = b.map(Slope::from_re);
            b[i] = b[i].derivative(0);
            rows.design[design] += weight * factor * slope(&self.cost.cost(&lift(p), &b));
        }
        self.cost.cost(p, b)
    }
}

fn add<const L: usize>(row: &mut [f64], at: &[usize], weight: f64, gradient: &SVector<f64, L>) {
    for (k, &i) in at.iter().enumerate() {
        row[i] += weight * gradient[k];
    }
}

impl<C, R, const N: usize, const M: usize, const K: usize, const P: usize> PlainCosts<R> for Costs<C, N, M, K, P>
where
    C: Cost<N, M, K, P>,
    R: Real,
{
    fn value(&self, at: &NodeView<R>, weights: &Weights<R>, factors: &[f64]) -> R {
        let mut sum = R::zero();
        for item in self.items.iter().filter(|item| factors[item.output] != 0.0) {
            let Some(weight) = weights.of(item.sum) else { continue };
            if weight.part(0) != 0.0 || weight.part(R::PARTS - 1) != 0.0 {
                sum += item.cost.cost(&item.local(at), &item.b(at.design)) * weight * factors[item.output];
            }
        }
        sum
    }
}

impl<C: Cost<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> AnyCosts for Costs<C, N, M, K, P> {
    fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param) {
        self.items.iter_mut().for_each(|item| item.b = item.b.map(&mut *resolve));
    }

    fn prepare(&mut self, at: &NodeView<f64>, without_programs: bool, fixed: &mut usize) {
        for item in &mut self.items {
            if !without_programs {
                let bound = item.b.map(|b| b.constant().is_none());
                let recorded = item.record(at);
                let formula =
                    recorded.and_then(|recorded| CostFormula::new(recorded, input::t(N, M, K) + 1, &bound, *fixed));
                item.formula = formula.ok();
                *fixed = item.formula.as_ref().map_or(*fixed, CostFormula::end);
            }
        }
    }

    fn fix(&self, at: &NodeView<f64>, changed: bool, memory: &mut CostMemory) -> usize {
        let programs = self.items.iter().filter_map(|item| Some((item, item.formula.as_ref()?)));
        let broken = programs.filter(|(item, formula)| {
            let now = changed.then(|| item.record(at).ok()).flatten();
            changed && now.is_none() || !formula.fix(item.b(at.design).as_slice(), now.as_ref(), memory)
        });
        broken.count()
    }

    fn fingerprint(&self, sum: &mut Fingerprint) {
        self.items.iter().for_each(|item| item.fingerprint(sum));
    }

    fn find_changed(&self, at: &NodeView<f64>) -> Option<&str> {
        let programs = self.items.iter().filter_map(|item| Some((item, item.formula.as_ref()?)));
        let depends =
            |item: &PlacedCost<C, N, M, K, P>| item.record(at).map(|(template, _)| template.depends(input::t(N, M, K) + 1));
        let mut changed = programs.filter(|(item, formula)| depends(item).as_ref() != Ok(&formula.depends));
        changed.next().map(|(item, _)| item.name.as_str())
    }

    fn is_running(&self) -> bool {
        self.items.iter().any(|item| item.sum != Sum::Terminal)
    }

    fn has_integral(&self) -> bool {
        self.items.iter().any(|item| item.sum == Sum::Integral)
    }

    fn gradient(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) {
        for item in &self.items {
            item.gradient(at, weights, rows);
        }
    }

    fn find_not_finite(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows) -> Option<Suspect<'_>> {
        let bad = self.items.iter().find(|item| {
            rows.clear();
            item.gradient(at, weights, rows);
            !rows.is_finite()
        });
        bad.map(|item| Suspect { element: &item.name, arguments: rows.bad_arguments() })
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
