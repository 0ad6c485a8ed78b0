//! One element in a scene with its type: its formula on any numbers, and what it is connected to.

use nalgebra::SVector;
use num_dual::Dual64;
use std::sync::Arc;

use super::batch::{Covector, InputRows, Sums};
use super::blame::Argument;
use super::constants::Entry;
use super::element::Element;
use super::formula::Formula;
use super::jet::{ElementKind, FirstDerivatives, Jet, Local, Number};
use super::shape::{Place, Shape};
use super::view::NodeView;
use crate::model::Param;
use crate::number::{Fingerprint, Slope, hyper, hyper_parts, slope};
use crate::program::{Obstacle, Symbol, Template, record};

/// One element: its formula, and which coordinates, multipliers, controls and parameters it is connected to.
pub struct PlacedElement<J, const N: usize, const M: usize, const K: usize, const P: usize> {
    pub name: String,
    pub jet: J,
    pub q: [usize; N],
    /// Its constraint equations.
    pub sigma: [usize; M],
    pub u: [usize; K],
    pub b: [Param; P],
    /// Whether it depends on time, as long as nothing else is known, and whether its formula has a graph.
    pub timed: bool,
    pub is_recorded: bool,
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    pub fn local<R: Number>(&self, at: &NodeView<R>) -> Local<R, N, M, K> {
        Local {
            q: SVector::from_fn(|i, _| at.q[self.q[i]]),
            v: SVector::from_fn(|i, _| at.v[self.q[i]]),
            sigma: SVector::from_fn(|j, _| at.sigma[self.sigma[j]]),
            u: SVector::from_fn(|k, _| at.u[self.u[k]]),
            t: at.t,
        }
    }

    pub fn b<R: Number>(&self, design: &[R]) -> SVector<R, P> {
        SVector::from_fn(|p, _| self.b[p].value(design))
    }

    /// The element without its type.
    pub fn element(&self, (batch, item): (usize, usize), formula: Arc<Formula>, numbers: Vec<f64>) -> Element {
        let (q, sigma, u, b) = (self.q.to_vec(), self.sigma.to_vec(), self.u.to_vec(), self.b.to_vec());
        Element { name: self.name.clone(), batch, item, q, sigma, u, b, formula, numbers }
    }

    /// Its formula, and the numbers in it that like elements need not share.
    pub fn record(&self, at: &NodeView<f64>) -> Result<(Template, Vec<f64>), Obstacle> {
        let real: Local<f64, N, M, K> = self.local(at);
        let shape = Shape { n: N, m: M, k: K, p: P };
        let (graph, results) = record(|put| {
            let local = Local {
                q: SVector::from_fn(|i, _| Symbol::input(i, real.q[i])),
                v: SVector::from_fn(|i, _| Symbol::input(shape.v() + i, real.v[i])),
                sigma: real.sigma.map(Symbol::from),
                u: SVector::from_fn(|k, _| Symbol::input(shape.u() + k, real.u[k])),
                t: Symbol::input(shape.t(), real.t),
            };
            // A constant that is 0 or ±1 for ever simplifies the formula; that of a design variable may have any value in the next run.
            let b = SVector::from_fn(|p, _| match self.b[p].constant() {
                Some(value) if value == 0.0 || value.abs() == 1.0 => Symbol::from(value),
                _ => Symbol::parameter(p, self.b[p].value(at.design)),
            });
            self.jet.values(&local, &b, put);
        })?;
        Ok(Template::new(&graph, &results, P))
    }

    /// All arguments that the formula depends on, as far as is known.
    pub fn arguments(&self, at: &NodeView<f64>) -> Vec<Argument> {
        let shape = Shape { n: N, m: M, k: K, p: P };
        let depends =
            self.record(at).map_or_else(|_| vec![true; shape.sigma()], |(template, _)| template.depends(shape.sigma()));
        let argument = |which: usize| match shape.place(which) {
            Place::Q(i) => Argument::Coordinate(self.q[i]),
            Place::V(i) => Argument::Velocity(self.q[i]),
            Place::U(k) => Argument::Control(self.u[k]),
            _ => Argument::Time,
        };
        let design = self.b.iter().filter_map(|b| b.bound()).map(|(p, _)| Argument::Design(p));
        (0..shape.sigma()).filter(|&which| depends[which]).map(argument).chain(design).collect()
    }

    /// Joins what identifies the formula, if anything was concluded from it.
    pub fn fingerprint(&self, sum: &mut Fingerprint) {
        if !self.is_recorded {
            return;
        }
        let (shape, input) = (Shape { n: N, m: M, k: K, p: P }, Fingerprint::input);
        let at = Local {
            q: SVector::from_fn(|i, _| input(i)),
            v: SVector::from_fn(|i, _| input(shape.v() + i)),
            sigma: SVector::from_fn(|_, _| Fingerprint::from(1.0)),
            u: SVector::from_fn(|k, _| input(shape.u() + k)),
            t: input(shape.t()),
        };
        let b = SVector::from_fn(|p, _| input(shape.sigma() + p));
        self.jet.values(&at, &b, &mut |value| sum.join(value));
    }

    /// The arguments by which its derivatives are not finite, if anything of it is not.
    pub fn find_not_finite(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        let (local, b) = (self.local(at), self.b(at.design));
        let mut blocks = vec![0.0; J::KIND.length(N, M)];
        self.jet.blocks(&local, &b, &mut FirstDerivatives::zero(), &mut blocks);
        let mut arguments = Vec::new();
        for (which, _) in blocks.iter().enumerate().filter(|(_, entry)| !entry.is_finite()) {
            // Every block has a column for each coordinate; of energies and forces the first is that of the velocities.
            let by_v = matches!(J::KIND, ElementKind::Kinetic | ElementKind::Applied) && which < N * N;
            let i = self.q[which % N];
            arguments.push(if by_v { Argument::Velocity(i) } else { Argument::Coordinate(i) });
        }
        let first = self.jet.first(&local, &b);
        let mut values = first.l_v.iter().chain(&first.force).chain(&first.phi_dot);
        let is_fine = arguments.is_empty() && values.all(|x| x.is_finite());
        if arguments.is_empty() {
            arguments = self.arguments(at);
        }
        arguments.sort_unstable();
        arguments.dedup();
        (!is_fine).then_some(arguments)
    }

    /// Value and derivatives, by dual numbers.
    pub fn evaluate(&self, at: &NodeView<f64>, sums: &mut Sums<f64>, blocks: &mut [f64]) {
        let mut first = FirstDerivatives::zero();
        self.jet.blocks(&self.local(at), &self.b(at.design), &mut first, blocks);
        self.scatter_first(&first, sums);
    }

    pub fn scatter_first<R: Number>(&self, first: &FirstDerivatives<R, N, M>, sums: &mut Sums<R>) {
        let [l_v, force, phi_dot] = sums.parts_mut();
        for (i, &coordinate) in self.q.iter().enumerate() {
            l_v[coordinate] += first.l_v[i];
            force[coordinate] += first.force[i];
        }
        for (j, own) in first.phi_dot.iter().enumerate() {
            phi_dot[self.sigma[j]] += *own;
        }
    }
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    /// 𝓛_v, 𝓛_q + Q and dΦ/dt with their derivatives with respect to one input, seeded by `seed`.
    #[inline]
    fn differentiate(
        &self,
        at: &NodeView<f64>,
        seed: impl FnOnce(&mut Local<Slope, N, M, K>, &mut SVector<Slope, P>),
    ) -> FirstDerivatives<Slope, N, M> {
        let real: Local<f64, N, M, K> = self.local(at);
        let mut local = real.lift();
        let mut b = self.b(at.design).map(Slope::from_re);
        seed(&mut local, &mut b);
        self.jet.first(&local, &b)
    }

    /// The derivative of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to one input, seeded by `seed`.
    fn directional(
        &self,
        at: &NodeView<f64>,
        with: &Covector,
        seed: impl FnOnce(&mut Local<Slope, N, M, K>, &mut SVector<Slope, P>),
    ) -> f64 {
        slope(&self.pair(&self.differentiate(at, seed), with))
    }

    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt.
    pub(super) fn pair<R: Number>(&self, first: &FirstDerivatives<R, N, M>, with: &Covector) -> R {
        let mut sum = R::zero();
        for (i, &coordinate) in self.q.iter().enumerate() {
            sum += first.l_v[i] * with.c[coordinate] + first.force[i] * with.d[coordinate];
        }
        for (j, phi_dot) in first.phi_dot.iter().enumerate() {
            sum += *phi_dot * with.e[self.sigma[j]];
        }
        sum
    }

    /// That sum and its rate.
    pub fn along(&self, at: &NodeView<Dual64>, with: &Covector) -> [f64; 2] {
        let dual = |x: Dual64| hyper(x.re, x.eps, 0.0, 0.0);
        let local: Local<Dual64, N, M, K> = self.local(at);
        let local = Local {
            q: local.q.map(dual),
            v: local.v.map(dual),
            sigma: local.sigma.map(dual),
            u: local.u.map(dual),
            t: dual(local.t),
        };
        let sum = self.pair(&self.jet.first(&local, &self.b(at.design).map(dual)), with);
        let [value, rate, ..] = hyper_parts(&sum);
        [value, rate]
    }

    /// The first input with respect to which the derivatives are not finite.
    pub fn find_bad_input(&self, at: &NodeView<f64>) -> Option<Argument> {
        let is_bad = |first: FirstDerivatives<Slope, N, M>| {
            let mut slopes = first.l_v.iter().chain(&first.force).chain(&first.phi_dot).map(slope);
            slopes.any(|slope| !slope.is_finite())
        };
        let control = |k: &usize| is_bad(self.differentiate(at, |local, _| local.u[*k] = local.u[*k].derivative(0)));
        let design = |p: &usize| is_bad(self.differentiate(at, |_, b| b[*p] = b[*p].derivative(0)));
        let time = || is_bad(self.differentiate(at, |local, _| local.t = local.t.derivative(0)));
        let of_control = (0..K).find(control).map(|k| Argument::Control(self.u[k]));
        let of_design = || (0..P).filter(design).find_map(|p| self.b[p].bound()).map(|(p, _)| Argument::Design(p));
        of_control.or_else(|| (self.timed && time()).then_some(Argument::Time)).or_else(of_design)
    }

    pub fn pull_back_inputs(&self, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows) {
        *rows.evaluations += K + 1;
        for (k, &channel) in self.u.iter().enumerate() {
            rows.u[channel] += self.directional(at, with, |local, _| local.u[k] = local.u[k].derivative(0));
        }
        *rows.time += self.directional(at, with, |local, _| local.t = local.t.derivative(0));
        for (p, b) in self.b.iter().enumerate() {
            if let Some((design, factor)) = b.bound() {
                *rows.evaluations += 1;
                rows.design[design] += factor * self.directional(at, with, |_, b| b[p] = b[p].derivative(0));
            }
        }
    }

    /// Adds the derivatives of e·Φ with respect to design variables and time.
    pub fn pull_back_phi(&self, at: &NodeView<f64>, e: &[f64], rows: &mut InputRows) {
        let q = SVector::from_fn(|i, _| Slope::from_re(at.q[self.q[i]]));
        let directional = |t: Slope, b: &SVector<Slope, P>| -> f64 {
            let phi = self.jet.phi(&q, b, t);
            phi.iter().zip(self.sigma).map(|(phi, j)| e[j] * slope(phi)).sum()
        };
        let b = self.b(at.design).map(Slope::from_re);
        if self.timed {
            *rows.evaluations += 1;
            *rows.time += directional(Slope::from_re(at.t).derivative(0), &b);
        }
        for (p, constant) in self.b.iter().enumerate() {
            if let Some((design, factor)) = constant.bound() {
                *rows.evaluations += 1;
                let mut moved = b;
                moved[p] = moved[p].derivative(0);
                rows.design[design] += factor * directional(Slope::from_re(at.t), &moved);
            }
        }
    }

    /// Column `i` of the element's Φ_q, in the scene's numbering.
    pub fn phi_q_column(&self, i: usize, q: &SVector<f64, N>, t: f64, design: &[f64], put: &mut dyn FnMut(Entry)) {
        let mut q = q.map(Slope::from_re);
        q[i] = q[i].derivative(0);
        let phi: SVector<Slope, M> = self.jet.phi(&q, &self.b(design).map(Slope::from_re), Slope::from_re(t));
        for (j, phi) in phi.iter().enumerate() {
            put(Entry { row: self.sigma[j], col: self.q[i], value: slope(phi) });
        }
    }
}
