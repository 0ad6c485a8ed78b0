//! One step of the trapezoidal rule, solved by Newton's method (Eq. 2–4).
//!
//! With the half step h = Δt/2, the step from node i−1 to i reads
//!
//! ```text
//!   E1  q − q₋ − h (v + v₋) = 0          E3  𝓛_v(q, v, σ) − p* = 0           E5  dΦ/dt(q, v) = 0
//!   E2  p* − p*₋ − h (g + g₋) = 0        E4  𝓛_q(q, v, σ) + Q(q, v, u) − g = 0
//! ```
//!
//! E1, E2 and E4 give q, p* and g = ṗ* by insertion. What remains are n + m equations in x = (v, σ),
//!
//! ```text
//!   r_v = 𝓛_v − h (𝓛_q + Q) − (p*₋ + h g₋) = 0,      r_σ = dΦ/dt = 0,      K = ∂(r_v, r_σ)/∂(v, σ)
//! ```
//!
//! Node 0 is the same with h = 0.
//!
//! Newton's method on r = L + N, with L linear and K = L′ + N′: after a correction δ with K δ = −r, the new residual is
//!
//! ```text
//!   r(x + δ) = N(x + δ) − N(x) − N′(x) δ
//! ```
//!
//! So L is evaluated once per step, at the first guess; and the unknowns that occur in L alone (condensed ones) are eliminated before the
//! first iteration and found after the last.

use crate::evaluation::Evaluation;
use crate::linear::{BlockLu, Breakdown};
use crate::system::{At, Pair};
use crate::trajectory::Report;
use crate::{Settings, System};

/// Where a step begins, as far as its equations need it: q₋ + h v₋, p*₋ + h g₋, and h.
pub(crate) struct StepStart<'a> {
    pub(crate) h: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p_star: &'a [f64],
}

/// The unknowns of a step and what follows from them; v and σ hold the first guess.
pub(crate) struct Unknowns<'a> {
    pub(crate) q: &'a mut [f64],
    pub(crate) v: &'a mut [f64],
    pub(crate) sigma: &'a mut [f64],
    /// 𝓛_q + Q.
    pub(crate) p_star_dot: &'a mut [f64],
}

/// What stays the same in a step.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) u: &'a [f64],
    pub(crate) t: f64,
    pub(crate) design: &'a [f64],
}

/// Why a step has no solution.
pub(crate) enum StepFailure {
    Singular(Breakdown),
    Diverged { iterations: usize, residual: f64, equation: usize },
    NotFinite,
}

/// Where one unknown stands among the velocities or multipliers and in the solver's order.
#[derive(Clone, Copy)]
struct Place {
    index: usize,
    position: usize,
}

/// Newton's method for the steps of one system, with its memory.
pub(crate) struct Newton {
    pub(crate) evaluation: Evaluation,
    pub(crate) matrix: BlockLu,
    /// The velocities and multipliers that are iterated on, and those that are condensed.
    velocities: Vec<Place>,
    multipliers: Vec<Place>,
    condensed_velocities: Vec<Place>,
    condensed_multipliers: Vec<Place>,
    /// −r, then a correction, in the solver's order; and −r as it was reduced first.
    x: Vec<f64>,
    reduced: Vec<f64>,
    /// N at the point before, δ, N′ δ and Σ δ.
    before: Pair,
    delta: Pair,
    product: Pair,
    total: Pair,
}

/// The size of a residual, relative to the largest term in it.
#[derive(Clone, Copy)]
struct Residual {
    relative: f64,
    equation: usize,
}

impl Newton {
    pub(crate) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        let symbolic = system.symbolic();
        let places = |range: std::ops::Range<usize>, condensed: bool| -> Vec<Place> {
            let first = range.start;
            let all = range.map(|unknown| Place { index: unknown - first, position: symbolic.position(unknown) });
            all.filter(|place| (place.position < symbolic.condensed()) == condensed).collect()
        };
        Newton {
            evaluation: Evaluation::new(system),
            matrix: BlockLu::new(symbolic),
            velocities: places(0..n, false),
            multipliers: places(n..n + m, false),
            condensed_velocities: places(0..n, true),
            condensed_multipliers: places(n..n + m, true),
            x: vec![0.0; n + m],
            reduced: vec![0.0; n + m],
            before: Pair::new(n, m),
            delta: Pair::new(n, m),
            product: Pair::new(n, m),
            total: Pair::new(n, m),
        }
    }

    /// Assembles K(h) from given derivatives and factors it.
    pub(crate) fn factor(
        &mut self,
        system: &System,
        h: f64,
        blocks: &[f64],
        at: (&[f64], &[f64]),
        report: &mut Report,
    ) -> Result<(), Breakdown> {
        self.evaluation.set_step(system, h, &mut self.matrix)?;
        self.evaluation.assemble(system, h, blocks, at, &mut self.matrix);
        report.factorisations += 1;
        self.matrix.factor(system.symbolic())?;
        report.worst_pivot = report.worst_pivot.min(self.matrix.worst_pivot());
        Ok(())
    }

    /// Solves K x = r in place; r and x are given by unknown (v, then σ).
    pub(crate) fn solve(&mut self, system: &System, x: &mut [f64]) {
        self.in_solver_order(system, x, |matrix, x| matrix.solve(system.symbolic(), x));
    }

    /// Solves Kᵀ x = r in place.
    pub(crate) fn solve_transposed(&mut self, system: &System, x: &mut [f64]) {
        self.in_solver_order(system, x, |matrix, x| matrix.solve_transposed(system.symbolic(), x));
    }

    fn in_solver_order(&mut self, system: &System, x: &mut [f64], solve: impl Fn(&BlockLu, &mut [f64])) {
        let position = |unknown| system.symbolic().position(unknown);
        x.iter().enumerate().for_each(|(unknown, r)| self.x[position(unknown)] = *r);
        solve(&self.matrix, &mut self.x);
        x.iter_mut().enumerate().for_each(|(unknown, x)| *x = self.x[position(unknown)]);
    }

    /// Solves a step; on return `y` is its solution and the evaluation's blocks belong to it.
    pub(crate) fn solve_step(
        &mut self,
        system: &System,
        from: &StepStart,
        given: Given,
        y: &mut Unknowns,
        settings: &Settings,
        report: &mut Report,
    ) -> Result<(), StepFailure> {
        let scale = self.begin(system, from, given, y, report)?;
        let (mut last, mut residual) = (f64::INFINITY, self.residual(scale));
        for iteration in 1..=settings.max_iterations {
            let correction = self.correct(system, from.h, y, report)?;
            self.evaluate(system, from, given, y, report);
            self.next_residual(from.h);
            report.newton_iterations += 1;
            report.most_iterations = report.most_iterations.max(iteration);
            let before = std::mem::replace(&mut residual, self.residual(scale));
            // Near rounding level the corrections stop shrinking: then nothing is left to gain.
            let stalled = correction > 0.25 * last && before.relative < settings.rounding;
            if correction <= settings.tolerance || stalled {
                report.worst_correction = report.worst_correction.max(correction);
                report.worst_residual = report.worst_residual.max(residual.relative);
                return self.finish(system, from, given, y);
            }
            last = correction;
        }
        let Residual { relative, equation } = residual;
        Err(StepFailure::Diverged { iterations: settings.max_iterations, residual: relative, equation })
    }

    /// Evaluates everything at the first guess and reduces −r; returns the size of the terms in r.
    fn begin(
        &mut self,
        system: &System,
        from: &StepStart,
        given: Given,
        y: &mut Unknowns,
        report: &mut Report,
    ) -> Result<f64, StepFailure> {
        let h = from.h;
        for ((q, &start), &v) in y.q.iter_mut().zip(from.q).zip(y.v.iter()) {
            *q = start + h * v;
        }
        self.evaluate(system, from, given, y, report);
        for &Place { index, .. } in &self.velocities {
            self.before.v[index] = self.evaluation.sums.l_v[index] - h * self.evaluation.sums.force[index];
        }
        for &Place { index, .. } in &self.multipliers {
            self.before.sigma[index] = self.evaluation.sums.phi_dot[index];
        }
        self.total.clear();
        let at = At { q: y.q, v: y.v, sigma: y.sigma, u: given.u, t: given.t, design: given.design };
        self.evaluation.constants.add(&at, &mut self.evaluation.sums);

        let (sums, mut scale) = (&self.evaluation.sums, 0.0f64);
        for &Place { index, position } in self.velocities.iter().chain(&self.condensed_velocities) {
            let (start, l_v, force) = (from.p_star[index], sums.l_v[index], h * sums.force[index]);
            self.x[position] = start + force - l_v;
            scale = scale.max(start.abs()).max(l_v.abs()).max(force.abs());
        }
        for &Place { index, position } in self.multipliers.iter().chain(&self.condensed_multipliers) {
            self.x[position] = -sums.phi_dot[index];
        }
        self.evaluation.set_step(system, h, &mut self.matrix).map_err(StepFailure::Singular)?;
        self.matrix.reduce(system.symbolic(), &mut self.x);
        self.reduced.copy_from_slice(&self.x);
        Ok(scale)
    }

    /// N at the present point, with q = q₋ + h (v₋ + v) where N depends on it.
    fn evaluate(&mut self, system: &System, from: &StepStart, given: Given, y: &mut Unknowns, report: &mut Report) {
        for &Place { index, .. } in &self.velocities {
            y.q[index] = from.q[index] + from.h * y.v[index];
        }
        let at = At { q: y.q, v: y.v, sigma: y.sigma, u: given.u, t: given.t, design: given.design };
        self.evaluation.nonlinear(system, &at, report);
    }

    /// One correction, K δ = −r and x += δ; returns its relative size.
    fn correct(&mut self, system: &System, h: f64, y: &mut Unknowns, report: &mut Report) -> Result<f64, StepFailure> {
        let at = (&*y.v, &*y.sigma);
        self.evaluation.assemble(system, h, &self.evaluation.blocks, at, &mut self.matrix);
        report.factorisations += 1;
        let solved = self.matrix.factor_and_solve_reduced(system.symbolic(), &mut self.x);
        solved.map_err(StepFailure::Singular)?;
        report.worst_pivot = report.worst_pivot.min(self.matrix.worst_pivot());
        load(&self.velocities, &self.x, &mut self.delta.v, &mut self.total.v);
        load(&self.multipliers, &self.x, &mut self.delta.sigma, &mut self.total.sigma);
        self.evaluation.multiply(system, h, at, &self.delta, &mut self.product);
        let velocity = add(&self.velocities, &self.delta.v, y.v);
        let multiplier = add(&self.multipliers, &self.delta.sigma, y.sigma);
        let correction = velocity.max(multiplier);
        if correction.is_finite() { Ok(correction) } else { Err(StepFailure::NotFinite) }
    }

    /// −r = N(x − δ) + N′(x − δ) δ − N(x).
    fn next_residual(&mut self, h: f64) {
        let sums = &self.evaluation.sums;
        for &Place { index, position } in &self.velocities {
            let now = sums.l_v[index] - h * sums.force[index];
            self.x[position] = self.before.v[index] + self.product.v[index] - now;
            self.before.v[index] = now;
        }
        for &Place { index, position } in &self.multipliers {
            let now = sums.phi_dot[index];
            self.x[position] = self.before.sigma[index] + self.product.sigma[index] - now;
            self.before.sigma[index] = now;
        }
    }

    /// The largest momentum residual relative to the largest term at the first guess.
    fn residual(&self, scale: f64) -> Residual {
        let mut worst = Residual { relative: 0.0, equation: 0 };
        for &Place { index, position } in &self.velocities {
            let r = self.x[position].abs();
            if r > worst.relative || r.is_nan() {
                worst = Residual { relative: r, equation: index };
            }
        }
        if worst.relative > 0.0 { Residual { relative: worst.relative / scale, ..worst } } else { worst }
    }

    /// The condensed unknowns, q and 𝓛_q + Q at the solution.
    fn finish(&mut self, system: &System, from: &StepStart, given: Given, y: &mut Unknowns) -> Result<(), StepFailure> {
        self.x.copy_from_slice(&self.reduced);
        self.velocities.iter().for_each(|at| self.x[at.position] = self.total.v[at.index]);
        self.multipliers.iter().for_each(|at| self.x[at.position] = self.total.sigma[at.index]);
        self.matrix.expand(system.symbolic(), &mut self.x);
        for &Place { index, position } in &self.condensed_velocities {
            y.v[index] += self.x[position];
            y.q[index] = from.q[index] + from.h * y.v[index];
        }
        self.condensed_multipliers.iter().for_each(|at| y.sigma[at.index] += self.x[at.position]);
        y.p_star_dot.copy_from_slice(&self.evaluation.sums.force);
        let at = At { q: y.q, v: y.v, sigma: y.sigma, u: given.u, t: given.t, design: given.design };
        self.evaluation.constants.add_force(&at, y.p_star_dot);
        let finite = y.p_star_dot.iter().chain(y.q.iter()).all(|x| x.is_finite());
        if finite { Ok(()) } else { Err(StepFailure::NotFinite) }
    }
}

/// Takes corrections out of the solver's order and adds them up.
fn load(places: &[Place], x: &[f64], delta: &mut [f64], total: &mut [f64]) {
    for &Place { index, position } in places {
        delta[index] = x[position];
        total[index] += x[position];
    }
}

/// Adds a correction and returns its size relative to the result, in the maximum norm.
fn add(places: &[Place], delta: &[f64], x: &mut [f64]) -> f64 {
    let (mut change, mut size) = (0.0f64, 0.0f64);
    for &Place { index, .. } in places {
        let delta = delta[index];
        x[index] += delta;
        // `max` would swallow a NaN.
        change = if delta.is_finite() { change.max(delta.abs()) } else { f64::INFINITY };
        size = size.max(x[index].abs());
    }
    if change == 0.0 { 0.0 } else { change / size }
}
