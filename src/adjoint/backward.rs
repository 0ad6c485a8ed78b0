//! The backward sweep through the nodes, or several side by side that share the factors of every K(h).
//!
//! Each sweep has its own right-hand side, the derivatives of J or of an output. Before a sweep reaches the first node on which its cost depends, all
//! its variables are zero, and nothing is solved.

use std::ops::Range;

use super::AdjointSweep;
use super::stage::StageMatrix;
use crate::adjoint::growth::Growth;
use crate::motion::{Happened, Motion, StepEnd, Task, Watch};
use crate::node::{Linearisation, SolvedMotion};
use crate::scheme::{StageAdjoint, carried_part};
use crate::system::{CostFactors, NodeView};
use crate::{Error, Settings, System};

impl AdjointSweep {
    /// The gradients of sums of J and the outputs. `choose` sets the factors of the sum of each sweep; initially the sum is J alone.
    pub(crate) fn run(
        sweeps: &mut [AdjointSweep],
        system: &System,
        solved: &mut SolvedMotion,
        settings: &Settings,
        choose: impl Fn(usize, &mut CostFactors),
    ) -> Result<(), Error> {
        let SolvedMotion { motion, linearisation, report, watch } = solved;
        motion.trajectory.check_complete(&motion.inputs)?;
        for (k, sweep) in sweeps.iter_mut().enumerate() {
            sweep.begin(system, motion, settings)?;
            choose(k, &mut sweep.cost.factors);
        }
        Self::back(sweeps, system, motion, linearisation, (0..motion.nodes(), watch))?;
        for sweep in sweeps {
            sweep.is_recorded = sweep.record.is_some();
            sweep.finish(system, report)?;
        }
        Ok(())
    }

    /// Sweeps backward through these nodes.
    pub(crate) fn back(
        sweeps: &mut [AdjointSweep],
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (nodes, watch): (Range<usize>, &mut Watch),
    ) -> Result<(), Error> {
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(nodes.end - 1));
        for node in nodes.rev() {
            visit(sweeps, system, motion, linearisation, node)?;
            watch.tell(Task::Gradient, motion.nodes() - node, motion.nodes())?;
        }
        Ok(())
    }

    /// Evaluates the costs of a node and solves its adjoint equations; at an event, those after it.
    fn arrive(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (node, is_event): (usize, bool),
        is_factored: &mut bool,
    ) -> Result<(), Error> {
        if self.costs_known.take() != Some(node) {
            self.cost_rows(system, motion, node)?;
        }
        if node + 1 == motion.nodes() {
            self.take_end();
        }
        if !self.cost_is_zero {
            self.growth.add_source(motion, &linearisation.weights, &self.cost, node);
        }
        self.take_earlier_sigma(node);
        self.take_source(node);
        let (last, h) = (motion.trajectory.last_stage(), half_step(motion, node));
        let h = if is_event || node == 0 { 0.0 } else { h };
        let matrix = StageMatrix { h, blocks: None, is_factored };
        self.solve(system, motion, linearisation, (node, last), matrix, || motion.at(node))
    }

    /// Passes an event backward, to the end of the step before it.
    fn pass_event(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        happened: Happened,
    ) -> Result<(), Error> {
        if self.is_idle {
            return Ok(());
        }
        let passed = self.pass(system, motion, linearisation, happened);
        passed.map_err(|breakdown| self.singular(system, motion, happened.node, &breakdown))
    }

    /// Solves the adjoint equations at the end of a step that precedes an event.
    fn end_step(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        Happened { node, end, .. }: Happened,
        is_factored: &mut bool,
    ) -> Result<(), Error> {
        let (last, h) = (motion.trajectory.last_stage(), half_step(motion, node));
        let matrix = StageMatrix { h, blocks: Some(end.blocks), is_factored };
        self.solve(system, motion, linearisation, (node, last), matrix, || end.view(motion.at(node)))
    }

    /// Solves the adjoint equations of stage s between a node and the previous one.
    fn inner_stage(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (node, s): (usize, usize),
        is_factored: &mut bool,
    ) -> Result<(), Error> {
        let (scheme, dt) = (motion.trajectory.scheme, motion.length(node));
        let before = std::mem::take(&mut self.time);
        carried_part((&scheme, s), dt, &mut self.step, &mut self.carried);
        self.stage_cost_rows(system, motion, (node, s))?;
        let matrix = StageMatrix { h: dt * scheme.a(s, s), blocks: None, is_factored };
        self.solve(system, motion, linearisation, (node, s), matrix, || motion.at_stage(node, s))?;
        self.add_inner_inputs(node, scheme.c(s));
        self.time += before;
        Ok(())
    }

    /// Solves the adjoint equations of a stage, and adds to the derivatives with respect to its inputs; does nothing while the sweep is idle.
    fn solve<'a>(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (node, s): (usize, usize),
        matrix: StageMatrix,
        at: impl Fn() -> NodeView<'a, f64>,
    ) -> Result<(), Error> {
        // Second derivatives may be nonzero where first ones vanish, but not before a cost has read the state.
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
        self.solve_stage(system, motion, linearisation, (node, s), matrix)?;
        self.input_rows(system, linearisation, at, node)
    }

    /// Computes the derivatives with respect to q₀, v₀ or p*₀ and the design variables.
    fn end_at_start(&mut self, system: &System, motion: &Motion, linearisation: &mut Linearisation) -> Result<(), Error> {
        self.start_rows(system, motion, linearisation);
        motion.given_start.iter().for_each(|warning| self.report.warn(warning.clone()));
        self.through_assembly(system, motion, linearisation)?;
        let design = motion.inputs.design.as_slice();
        system.parameters().pull_back(design, &self.design, self.gradient.design.as_mut_slice());
        let StageAdjoint { a, b, .. } = &self.step[self.stage];
        self.growth.watch(&linearisation.weights, (a, b));
        Ok(())
    }

    /// Adds the derivative with respect to the length of the step that ends at a node, and carries the adjoint variables to its beginning.
    fn leave(&mut self, motion: &Motion, linearisation: &Linearisation, (node, end): (usize, Option<&StepEnd>)) {
        self.step_row(motion, end, node);
        carried_part((&motion.trajectory.scheme, 0), motion.length(node), &mut self.step, &mut self.carried);
        if let Some(variables) = &mut self.variables {
            variables.store_step(node, &self.carried);
        }
        if node.is_multiple_of(Growth::LOOK_EVERY) {
            self.growth.watch(&linearisation.weights, (&self.carried.a, &self.carried.b));
        }
    }
}

/// Sweeps backward through one node and the step that ends there.
fn visit(
    sweeps: &mut [AdjointSweep],
    system: &System,
    motion: &Motion,
    linearisation: &mut Linearisation,
    node: usize,
) -> Result<(), Error> {
    let happened = motion.events.at(node);
    let end = happened.as_ref().map(|happened| &happened.end);
    side_by_side(sweeps, |sweep, is_factored| {
        sweep.arrive(system, motion, linearisation, (node, happened.is_some()), is_factored)
    })?;
    if let Some(happened) = happened {
        sweeps.iter_mut().try_for_each(|sweep| sweep.pass_event(system, motion, linearisation, happened))?;
        // Needed even if all sweeps are idle, since one may begin at an earlier node.
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_into(node));
        side_by_side(sweeps, |sweep, is_factored| sweep.end_step(system, motion, linearisation, happened, is_factored))?;
    }
    for sweep in &mut *sweeps {
        sweep.refinement.add_controls(node, 1.0, &sweep.u, &mut sweep.gradient.controls);
        sweep.store(node);
    }
    if node == 0 {
        return sweeps.iter_mut().try_for_each(|sweep| sweep.end_at_start(system, motion, linearisation));
    }
    // Where an event is located, an element may begin or cease to act: its derivatives there are those of one of the two steps.
    let may_watch = motion.trajectory.scheme.is_trapezoidal() && !motion.has_located_end(node);
    if system.may_bend() && may_watch {
        let watched = sweeps.iter_mut().filter(|sweep| !sweep.is_idle);
        watched.for_each(|sweep| sweep.watch_resolution(system, motion, linearisation, end, node));
    }
    for s in (1..motion.trajectory.last_stage()).rev() {
        side_by_side(sweeps, |sweep, is_factored| sweep.inner_stage(system, motion, linearisation, (node, s), is_factored))?;
    }
    sweeps.iter_mut().for_each(|sweep| sweep.leave(motion, linearisation, (node, end)));
    Ok(())
}

/// Applies `each` to one sweep after another with the same K(h), which the first sweep that needs it factors.
fn side_by_side(
    sweeps: &mut [AdjointSweep],
    mut each: impl FnMut(&mut AdjointSweep, &mut bool) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut is_factored = false;
    sweeps.iter_mut().try_for_each(|sweep| each(sweep, &mut is_factored))
}

/// h of the last stage of the step that ends at a node.
fn half_step(motion: &Motion, node: usize) -> f64 {
    let last = motion.trajectory.last_stage();
    motion.length(node) * motion.trajectory.scheme.a(last, last)
}
