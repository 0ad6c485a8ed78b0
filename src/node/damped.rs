//! Newton's method with corrections that are halved until the residual decreases enough.
//!
//! If forces saturate within a step, as dry friction does, K is not valid beyond the bend, and full corrections alternate between its two sides. A
//! correction α δ with small α reduces every residual by the fraction α, so α is halved until
//!
//! ```text
//!   |r(x + α δ)| ≤ (1 − α/4) |r(x)|
//! ```
//!
//! in the weighted maximum norm, or until the residual may be rounding. This needs more evaluations than full corrections where these converge, and
//! is used only for steps in which they do not.

use super::convergence::{Convergence, NOISE, STALLED};
use super::line::Line;
use super::newton::{DIRECT, Newton};
use super::sizes::Sizes;
use super::step::{StepFailure, Unknowns};
use crate::linear::Factorization;
use crate::motion::Report;
use crate::number::{add, larger};
use crate::system::{Given, KnownPart};
use crate::{Settings, System};

/// Required decrease of the residual, as a fraction of the decrease without bends.
const ENOUGH: f64 = 0.25;
/// Corrections are not shortened below this fraction: there is no descent …
const SHORTEST: f64 = 1e-9;
/// … and corrections that may be noise are not shortened below this one: they are rounding.
const SHORTEST_OF_NOISE: f64 = 1e-3;
/// Number of fractions of a correction at which the residual is evaluated, each a quarter of the previous one.
const PARTS: i32 = 7;

impl<F: Factorization> Newton<F> {
    /// Solves a step as [`solve_step`](Self::solve_step) does, but from more distant guesses. `size_before` is the size of the previous velocities.
    #[cold]
    pub(crate) fn solve_step_damped(
        &mut self,
        system: &System,
        from: &KnownPart,
        given: Given,
        y: &mut Unknowns,
        (settings, size_before): (&Settings, f64),
        report: &mut Report,
    ) -> Result<(), StepFailure> {
        let mut scale = self.begin(system, from, given, y, report)?;
        let mut before = self.linearisation.weights.of_residual(&self.linearisation.delta);
        let mut convergence = Convergence::new(settings.tolerance, self.rounding, before);
        for iteration in 1..=settings.max_iterations {
            self.line.begin(&self.linearisation.x, &self.linear);
            let (_, correction) = self.correct(system, from.h, false, report)?;
            self.line.direction.copy_from_slice(&self.linearisation.delta);
            convergence.is_noise = convergence.may_be_noise(correction) && self.is_rounding(system, from);
            self.residual(system, from, given, report);
            if scale == 0.0 {
                scale = self.scale_at_rest();
            }
            let (terms, mut part) = (Sizes { v: scale, sigma: larger(self.size.v, self.floor) }, 1.0);
            // NaN is no descent, and a residual that is rounding cannot decrease.
            let pays = |now: Sizes, part: f64| {
                now.relative_to(terms) <= STALLED.max((1.0 - ENOUGH * part) * before.relative_to(terms))
            };
            let mut now = self.linearisation.weights.of_residual(&self.linearisation.delta);
            let shortest = if correction <= NOISE { SHORTEST_OF_NOISE } else { SHORTEST };
            let mut is_reached = convergence.is_reached(correction, now, terms, self.size.sigma);
            while !is_reached && !pays(now, part) && part > shortest {
                part *= 0.5;
                self.take(part);
                self.residual(system, from, given, report);
                now = self.linearisation.weights.of_residual(&self.linearisation.delta);
            }
            if part <= shortest {
                if correction > NOISE {
                    break;
                }
                is_reached = true;
            }
            if part < 1.0 {
                convergence.go_on_from(now);
            }
            report.newton_iterations += 1;
            report.most_iterations = report.most_iterations.max(iteration);
            if is_reached {
                if iteration > DIRECT {
                    let size = larger(larger(self.size.v, scale), size_before);
                    self.see_that_it_is_near(system, from, (y.v, size), (iteration, convergence.residual))?;
                }
                return self.finish(system, from, given, y, report);
            }
            before = now;
        }
        Err(self.diverged(system, settings.max_iterations, convergence.residual, None))
    }

    /// True if a small fraction of the last correction reduces the residual as predicted by K. Corrections that do not shrink may then alternate
    /// across a bend; otherwise they are rounding.
    ///
    /// ```text
    ///   |r(x + α δ) − (1 − α) r(x)| ≤ α/4 |r(x)|      for some α and α/4
    /// ```
    #[cold]
    pub(super) fn is_smooth_before(&mut self, system: &System, from: &KnownPart, given: Given, report: &mut Report) -> bool {
        // From the end of the correction, which is restored below.
        self.line.begin(&self.linearisation.x, &self.linear);
        self.line.direction.copy_from_slice(&self.linearisation.delta);
        self.take(-1.0);
        self.residual(system, from, given, report);
        self.line.residual.copy_from_slice(&self.linearisation.delta);
        let before = self.linearisation.weights.of_residual(&self.linearisation.delta);
        let mut smooth = 0;
        for k in 1..=PARTS {
            let part = 0.25f64.powi(k);
            self.take(part - 1.0);
            self.residual(system, from, given, report);
            self.linearisation.delta.iter_mut().zip(&self.line.residual).for_each(|(r, before)| *r -= (1.0 - part) * before);
            let (off, most) = (self.linearisation.weights.of_residual(&self.linearisation.delta), 0.25 * part);
            smooth = if off.v <= most * before.v && off.sigma <= most * before.sigma { smooth + 1 } else { 0 };
            if smooth == 2 {
                break;
            }
        }
        self.take(0.0);
        smooth == 2
    }

    /// Moves to x + α δ, always from the stored x: subtracting the rest of a correction that is far too long would leave its rounding error.
    fn take(&mut self, part: f64) {
        let Line { direction, x, linear, .. } = &self.line;
        self.linearisation.x.copy_from_slice(x);
        self.linear.copy_from_slice(linear);
        self.linearisation.delta.iter_mut().zip(direction).for_each(|(delta, whole)| *delta = part * whole);
        let free = self.linearisation.condensed..;
        add(&mut self.linearisation.x[free.clone()], &self.linearisation.delta[free]);
        self.linearisation.matrix.subtract_constant_product(&self.linearisation.delta, &mut self.linear);
    }
}
