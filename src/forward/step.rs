//! The solution of one step, stage by stage.

use super::ForwardSweep;
use crate::motion::{column, column_mut};
use crate::node::{Predictor, StepFailure, Unknowns, warn_of_lost_digits};
use crate::system::{Given, KnownPart};
use crate::{Settings, System};

impl ForwardSweep {
    /// Solves all stages of the step that ends at a node.
    pub(super) fn step(&mut self, system: &System, node: usize, settings: &Settings) -> Result<(), StepFailure> {
        for s in 0..self.motion.trajectory.last_stage() {
            self.solve_stage(system, node, s + 1, settings)?;
        }
        Ok(())
    }

    // Not inlined, to avoid the overhead of a loop over one stage.
    #[inline(never)]
    fn solve_stage(&mut self, system: &System, node: usize, s: usize, settings: &Settings) -> Result<(), StepFailure> {
        let (dt, k) = (self.motion.inputs.grid.steps[node - 1], node - self.motion.first);
        self.stepper.begin_stage(&mut self.motion, k, s, dt);
        if !self.motion.trajectory.compliance.is_empty() {
            self.stepper.start_sigma.copy_from_slice(column(&self.motion.trajectory.sigma, k - 1));
        }
        // If a step is continued from zero, later stages are extrapolated from its beginning only.
        let is_jump = dt == 0.0;
        if is_jump {
            self.stepper.smooth_from = node;
        }
        let history = Predictor::MOST.min(k).min(node - self.stepper.smooth_from).max(1);
        if history == 1 && s == 1 && !is_jump && self.is_rough(k) {
            self.continue_from_zero(system, node, settings)?;
        } else {
            self.stepper.predictor.predict(
                &self.motion.inputs.grid.steps[node - history..node],
                &mut self.motion.trajectory,
                k,
                s,
            );
            match self.solve_at_hand::<false>(system, node, dt, settings) {
                Ok(()) if is_jump || !self.has_missed(k) => {}
                Err(failure) if is_jump || self.model_fault(system, node, &failure) => return Err(failure),
                _ => self.continue_from_zero(system, node, settings)?,
            }
        }
        if system.may_bend() && self.motion.trajectory.scheme.is_trapezoidal() {
            self.note_surprise(k, history);
        }
        Ok(())
    }

    /// Solves the current stage of a step of this length; if damped, corrections are halved until the residual decreases enough.
    pub(crate) fn solve_at_hand<const DAMPED: bool>(
        &mut self,
        system: &System,
        node: usize,
        dt: f64,
        settings: &Settings,
    ) -> Result<(), StepFailure> {
        let h = self.stepper.half_step(&self.motion.trajectory.scheme, dt);
        self.solve::<DAMPED>(system, node, h, settings)
    }

    /// Solves for (v, σ) of a node, with q = start_q + h v.
    pub(crate) fn solve_node(
        &mut self,
        system: &System,
        node: usize,
        h: f64,
        settings: &Settings,
    ) -> Result<(), StepFailure> {
        self.stepper.stage = self.motion.trajectory.last_stage();
        self.solve::<false>(system, node, h, settings)
    }

    /// Solves the node problem of the current stage, with the values in its columns as the guess.
    fn solve<const DAMPED: bool>(
        &mut self,
        system: &System,
        node: usize,
        h: f64,
        settings: &Settings,
    ) -> Result<(), StepFailure> {
        let (k, s) = (node - self.motion.first, self.stepper.stage);
        let from =
            KnownPart { h, q: &self.stepper.start_q, p_star: &self.stepper.start_p, sigma: &self.stepper.start_sigma };
        let design = self.motion.design.as_slice();
        let is_node = s == self.motion.trajectory.last_stage();
        let v_before = || column(&self.motion.trajectory.v, k - 1).iter().copied();
        let size_before = if DAMPED { self.stepper.newton.linearisation.weights.of_velocities(v_before()) } else { 0.0 };
        let columns = self.motion.trajectory.stage_mut(k, s);
        let u = if is_node { column(&self.motion.inputs.controls, node) } else { columns.u };
        let given = Given { u, t: *columns.time, design };
        let mut unknowns = Unknowns { q: columns.q, v: columns.v, sigma: columns.sigma, p_star_dot: columns.p_star_dot };
        let worst = self.monitor.report.worst_pivot;
        let (newton, report) = (&mut self.stepper.newton, &mut self.monitor.report);
        if DAMPED {
            newton.solve_step_damped(system, &from, given, &mut unknowns, (settings, size_before), report)?;
        } else {
            newton.solve_step(system, &from, given, &mut unknowns, settings, report)?;
        }
        for ((p_star, start), rate) in columns.p_star.iter_mut().zip(&self.stepper.start_p).zip(unknowns.p_star_dot.iter()) {
            *p_star = start + h * rate;
        }
        self.warn_of_lost_digits(system, node, worst);
        let at = self.motion.block_column(k, s);
        column_mut(&mut self.motion.blocks, at).copy_from_slice(&self.stepper.newton.linearisation.evaluation.blocks);
        Ok(())
    }

    pub(crate) fn warn_of_lost_digits(&mut self, system: &System, node: usize, worst_before: f64) {
        let (linearisation, report) = (&self.stepper.newton.linearisation, &mut self.monitor.report);
        warn_of_lost_digits(system, &self.motion, linearisation, report, (node, worst_before));
    }
}
