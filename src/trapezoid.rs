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
//! with the tangent matrix K(h) of [`tangent`](crate::system). Node 0 is the same with h = 0.

use crate::linear::{BlockLu, Breakdown};
use crate::system::{At, Constants, Sums};
use crate::trajectory::Report;
use crate::{Settings, System};

/// Where a step begins, as far as its equations need it: p*₋ + h g₋ and q₋ + h v₋, and h.
pub(crate) struct StepStart<'a> {
    pub(crate) h: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p_star: &'a [f64],
}

/// The unknowns of a step and the coordinates that follow from them.
pub(crate) struct Unknowns<'a> {
    pub(crate) q: &'a mut [f64],
    pub(crate) v: &'a mut [f64],
    pub(crate) sigma: &'a mut [f64],
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

/// The tangent matrix of a step, and everything a Newton iteration writes to.
pub(crate) struct Newton {
    matrix: BlockLu,
    /// The half step whose constant part the matrix holds.
    assembled_for: Option<f64>,
    pub(crate) constants: Constants,
    triplets: Vec<(usize, usize, f64)>,
    pub(crate) sums: Sums<f64>,
    pub(crate) blocks: Vec<f64>,
    /// Right-hand side, then correction, in the solver's order.
    x: Vec<f64>,
}

/// The last correction of a Newton iteration, relative to the unknowns.
struct Correction {
    relative: f64,
    residual: f64,
    equation: usize,
}

impl Newton {
    pub(crate) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        Newton {
            matrix: BlockLu::new(system.symbolic()),
            assembled_for: None,
            constants: Constants::new(n, m, system.k()),
            triplets: Vec::new(),
            sums: Sums::new(n, m),
            blocks: vec![0.0; system.block_len()],
            x: vec![0.0; n + m],
        }
    }

    /// Takes over the values of the design variables.
    pub(crate) fn set_design(&mut self, system: &System, design: &[f64]) {
        system.constants(design, &mut self.constants);
        self.assembled_for = None;
    }

    /// 𝓛_v, 𝓛_q + Q, dΦ/dt and all second derivatives at a point.
    pub(crate) fn evaluate(&mut self, system: &System, at: &At<f64>, report: &mut Report) {
        self.constants.write(at, &mut self.sums);
        let mut rest = &mut self.blocks[..];
        for batch in system.batches() {
            let (own, after) = rest.split_at_mut(batch.block_len());
            batch.evaluate(at, &mut self.sums, own);
            report.element_evaluations += batch.varying();
            rest = after;
        }
    }

    /// Assembles K(h) from second derivatives and factors it.
    pub(crate) fn factor(
        &mut self,
        system: &System,
        h: f64,
        blocks: Option<&[f64]>,
        report: &mut Report,
    ) -> Result<(), Breakdown> {
        if self.assembled_for != Some(h) {
            self.constants.tangent(h, &mut self.triplets);
            self.matrix.set_constant(system.symbolic(), &self.triplets)?;
            self.assembled_for = Some(h);
        }
        self.matrix.reset();
        let mut rest = blocks.unwrap_or(&self.blocks);
        for batch in system.batches() {
            let (own, after) = rest.split_at(batch.block_len());
            batch.scatter(own, h, self.matrix.values_mut());
            rest = after;
        }
        report.factorisations += 1;
        let result = self.matrix.factor(system.symbolic());
        report.worst_pivot = report.worst_pivot.min(self.matrix.worst_pivot());
        result
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

    /// Solves a step; on return q, v, σ are its solution, and `sums` and `blocks` belong to it.
    pub(crate) fn solve_step(
        &mut self,
        system: &System,
        from: &StepStart,
        given: Given,
        y: &mut Unknowns,
        settings: &Settings,
        report: &mut Report,
    ) -> Result<(), StepFailure> {
        let mut last = f64::INFINITY;
        for iteration in 1..=settings.max_iterations {
            self.evaluate_at(system, from, given, y, report);
            self.factor(system, from.h, None, report).map_err(StepFailure::Singular)?;
            let correction = self.correct(system, from, y);
            report.newton_iterations += 1;
            report.most_iterations = report.most_iterations.max(iteration);
            if !correction.relative.is_finite() {
                return Err(StepFailure::NotFinite);
            }
            // Near rounding level the corrections stop shrinking: then nothing is left to gain.
            let stalled = correction.relative > 0.25 * last && correction.residual < settings.rounding;
            if correction.relative <= settings.tolerance || stalled {
                report.worst_correction = report.worst_correction.max(correction.relative);
                self.evaluate_at(system, from, given, y, report);
                let (residual, _) = self.residual(from);
                report.worst_residual = report.worst_residual.max(residual);
                report.worst_phi_dot = self.sums.phi_dot.iter().fold(report.worst_phi_dot, |worst, r| worst.max(r.abs()));
                return if residual.is_finite() { Ok(()) } else { Err(StepFailure::NotFinite) };
            }
            last = correction.relative;
        }
        self.evaluate_at(system, from, given, y, report);
        let (residual, equation) = self.residual(from);
        Err(StepFailure::Diverged { iterations: settings.max_iterations, residual, equation })
    }

    fn evaluate_at(&mut self, system: &System, from: &StepStart, given: Given, y: &mut Unknowns, report: &mut Report) {
        for ((q, &start), &v) in y.q.iter_mut().zip(from.q).zip(y.v.iter()) {
            *q = start + from.h * v;
        }
        let at = At { q: y.q, v: y.v, sigma: y.sigma, u: given.u, t: given.t, design: given.design };
        self.evaluate(system, &at, report);
    }

    /// One Newton correction: K δ = −r, x += δ.
    fn correct(&mut self, system: &System, from: &StepStart, y: &mut Unknowns) -> Correction {
        let (residual, equation) = self.residual(from);
        let n = y.v.len();
        let position = |unknown| system.symbolic().position(unknown);
        for (i, start) in from.p_star.iter().enumerate() {
            self.x[position(i)] = start + from.h * self.sums.force[i] - self.sums.l_v[i];
        }
        for (j, phi_dot) in self.sums.phi_dot.iter().enumerate() {
            self.x[position(n + j)] = -phi_dot;
        }
        self.matrix.solve(system.symbolic(), &mut self.x);
        let v = add_correction(y.v, |i| self.x[position(i)]);
        let sigma = add_correction(y.sigma, |j| self.x[position(n + j)]);
        Correction { relative: v.max(sigma), residual, equation }
    }

    /// The largest residual relative to the largest term of its kind, and its equation.
    fn residual(&self, from: &StepStart) -> (f64, usize) {
        let (mut worst, mut scale, mut equation) = (0.0f64, 0.0f64, 0);
        for (i, start) in from.p_star.iter().enumerate() {
            let (l_v, force) = (self.sums.l_v[i], from.h * self.sums.force[i]);
            scale = scale.max(l_v.abs()).max(force.abs()).max(start.abs());
            let r = (l_v - force - start).abs();
            if r > worst || r.is_nan() {
                (worst, equation) = (r, i);
            }
        }
        if worst > 0.0 { (worst / scale, equation) } else { (worst, equation) }
    }
}

/// Adds a correction and returns its size relative to the result, in the maximum norm.
fn add_correction(x: &mut [f64], correction: impl Fn(usize) -> f64) -> f64 {
    let (mut change, mut size) = (0.0f64, 0.0f64);
    for (i, x) in x.iter_mut().enumerate() {
        let delta = correction(i);
        *x += delta;
        // `max` would swallow a NaN.
        change = if delta.is_finite() { change.max(delta.abs()) } else { f64::INFINITY };
        size = size.max(x.abs());
    }
    if change == 0.0 { 0.0 } else { change / size }
}
