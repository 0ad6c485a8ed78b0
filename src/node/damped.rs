//! Newton's method with corrections that are shortened until they pay.
//!
//! Where forces saturate within a step, as dry friction does, K tells nothing of what lies behind the bend, and whole corrections go to and fro between both
//! sides of it. Of every residual a part α is taken by a correction α δ if α is small enough, so α is halved until
//!
//! ```text
//!   |r(x + α δ)| ≤ (1 − α/4) |r(x)|
//! ```
//!
//! in the weighted maximum norm, or the residual may be rounding. It takes more evaluations than whole corrections where these converge, and is for steps in which they do not.

use super::convergence::{Convergence, STALLED};
use super::newton::{DIRECT, Newton};
use super::sizes::Sizes;
use super::step::{StepFailure, Unknowns};
use crate::linear::Factorization;
use crate::motion::Report;
use crate::number::{add, larger};
use crate::system::{Given, KnownPart};
use crate::{Settings, System};

/// What a correction must take of the residual, as a part of what it would take if there were no bends.
const ENOUGH: f64 = 0.25;
/// Corrections are not shortened to less than this part: there is no descent.
const SHORTEST: f64 = 1e-9;

impl<F: Factorization> Newton<F> {
    /// Solves a step as [`solve_step`](Self::solve_step) does, from guesses that are farther away, with the size of the velocities before it.
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
        let mut before = self.weights.of_residual(&self.delta);
        let mut convergence = Convergence::new(settings.tolerance, self.rounding, before);
        for iteration in 1..=settings.max_iterations {
            let (_, correction) = self.correct(system, from.h, false, report)?;
            self.direction.copy_from_slice(&self.delta);
            self.residual(system, from, given, report);
            if scale == 0.0 {
                scale = self.scale_at_rest();
            }
            let (terms, mut part) = (Sizes { v: scale, sigma: larger(self.size.v, self.floor) }, 1.0);
            // NaN is no descent, and of rounding nothing can be taken.
            let pays = |now: Sizes, part: f64| {
                now.relative_to(terms) <= STALLED.max((1.0 - ENOUGH * part) * before.relative_to(terms))
            };
            let mut now = self.weights.of_residual(&self.delta);
            let is_reached = convergence.is_reached(correction, now, terms, self.size.sigma);
            while !is_reached && !pays(now, part) && part > SHORTEST {
                part *= 0.5;
                self.step_back(part);
                self.residual(system, from, given, report);
                now = self.weights.of_residual(&self.delta);
            }
            if part <= SHORTEST {
                break;
            }
            if part < 1.0 {
                convergence.go_on_from(now);
            }
            report.newton_iterations += 1;
            report.most_iterations = report.most_iterations.max(iteration);
            if is_reached {
                if iteration > DIRECT {
                    let size = larger(larger(self.size.v, scale), size_before);
                    self.see_that_it_is_near(system, (y.v, size), (iteration, convergence.residual))?;
                }
                return self.finish(system, from, given, y, report);
            }
            before = now;
        }
        Err(self.diverged(system, settings.max_iterations, convergence.residual, None))
    }

    /// Takes so much of a correction back.
    fn step_back(&mut self, part: f64) {
        self.delta.iter_mut().zip(&self.direction).for_each(|(delta, whole)| *delta = -part * whole);
        let free = self.condensed..;
        add(&mut self.x[free.clone()], &self.delta[free]);
        self.matrix.subtract_constant_product(&self.delta, &mut self.linear);
    }
}
