//! Costs of one type: their programs, and their values and derivatives at a node.

use nalgebra::SVector;
use num_dual::{DualSVec64, gradient};
use std::any::Any;

use super::blame::Suspect;
use super::cost::{AccelerationUse, AnyCosts, CostRows, PlainCosts, Weights};
use super::cost_formula::{CostFormula, CostMemory, Partial};
use super::jet::{Slope, slope};
use super::view::NodeView;
use crate::model::Param;
use crate::model::element::{CostPoint, Sum};
use crate::number::{Fingerprint, Real};
use crate::program::{Obstacle, Symbol, Template, record};
use crate::{Cost, Scalar};

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
    accelerations: AccelerationUse,
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
        let name = name.to_string();
        PlacedCost { name, output, cost, sum, q, sigma, u, b, formula: None, accelerations: AccelerationUse::Perhaps }
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

/// Numbers of a cost's arguments: q, v, p*, ṗ*, v̇ (N each), σ, λ (M each), u, t.
mod input {
    pub(super) const fn v_dot(n: usize) -> usize {
        4 * n
    }
    pub(super) const fn sigma(n: usize) -> usize {
        5 * n
    }
    pub(super) const fn u(n: usize, m: usize) -> usize {
        5 * n + 2 * m
    }
    pub(super) const fn t(n: usize, m: usize, k: usize) -> usize {
        u(n, m) + k
    }
    /// Whether one is v̇ or λ.
    pub(super) fn is_acceleration(which: usize, n: usize, m: usize) -> bool {
        (v_dot(n)..sigma(n)).contains(&which) || (sigma(n) + m..u(n, m)).contains(&which)
    }
}

type Point<S, const N: usize, const M: usize, const K: usize> = CostPoint<S, N, M, K>;

fn lift<S: Scalar, const N: usize, const M: usize, const K: usize>(at: &Point<f64, N, M, K>) -> Point<S, N, M, K> {
    CostPoint {
        q: at.q.map(S::from),
        v: at.v.map(S::from),
        p_star: at.p_star.map(S::from),
        p_star_dot: at.p_star_dot.map(S::from),
        v_dot: at.v_dot.map(S::from),
        sigma: at.sigma.map(S::from),
        lambda: at.lambda.map(S::from),
        u: at.u.map(S::from),
        t: S::from(at.t),
    }
}

impl<C: Cost<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedCost<C, N, M, K, P> {
    fn local<R: Real>(&self, at: &NodeView<R>) -> Point<R, N, M, K> {
        let gather = |from: &[R]| SVector::from_fn(|i, _| from[self.q[i]]);
        // Not there, v̇ and λ are not used.
        let given = |from: &[R], i: usize| from.get(i).copied().unwrap_or(R::zero());
        CostPoint {
            q: gather(at.q),
            v: gather(at.v),
            p_star: gather(at.p_star),
            p_star_dot: gather(at.p_star_dot),
            v_dot: SVector::from_fn(|i, _| given(at.v_dot, self.q[i])),
            sigma: SVector::from_fn(|j, _| at.sigma[self.sigma[j]]),
            lambda: SVector::from_fn(|j, _| given(at.lambda, self.sigma[j])),
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
        let part = |k: usize| SVector::from_fn(|i, _| input(k * N + i));
        let of_equations = |k: usize| SVector::from_fn(|j, _| input(input::sigma(N) + k * M + j));
        CostPoint {
            q: part(0),
            v: part(1),
            p_star: part(2),
            p_star_dot: part(3),
            v_dot: part(4),
            sigma: of_equations(0),
            lambda: of_equations(1),
            u: SVector::from_fn(|k, _| input(input::u(N, M) + k)),
            t: input(input::t(N, M, K)),
        }
    }

    fn use_of_accelerations(&self, template: Option<&Template>) -> AccelerationUse {
        let Some(template) = template else { return AccelerationUse::Perhaps };
        let depends = template.depends(input::t(N, M, K) + 1);
        let is_used = (0..depends.len()).any(|which| depends[which] && input::is_acceleration(which, N, M));
        if is_used { AccelerationUse::Always } else { AccelerationUse::Never }
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
        let factor = rows.factors[self.output];
        if factor == 0.0 {
            return;
        }
        let Some(weight) = weights.of(self.sum).filter(|weight| *weight != 0.0 || self.sum.is_of_both_steps()) else {
            return;
        };
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
        let states = [at.q, at.v, at.p_star, at.p_star_dot, at.v_dot];
        let of_equations = [at.sigma, at.lambda];
        // Their numbers in the lists of all coordinates and equations.
        let place = |which: usize| match which {
            i if i < input::sigma(N) => (i / N, self.q[i % N]),
            i => ((i - input::sigma(N)) / M, self.sigma[(i - input::sigma(N)) % M]),
        };
        let argument = |which: usize| match which {
            i if i < input::sigma(N) => states[place(i).0][place(i).1],
            i if i < input::u(N, M) => of_equations[place(i).0][place(i).1],
            i if i < input::t(N, M, K) => at.u[self.u[i - input::u(N, M)]],
            _ => at.t,
        };
        let CostRows { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, design, time, memory, .. } = rows;
        let (states, of_equations) = (&mut [q, v, p_star, p_star_dot, v_dot], &mut [sigma, lambda]);
        formula.evaluate(memory, argument, |of, slope| match of {
            Partial::Argument(i) if i < input::sigma(N) => states[place(i).0][place(i).1] += weight * slope,
            Partial::Argument(i) if i < input::u(N, M) => of_equations[place(i).0][place(i).1] += weight * slope,
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
        add(&mut rows.v_dot, &self.q, weight, &self.part(&p.v_dot, p, b, |point, x| point.v_dot = x));
        add(&mut rows.lambda, &self.sigma, weight, &self.part(&p.lambda, p, b, |point, x| point.lambda = x));
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
            let recorded = item.record(at);
            item.accelerations = item.use_of_accelerations(recorded.as_ref().ok().map(|(template, _)| template));
            if !without_programs {
                let bound = item.b.map(|b| b.constant().is_none());
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

    fn use_of_accelerations(&self, is_summed: &dyn Fn(Sum) -> bool, factors: &[f64]) -> AccelerationUse {
        let here = self.items.iter().filter(|item| factors[item.output] != 0.0 && is_summed(item.sum));
        here.map(|item| item.accelerations).max().unwrap_or(AccelerationUse::Never)
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
