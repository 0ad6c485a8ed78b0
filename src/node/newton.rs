//! One step of the trapezoidal rule, solved by Newton's method (Eq. 2–4).
//!
//! With the half step h = Δt/2, the step from node i−1 to i reads
//!
//! ```text
//!   E1  q − q₋ − h (v + v₋) = 0          E3  𝓛_v(q, v, σ) − p* = 0           E5  dΦ/dt(q, v) = 0
//!   E2  p* − p*₋ − h (g + g₋) = 0        E4  𝓛_q(q, v, σ) + Q(q, v, u) − g = 0
//! ```
//!
//! E1, E2 and E4 give q, p* and g = ṗ* by substitution. There remain n + m equations in x = (v, σ),
//!
//! ```text
//!   r_v = 𝓛_v − h (𝓛_q + Q) − (p*₋ + h g₋) = 0,      r_σ = dΦ/dt = 0,      K = ∂(r_v, r_σ)/∂(v, σ)
//! ```
//!
//! Node 0 satisfies the same equations with h = 0.
//!
//! In r(x) = k + L x + N(x), with L linear, only N is evaluated at every iteration: after a correction δ
//!
//! ```text
//!   −r(x + δ) = ℓ − N(x + δ),      ℓ(x + δ) = ℓ(x) − L δ,      ℓ(x) = −(k + L x)
//! ```
//!
//! where the terms L δ are as small as the correction and lose no digits. The unknowns that occur in L alone (condensed ones) are eliminated before
//! the first iteration and computed after the last.

use super::convergence::Convergence;
use super::line::Line;
use super::linearisation::Linearisation;
use super::sizes::Sizes;
use crate::linear::{BlockLu, Factorization};
use crate::motion::Report;
use crate::node::{StepFailure, Unknowns};
use crate::number::{add, all_finite, larger};
use crate::system::{Given, KnownPart};
use crate::{Settings, System};

/// A residual below this fraction of its terms, times the square root of the number of unknowns, is rounding: errors add up along a chain.
const ROUNDING: f64 = 2e-15;
/// Velocities below this fraction of those that the momenta alone would give are small: v is a difference of such terms, and has their rounding error.
pub(crate) const SMALL: f64 = 1e-2;

/// Velocities below this fraction of those that the momenta alone would give may be rounding, and no guess is expected to predict them.
pub(crate) const STILL: f64 = 1e-10;

/// Corrections below this fraction of the largest velocity or coordinate are rounding once they have stopped shrinking.
const ULPS: f64 = 1e3 * f64::EPSILON;

/// A solution whose velocities differ from the guess by more than this multiple of the sizes before it belongs to another motion …
const FAR: f64 = 10.0;
/// … if Newton's method needed more iterations than this.
pub(super) const DIRECT: usize = 3;

/// Size of the change of the velocities by the first correction of a step, and their size in the guess; infinite for a guess at rest.
pub(crate) struct Miss {
    pub(crate) change: f64,
    pub(crate) guess: f64,
}

/// Newton's method for the steps of one system; all vectors are in the solver's order, the condensed unknowns first.
pub(crate) struct Newton<F = BlockLu> {
    /// The equations at the iterate (v, σ), whose condensed unknowns are computed at the end, with −r, then a correction, in `delta`.
    pub(crate) linearisation: Linearisation<F>,
    /// The relative residual below which a residual is rounding.
    pub(super) rounding: f64,
    /// −k, reduced, for the condensed unknowns, and ℓ for the others.
    pub(super) linear: Vec<f64>,
    /// Points along a correction.
    pub(super) line: Line,
    /// |v| and |σ| in the weighted maximum norm, with which corrections are compared.
    pub(super) size: Sizes,
    /// Lower bound of these sizes in comparisons.
    pub(super) floor: f64,
    /// Miss of the guess of the last step.
    pub(crate) miss: Miss,
}

impl<F: Factorization> Newton<F> {
    pub(crate) fn new(system: &System) -> Self {
        let size = system.n() + system.m();
        Newton {
            linearisation: Linearisation::new(system),
            rounding: ROUNDING * (size as f64).sqrt(),
            linear: vec![0.0; size],
            line: Line::new(size),
            size: Sizes::default(),
            floor: 0.0,
            miss: Miss { change: 0.0, guess: 0.0 },
        }
    }

    /// Solves a step; on return `y` is its solution and the evaluation's blocks belong to it.
    pub(crate) fn solve_step(
        &mut self,
        system: &System,
        from: &KnownPart,
        given: Given,
        y: &mut Unknowns,
        settings: &Settings,
        report: &mut Report,
    ) -> Result<(), StepFailure> {
        let mut scale = self.begin(system, from, given, y, report)?;
        let mut convergence = Convergence::new(
            settings.tolerance,
            self.rounding,
            self.linearisation.weights.of_residual(&self.linearisation.delta),
        );
        let guess = self.size.v;
        for iteration in 1..=settings.max_iterations {
            let (change, correction) = self.correct(system, from.h, convergence.may_reuse, report)?;
            if iteration == 1 {
                let is_at_rest = guess <= STILL * scale;
                self.miss = Miss { change, guess: if is_at_rest { f64::INFINITY } else { guess } };
            }
            if convergence.may_be_noise(correction) {
                convergence.is_noise = self.is_noise(system, from, given, report);
                if !convergence.is_noise {
                    return self.solve_step_damped(system, from, given, y, (settings, 0.0), report);
                }
            }
            self.residual(system, from, given, report);
            report.newton_iterations += 1;
            report.most_iterations = report.most_iterations.max(iteration);
            if scale == 0.0 {
                scale = self.scale_at_rest();
            }
            // Momentum equations are compared with their terms, velocity constraints with the velocities.
            let terms = Sizes { v: scale, sigma: larger(self.size.v, self.floor) };
            if convergence.is_reached(
                correction,
                self.linearisation.weights.of_residual(&self.linearisation.delta),
                terms,
                self.size.sigma,
            ) {
                if iteration > DIRECT {
                    let size = larger(self.size.v, scale);
                    self.see_that_it_is_near(system, from, (y.v, size), (iteration, convergence.residual))?;
                }
                return self.finish(system, from, given, y, report);
            }
        }
        Err(self.diverged(system, settings.max_iterations, convergence.residual, None))
    }

    /// Size of the terms of momentum equations if the motion begins at rest without forces: then only driven joints cause momentum.
    #[cold]
    pub(super) fn scale_at_rest(&self) -> f64 {
        let linear = self.linearisation.matrix.largest_constant_product(&self.linearisation.x, |k| {
            self.linearisation.weights.of_equation(self.linearisation.condensed + k)
        });
        linear.max(self.linearisation.weights.of_residual(&self.linear).v)
    }

    /// True if the last correction is within the rounding of velocities or coordinates.
    #[cold]
    pub(super) fn is_rounding(&self, system: &System, from: &KnownPart) -> bool {
        let (mut change, mut v, mut q) = (0.0f64, 0.0f64, 0.0f64);
        let free = |(position, _): &(&usize, &f64)| **position >= self.linearisation.condensed;
        for (&position, start) in system.positions().v.iter().zip(from.q).filter(free) {
            change = change.max(self.linearisation.delta[position].abs());
            v = v.max(self.linearisation.x[position].abs());
            q = q.max((start + from.h * self.linearisation.x[position]).abs());
        }
        change <= ULPS * v || from.h.abs() * change <= ULPS * q
    }

    /// True if the last correction is rounding, or if no small fraction of it reduces the residual as predicted.
    #[cold]
    fn is_noise(&mut self, system: &System, from: &KnownPart, given: Given, report: &mut Report) -> bool {
        self.is_rounding(system, from) || !self.is_smooth_before(system, from, given, report)
    }

    /// Rejects a solution whose velocities are far from their guess, relative to `size`.
    #[cold]
    pub(super) fn see_that_it_is_near(
        &self,
        system: &System,
        from: &KnownPart,
        (guess, size): (&[f64], f64),
        (iteration, residual): (usize, f64),
    ) -> Result<(), StepFailure> {
        // In a step of length zero velocities may jump.
        if from.h == 0.0 {
            return Ok(());
        }
        let jump = self.distance(system, guess) / size;
        if jump > FAR { Err(self.diverged(system, iteration, residual, Some(jump))) } else { Ok(()) }
    }

    // The following functions are part of the loop above, which is the hot path; damped steps call them, too.

    /// Computes ℓ and −r at the first guess; returns the size of the terms in r, p*₋ + h g₋.
    #[inline(always)]
    pub(super) fn begin(
        &mut self,
        system: &System,
        from: &KnownPart,
        given: Given,
        y: &Unknowns,
        report: &mut Report,
    ) -> Result<f64, StepFailure> {
        self.linearisation.load(system, y.v, y.sigma);
        self.size = self.linearisation.weights.of_all(&self.linearisation.x);
        self.linearisation
            .evaluation
            .set_step(system, from.h, &mut self.linearisation.matrix)
            .map_err(StepFailure::Singular)?;
        self.linearisation.evaluation.step_constants(system, from, given, &mut self.linear);
        self.linearisation.delta.fill(0.0);
        self.linearisation.evaluation.subtract_nonlinear(
            system,
            from,
            given,
            &self.linearisation.x,
            &mut self.linearisation.delta,
            report,
        );
        if self.linearisation.evaluation.has_elements() {
            // N depends at most on time in the rows of condensed unknowns, so it is known there.
            add(&mut self.linear[..self.linearisation.condensed], &self.linearisation.delta);
        }
        self.linearisation.matrix.reduce(&mut self.linear);
        self.linearisation.matrix.subtract_constant_product(&self.linearisation.x, &mut self.linear);
        let free = self.linearisation.condensed..;
        add(&mut self.linearisation.delta[free.clone()], &self.linear[free]);
        let scale = self.linearisation.weights.of_momenta(from.p_star);
        self.floor = SMALL * scale;
        Ok(scale)
    }

    /// One correction of the unknowns that are not condensed, K δ = −r and x += δ; returns the size of its velocities, and its relative size.
    ///
    /// K belongs to the current point or, if its factors suffice, to the previous one.
    #[inline(always)]
    pub(super) fn correct(
        &mut self,
        system: &System,
        h: f64,
        old_factors: bool,
        report: &mut Report,
    ) -> Result<(f64, f64), StepFailure> {
        if old_factors {
            report.reused_factors += 1;
            self.linearisation.matrix.solve_reduced(system.symbolic(), &mut self.linearisation.delta);
        } else {
            self.linearisation.evaluation.second(system, report);
            self.linearisation.evaluation.assemble(
                system,
                h,
                &self.linearisation.evaluation.blocks,
                &mut self.linearisation.matrix,
            );
            report.factorisations += 1;
            let solved =
                self.linearisation.matrix.factor_and_solve_reduced(system.symbolic(), &mut self.linearisation.delta);
            solved.map_err(StepFailure::Singular)?;
            self.linearisation.watch_pivots(report);
        }
        let free = self.linearisation.condensed..;
        add(&mut self.linearisation.x[free.clone()], &self.linearisation.delta[free]);
        if self.size.v == 0.0 || self.size.sigma == 0.0 {
            self.size = self.linearisation.weights.of(&self.linearisation.x);
        }
        self.linearisation.matrix.subtract_constant_product(&self.linearisation.delta, &mut self.linear);
        let change = self.linearisation.weights.of(&self.linearisation.delta);
        Ok((change.v, change.relative_to(self.size.at_least(self.floor))))
    }

    /// −r = ℓ − N(x).
    #[inline(always)]
    pub(super) fn residual(&mut self, system: &System, from: &KnownPart, given: Given, report: &mut Report) {
        let free = self.linearisation.condensed..;
        self.linearisation.delta[free.clone()].copy_from_slice(&self.linear[free]);
        self.linearisation.evaluation.subtract_nonlinear(
            system,
            from,
            given,
            &self.linearisation.x,
            &mut self.linearisation.delta,
            report,
        );
    }

    /// Computes the second derivatives, the condensed unknowns, q and 𝓛_q + Q at the solution.
    #[inline(always)]
    pub(super) fn finish(
        &mut self,
        system: &System,
        from: &KnownPart,
        given: Given,
        y: &mut Unknowns,
        report: &mut Report,
    ) -> Result<(), StepFailure> {
        self.linearisation.evaluation.second(system, report);
        self.linearisation.x[..self.linearisation.condensed].copy_from_slice(&self.linear[..self.linearisation.condensed]);
        self.linearisation.matrix.expand(&mut self.linearisation.x);
        let positions = system.positions();
        for ((v, q), (&position, start)) in y.v.iter_mut().zip(y.q.iter_mut()).zip(positions.v.iter().zip(from.q)) {
            *v = self.linearisation.x[position];
            *q = start + from.h * *v;
        }
        y.sigma.iter_mut().zip(&positions.sigma).for_each(|(sigma, &position)| *sigma = self.linearisation.x[position]);
        self.linearisation.evaluation.force(y.q, y.v, given, y.p_star_dot);
        let finite = all_finite(y.p_star_dot) && all_finite(y.q) && all_finite(y.sigma);
        if finite { Ok(()) } else { Err(StepFailure::NotFinite) }
    }

    /// The largest weighted difference between the computed velocities and the first guess, without condensed ones.
    fn distance(&self, system: &System, guess: &[f64]) -> f64 {
        let positions = system.positions().v.iter().zip(guess);
        let differences = positions.map(|(&position, guess)| {
            if position < self.linearisation.condensed { 0.0 } else { self.linearisation.x[position] - guess }
        });
        self.linearisation.weights.of_velocities(differences)
    }

    pub(super) fn diverged(&self, system: &System, iterations: usize, residual: f64, jump: Option<f64>) -> StepFailure {
        let size = |position: &usize| {
            self.linearisation.delta[*position].abs() * self.linearisation.weights.of_any_equation(*position)
        };
        let free = self.linearisation.condensed..self.linearisation.delta.len();
        let worst = free.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let positions = system.positions();
        let all = positions.v.iter().chain(&positions.sigma);
        let unknown = all.clone().position(|&position| position == worst).unwrap_or(0);
        StepFailure::Diverged { iterations, residual, unknown, jump }
    }
}
