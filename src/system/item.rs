//! One element in a scene: its formula, what it is connected to, and what its trace found out.

use nalgebra::SVector;
use num_dual::Dual64;
use std::f64::consts::FRAC_PI_2;

use super::batch::{Covector, InputRows, Sums, Within};
use super::blame::Argument;
use super::constants::{Constants, Entry};
use super::jet::{ElementKind, FirstDerivatives, Jet, Local, Number, Slope, slope};
use super::plan::{MOST_SEEDS, Plan};
use super::sines::SinusoidalTerm;
use super::view::NodeView;
use crate::model::Param;
use crate::number::Real;

/// One element: its formula, and which coordinates, multipliers, controls and parameters it is connected to.
pub struct PlacedElement<J, const N: usize, const M: usize, const K: usize, const P: usize> {
    pub name: String,
    pub jet: J,
    pub q: [usize; N],
    /// Its constraint equations.
    pub sigma: [usize; M],
    pub u: [usize; K],
    pub b: [Param; P],
    pub plan: Plan<N>,
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    pub fn local<R: Real>(&self, at: &NodeView<R>) -> Local<R, N, M, K> {
        Local {
            q: SVector::from_fn(|i, _| at.q[self.q[i]]),
            v: SVector::from_fn(|i, _| at.v[self.q[i]]),
            sigma: SVector::from_fn(|j, _| at.sigma[self.sigma[j]]),
            u: SVector::from_fn(|k, _| at.u[self.u[k]]),
            t: at.t,
        }
    }

    pub fn b<R: Real>(&self, design: &[R]) -> SVector<R, P> {
        SVector::from_fn(|p, _| self.b[p].value(design))
    }

    /// Derivatives with `A` seeded coordinates.
    fn blocks<const A: usize>(&self, at: &NodeView<f64>, first: &mut FirstDerivatives<f64, N, M>, blocks: &mut [f64]) {
        let seeds = self.plan.seeds();
        let mut local = self.local(at);
        if J::KIND == ElementKind::Holonomic {
            self.plan.gather_velocities(&mut local.v);
        }
        let len = self.plan.seeded_len(J::KIND, M);
        self.jet.blocks::<A>(&seeds, &local, &self.b(at.design), first, &mut blocks[..len]);
    }

    /// The arguments by which its derivatives are not finite, if anything of it is not.
    pub fn find_not_finite(&self, at: &NodeView<f64>) -> Option<Vec<Argument>> {
        let (local, b) = (self.local(at), self.b(at.design));
        let mut blocks = vec![0.0; J::KIND.length(N, M)];
        self.jet.blocks::<N>(&Plan::<N>::default().seeds(), &local, &b, &mut FirstDerivatives::zero(), &mut blocks);
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

    /// Value and derivatives: the number of seeds selects the size of the dual numbers.
    pub fn evaluate(&self, at: &NodeView<f64>, sums: &mut Sums<f64>, blocks: &mut [f64]) {
        let mut first = FirstDerivatives::zero();
        match self.plan.seeded {
            seeded if seeded == N => self.blocks::<N>(at, &mut first, blocks),
            0 => self.blocks::<0>(at, &mut first, blocks),
            1 => self.blocks::<1>(at, &mut first, blocks),
            2 => self.blocks::<2>(at, &mut first, blocks),
            3 => self.blocks::<3>(at, &mut first, blocks),
            _ => self.blocks::<MOST_SEEDS>(at, &mut first, blocks),
        }
        self.plan.spread(J::KIND, &mut first, blocks);
        self.scatter_first(&first, sums);
    }

    pub fn scatter_first<R: Real>(&self, first: &FirstDerivatives<R, N, M>, sums: &mut Sums<R>) {
        for (i, &coordinate) in self.q.iter().enumerate() {
            sums.l_v[coordinate] += first.l_v[i];
            sums.force[coordinate] += first.force[i];
        }
        for (j, phi_dot) in first.phi_dot.iter().enumerate() {
            sums.phi_dot[self.sigma[j]] += *phi_dot;
        }
    }

    /// Whether its derivatives with respect to inputs must be asked for at every node.
    pub fn has_input_derivatives(&self) -> bool {
        self.plan.timed || self.plan.bound || K > 0 && !self.plan.constant
    }

    /// Whether its derivatives vary within a step, other than as sines of angles, whose turns are looked at themselves.
    pub fn may_bend(&self) -> bool {
        self.plan.timed || !self.plan.constant && !self.plan.sinusoidal
    }

    pub fn block_len(&self) -> usize {
        J::KIND.length(self.plan.count, M)
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
        let mut local = Local {
            q: real.q.map(Slope::from_re),
            v: real.v.map(Slope::from_re),
            sigma: real.sigma.map(Slope::from_re),
            u: real.u.map(Slope::from_re),
            t: Slope::from_re(real.t),
        };
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
    fn pair<R: Number>(&self, first: &FirstDerivatives<R, N, M>, with: &Covector) -> R {
        let mut sum = R::zero();
        for (i, &coordinate) in self.q.iter().enumerate() {
            sum += first.l_v[i] * with.c[coordinate] + first.force[i] * with.d[coordinate];
        }
        for (j, phi_dot) in first.phi_dot.iter().enumerate() {
            sum += *phi_dot * with.e[self.sigma[j]];
        }
        sum
    }

    /// What happens to that sum between the ends of a step, where derivatives are along it.
    pub fn within(&self, ends: &[NodeView<Dual64>; 2], with: &Covector) -> Within {
        let [begin, end] = ends.map(|at| self.pair(&self.jet.first(&self.local(&at), &self.b(at.design)), with));
        let (change, told) = (end.re - begin.re, 0.5 * (begin.eps + end.eps));
        Within { missed: change - told, change: change.abs().max(told.abs()) }
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
        let of_design = || (0..P).filter(design).find_map(|p| self.b[p].design()).map(|(p, _)| Argument::Design(p));
        of_control.or_else(|| (self.plan.timed && time()).then_some(Argument::Time)).or_else(of_design)
    }

    pub fn pull_back_inputs(&self, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows) {
        if !self.plan.constant {
            *rows.evaluations += K;
            for (k, &channel) in self.u.iter().enumerate() {
                rows.u[channel] += self.directional(at, with, |local, _| local.u[k] = local.u[k].derivative(0));
            }
        }
        if self.plan.timed {
            *rows.evaluations += 1;
            *rows.time += self.directional(at, with, |local, _| local.t = local.t.derivative(0));
        }
        if self.plan.bound {
            for (p, b) in self.b.iter().enumerate() {
                if let Some((design, factor)) = b.design() {
                    *rows.evaluations += 1;
                    rows.design[design] += factor * self.directional(at, with, |_, b| b[p] = b[p].derivative(0));
                }
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
        if self.plan.timed {
            *rows.evaluations += 1;
            *rows.time += directional(Slope::from_re(at.t).derivative(0), &b);
        }
        for (p, constant) in self.b.iter().enumerate() {
            if let Some((design, factor)) = constant.design() {
                *rows.evaluations += 1;
                let mut moved = b;
                moved[p] = moved[p].derivative(0);
                rows.design[design] += factor * directional(Slope::from_re(at.t), &moved);
            }
        }
    }

    /// Blocks of an element with constant second derivatives, and the constant columns of Φ_q of any constraint.
    ///
    /// The former is a polynomial, which has its constants at zero; the latter may be defined only where a motion can start.
    pub fn add_constants(&self, start: &NodeView<f64>, into: &mut Constants) {
        if J::KIND == ElementKind::Holonomic {
            self.add_linear_columns(start, into);
            return;
        }
        if !self.plan.constant {
            return;
        }
        let mut first = FirstDerivatives::zero();
        let mut blocks = vec![0.0; J::KIND.length(N, M)];
        let b = self.b(start.design);
        self.jet.blocks::<N>(&Plan::<N>::default().seeds(), &Local::zeros(), &b, &mut first, &mut blocks);
        into.add_squares(J::KIND, &self.q, &blocks);
        into.add_first(&self.q, first.l_v.as_slice(), first.force.as_slice());
        for (k, &channel) in self.u.iter().enumerate() {
            let mut local: Local<Slope, N, M, K> = Local::zeros();
            local.u[k] = local.u[k].derivative(0);
            let first = self.jet.first(&local, &b.map(Slope::from_re));
            for (i, &coordinate) in self.q.iter().enumerate() {
                into.add_control(coordinate, channel, slope(&first.force[i]));
            }
        }
    }

    /// The columns of Φ_q that belong to coordinates in which Φ is linear.
    fn add_linear_columns(&self, start: &NodeView<f64>, into: &mut Constants) {
        let q = SVector::from_fn(|i, _| start.q[self.q[i]]);
        for i in self.plan.linear_columns() {
            self.phi_q_column(i, &q, start.t, start.design, &mut |e| into.add_phi_q(e));
        }
        for &i in self.plan.active[..self.plan.count].iter().filter(|_| self.plan.sinusoidal) {
            self.add_waves(i, start, into);
        }
    }

    /// Reads a, α, β of a q + α sin q + β cos q off its slopes a + α cos q − β sin q at q = 0, π/2 and π.
    fn add_waves(&self, i: usize, start: &NodeView<f64>, into: &mut Constants) {
        let mut q = SVector::zeros();
        let mut slopes = [SVector::<f64, M>::zeros(); 3];
        for (quarter, slope) in slopes.iter_mut().enumerate() {
            q[i] = quarter as f64 * FRAC_PI_2;
            let mut row = 0..M;
            self.phi_q_column(i, &q, start.t, start.design, &mut |e| row.by_ref().take(1).for_each(|j| slope[j] = e.value));
        }
        for (j, &equation) in self.sigma.iter().enumerate() {
            let [at_0, at_90, at_180] = slopes.map(|slope| slope[j]);
            // π is not exact in binary: what is left of a zero coefficient is rounding.
            let rounding = 4.0 * f64::EPSILON * at_0.abs().max(at_90.abs()).max(at_180.abs());
            let clean = |x: f64| if x.abs() <= rounding { 0.0 } else { x };
            let linear = clean(0.5 * (at_0 + at_180));
            let (sine, cosine) = (clean(0.5 * (at_0 - at_180)), clean(linear - at_90));
            into.waves.push(SinusoidalTerm { coordinate: self.q[i], equation, sine, cosine });
            into.add_phi_q(Entry { row: equation, col: self.q[i], value: linear });
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
