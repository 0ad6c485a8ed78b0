//! The way back through the nodes: one backward sweep, or several side by side that share the factors of every K(h).
//!
//! Each has a right-hand side of its own, the derivatives of J or of an output. Until a sweep comes to the first node that its cost depends on, all that it
//! carries is zero, and it has nothing to solve.

use std::ops::Range;

use super::AdjointSweep;
use crate::adjoint::growth::Growth;
use crate::forward::restart::Restart;
use crate::forward::{ForwardSweep, Motion};
use crate::motion::{Task, Watch};
use crate::node::Newton;
use crate::scheme::{StageAdjoint, carried_part};
use crate::system::{CostFactors, NodeView};
use crate::{Error, Settings, System};

impl AdjointSweep {
    /// The gradients of sums of J and the outputs: `choose` sets the factors of each sweep's sum, which are those of J alone before.
    pub(crate) fn run(
        sweeps: &mut [AdjointSweep],
        system: &System,
        forward: &mut ForwardSweep,
        settings: &Settings,
        choose: impl Fn(usize, &mut CostFactors),
    ) -> Result<(), Error> {
        let ForwardSweep { motion, stepper, monitor, watch, .. } = forward;
        motion.trajectory.check_complete(&motion.inputs)?;
        for (k, sweep) in sweeps.iter_mut().enumerate() {
            sweep.begin(system, motion, settings)?;
            choose(k, &mut sweep.cost.factors);
        }
        Self::back(sweeps, system, motion, &mut stepper.newton, (0..motion.nodes(), watch))?;
        for sweep in sweeps {
            sweep.is_recorded = sweep.record.is_some();
            sweep.finish(system, &monitor.report)?;
        }
        Ok(())
    }

    /// Goes back through these nodes.
    pub(crate) fn back(
        sweeps: &mut [AdjointSweep],
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (nodes, watch): (Range<usize>, &mut Watch),
    ) -> Result<(), Error> {
        newton.evaluation.set_compliance(motion.trajectory.compliance_from(nodes.end - 1));
        for node in nodes.rev() {
            visit(sweeps, system, motion, newton, node)?;
            watch.tell(Task::Gradient, motion.nodes() - node, motion.nodes())?;
        }
        Ok(())
    }

    /// The costs of a node, and the adjoint equations with which the motion goes on there.
    fn arrive(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (node, is_restart): (usize, bool),
        is_factored: &mut bool,
    ) -> Result<(), Error> {
        self.cost_rows(system, motion, node)?;
        if !self.cost_is_zero {
            self.growth.add_source(motion, &newton.weights, &self.cost, node);
        }
        self.take_sigma_before(node);
        let (last, h) = (motion.trajectory.last_stage(), half_step(motion, node));
        let h = if is_restart || node == 0 { 0.0 } else { h };
        self.solve(system, motion, newton, (node, last), (h, None, is_factored), || motion.at(node))
    }

    /// Crosses a restart: from the motion that was started anew to the step before it.
    fn cross_restart(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (node, restart): (usize, &Restart),
    ) -> Result<(), Error> {
        if self.is_idle {
            return Ok(());
        }
        if let Some(record) = &mut self.record {
            record.begin_crossing(node, &self.step[self.stage]);
        }
        let crossed = self.cross(system, motion, newton, restart, node);
        crossed.map_err(|breakdown| self.singular(system, motion, node, &breakdown))
    }

    /// The adjoint equations at the end of a step that a restart follows.
    fn end_step(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (node, restart): (usize, &Restart),
        is_factored: &mut bool,
    ) -> Result<(), Error> {
        let (last, h) = (motion.trajectory.last_stage(), half_step(motion, node));
        let end = || NodeView { q: restart.q, v: restart.v, sigma: restart.sigma, ..motion.at(node) };
        self.solve(system, motion, newton, (node, last), (h, Some(restart.step_blocks), is_factored), end)
    }

    /// The adjoint equations of stage s between a node and the one before it.
    fn inner_stage(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (node, s): (usize, usize),
        is_factored: &mut bool,
    ) -> Result<(), Error> {
        let (scheme, dt) = (motion.trajectory.scheme, motion.length(node));
        let before = std::mem::take(&mut self.time);
        carried_part((&scheme, s), dt, &mut self.step, &mut self.carried);
        self.stage_cost_rows(system, motion, (node, s))?;
        let h = dt * scheme.a(s, s);
        self.solve(system, motion, newton, (node, s), (h, None, is_factored), || motion.at_stage(node, s))?;
        self.add_inner_inputs(node, scheme.c(s));
        self.time += before;
        Ok(())
    }

    /// Solves the adjoint equations of a stage, and adds to the derivatives with respect to its inputs; nothing while there is nothing to solve.
    fn solve<'a>(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (node, s): (usize, usize),
        with: (f64, Option<&[f64]>, &mut bool),
        at: impl Fn() -> NodeView<'a, f64>,
    ) -> Result<(), Error> {
        // Second derivatives may begin where first ones vanish, but not before a cost reads the state.
        let cost = &self.cost;
        let leaves_nothing = || if self.record.is_some() { !cost.has_read_state } else { cost.has_no_state() };
        self.is_idle = self.is_idle && (self.cost_is_zero || leaves_nothing());
        if self.is_idle {
            self.clear_stage(s);
            if let Some(record) = &mut self.record {
                record.store_nothing(motion.block_column(node - motion.first, s));
            }
            return Ok(());
        }
        self.solve_stage(system, motion, newton, (node, s), with)?;
        self.input_rows(system, newton, at, node)
    }

    /// To q₀, v₀ or p*₀ and the design variables.
    fn end_at_start(&mut self, system: &System, motion: &Motion, newton: &mut Newton) -> Result<(), Error> {
        self.start_rows(system, motion, newton);
        motion.given_start.iter().for_each(|warning| self.report.warn(warning.clone()));
        self.through_assembly(system, motion, newton)?;
        let design = motion.inputs.design.as_slice();
        system.parameters().pull_back(design, &self.design, self.gradient.design.as_mut_slice());
        let StageAdjoint { a, b, .. } = &self.step[self.stage];
        self.growth.watch(&newton.weights, (a, b));
        Ok(())
    }

    /// The length of the step into a node, and what the step carries to where it begins.
    fn leave(&mut self, motion: &Motion, newton: &Newton, (node, restart): (usize, Option<&Restart>)) {
        self.step_row(motion, restart, node);
        carried_part((&motion.trajectory.scheme, 0), motion.length(node), &mut self.step, &mut self.carried);
        if let Some(variables) = &mut self.variables {
            variables.store_step(node, &self.carried);
        }
        if node.is_multiple_of(Growth::LOOK_EVERY) {
            self.growth.watch(&newton.weights, (&self.carried.a, &self.carried.b));
        }
    }
}

/// Goes back through one node, and through the step into it.
fn visit(
    sweeps: &mut [AdjointSweep],
    system: &System,
    motion: &Motion,
    newton: &mut Newton,
    node: usize,
) -> Result<(), Error> {
    let restart = motion.restarts.at(node);
    side_by_side(sweeps, |sweep, is_factored| sweep.arrive(system, motion, newton, (node, restart.is_some()), is_factored))?;
    if let Some(restart) = &restart {
        sweeps.iter_mut().try_for_each(|sweep| sweep.cross_restart(system, motion, newton, (node, restart)))?;
        // Also where no sweep had anything to cross with: one may begin at an earlier node.
        newton.evaluation.set_compliance(motion.trajectory.compliance_into(node));
        side_by_side(sweeps, |sweep, is_factored| sweep.end_step(system, motion, newton, (node, restart), is_factored))?;
    }
    for sweep in &mut *sweeps {
        sweep.refinement.add_controls(node, 1.0, &sweep.u, &mut sweep.gradient.controls);
        sweep.store(node);
    }
    if node == 0 {
        return sweeps.iter_mut().try_for_each(|sweep| sweep.end_at_start(system, motion, newton));
    }
    if system.may_bend() && motion.trajectory.scheme.is_trapezoidal() {
        let watched = sweeps.iter_mut().filter(|sweep| !sweep.is_idle);
        watched.for_each(|sweep| sweep.watch_resolution(system, motion, newton, restart.as_ref(), node));
    }
    for s in (1..motion.trajectory.last_stage()).rev() {
        side_by_side(sweeps, |sweep, is_factored| sweep.inner_stage(system, motion, newton, (node, s), is_factored))?;
    }
    sweeps.iter_mut().for_each(|sweep| sweep.leave(motion, newton, (node, restart.as_ref())));
    Ok(())
}

/// One sweep after the other with the same K(h), which the first that needs them makes the factors of.
fn side_by_side(
    sweeps: &mut [AdjointSweep],
    mut each: impl FnMut(&mut AdjointSweep, &mut bool) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut is_factored = false;
    sweeps.iter_mut().try_for_each(|sweep| each(sweep, &mut is_factored))
}

/// h of the last stage of the step into a node.
fn half_step(motion: &Motion, node: usize) -> f64 {
    let last = motion.trajectory.last_stage();
    motion.length(node) * motion.trajectory.scheme.a(last, last)
}
