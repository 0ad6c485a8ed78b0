//! S_z of a stage, which replaces a cost's derivatives J_z in the adjoint equations for derivatives along a direction.

use super::{First, SecondOrderSweep};
use crate::adjoint::record::OfEvent;
use crate::motion::Motion;
use crate::node::{Linearisation, SecondOrderPrograms};
use crate::number::dot;
use crate::scheme::StageAdjoint;
use crate::system::{Beside, CostRows, Covector, Depends, NodeView, Weights};
use crate::{Error, Settings, System};
use num_dual::Dual64;

/// A stage, the direction there, and the adjoint variables of the gradient.
pub(super) struct OfStage<'a> {
    pub(super) at: NodeView<'a, f64>,
    pub(super) along: NodeView<'a, f64>,
    pub(super) blocks: &'a [f64],
    pub(super) with: Covector<'a>,
    /// a and b.
    pub(super) step: [&'a [f64]; 2],
    /// The change of h.
    pub(super) h_dot: f64,
}

impl OfStage<'_> {
    /// Adds ∂(Dψ)/∂z, −ḣ a and −ḣ b.
    pub(super) fn add_sources(
        &self,
        system: &System,
        linearisation: &Linearisation,
        programs: &mut SecondOrderPrograms,
        rows: &mut CostRows,
    ) {
        programs.add_rows_along((system, &linearisation.evaluation), (&self.at, self.blocks), &self.along, &self.with, rows);
        if self.h_dot != 0.0 {
            let [a, b] = self.step;
            rows.v.iter_mut().zip(a).for_each(|(sum, a)| *sum -= self.h_dot * a);
            rows.p_star_dot.iter_mut().zip(b).for_each(|(sum, b)| *sum -= self.h_dot * b);
        }
    }
}

impl SecondOrderSweep {
    /// Begins the sources of a function with the factors of the gradient.
    pub(super) fn begin_sources(&mut self, system: &System, motion: &Motion, first: &First) -> Result<(), Error> {
        self.sweep.begin(system, motion, &Settings { keep_adjoint: false, ..Settings::default() })?;
        self.sweep.cost.factors.copy_from(first.factors);
        self.suspect = None;
        Ok(())
    }

    /// Computes the sources of a node, from its costs and its equations.
    pub(super) fn sources_of_node(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&Linearisation, &First),
        node: usize,
    ) -> Result<(), Error> {
        self.sweep.clear_cost();
        if self.sweep.has_cost(system, motion, node) {
            for &side in Beside::of(node, motion.nodes(), system.has_control_rates()) {
                let weights = self.sweep.refinement.weights(&motion.trajectory.scheme, &self.steps, node, side);
                self.add_costs(system, motion, (node, motion.trajectory.last_stage(), side.step(node)), &weights)?;
            }
            self.sweep.add_lengths_of_node(system, motion, node);
        }
        self.add_stage(system, motion, (linearisation, first), (node, motion.trajectory.last_stage()));
        self.sweep.take_cost();
        Ok(())
    }

    /// Computes the sources of a stage of the step that ends at a node.
    pub(super) fn sources_of_stage(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&Linearisation, &First),
        (node, s): (usize, usize),
    ) -> Result<(), Error> {
        self.sweep.clear_cost();
        if system.has_integral() {
            let weight = motion.trajectory.scheme.weight(s);
            self.add_costs(system, motion, (node, s, node), &Weights::between(self.steps[node - 1] * weight))?;
            self.sweep.add_length_of_stage(motion, (node, s));
        }
        self.add_stage(system, motion, (linearisation, first), (node, s));
        self.sweep.take_cost();
        Ok(())
    }

    /// Adds (J_z)˙, with u̇ of a step.
    fn add_costs(
        &mut self,
        system: &System,
        motion: &Motion,
        (node, s, step): (usize, usize, usize),
        weights: &Weights<Dual64>,
    ) -> Result<(), Error> {
        let uses = system.use_of_accelerations(weights, &self.sweep.cost.factors);
        let is_felt = uses != Depends::Never && self.find_accelerations(system, motion, (node, s), uses)?;
        if system.has_control_rates() {
            self.sweep.cost.clear_passed_on();
            self.find_control_rates(motion, step);
        }
        let [u_dot, u_dot_change] = &self.u_dot;
        let [x, x_change] = &self.felt;
        let at = NodeView { u_dot, v_dot: &x.v, lambda: &x.sigma, ..motion.at_stage(node, s) };
        let along =
            NodeView { u_dot: u_dot_change, v_dot: &x_change.v, lambda: &x_change.sigma, ..self.change.at_stage(node, s) };
        system.costs().add(&mut self.programs.costs, (&at, Some(&along)), weights, &mut self.sweep.cost);
        if system.has_control_rates() || is_felt {
            let first = &mut self.first_rows;
            first.clear();
            first.factors.copy_from(&self.sweep.cost.factors);
            let weights = weights.map(|weight| weight.re);
            system.costs().add(&mut self.sweep.cost_node.programs, (&at, None), &weights, first);
        }
        if let Some(accelerations) = self.accelerations.own.as_mut().filter(|_| is_felt) {
            // The workspace of first derivatives for costs on u̇ is preserved.
            let u_dot = std::mem::take(&mut self.first_rows.u_dot);
            let rows = (&mut self.first_rows, &mut self.sweep.cost);
            let done = accelerations.pull_back_along(system, (&at, &along), &mut self.programs.equations, rows);
            self.first_rows.u_dot = u_dot;
            done?;
        }
        let rows = &mut self.sweep.cost;
        if rows.is_finite() {
            if system.has_control_rates() {
                self.add_control_rates(step);
            }
            return Ok(());
        }
        Err(system.bad_cost_along((&at, Some(&along)), weights, rows, motion.node_of_whole(node)))
    }

    /// Computes v̇ and λ of a stage, and their changes; returns whether they are known.
    fn find_accelerations(
        &mut self,
        system: &System,
        motion: &Motion,
        (node, s): (usize, usize),
        uses: Depends,
    ) -> Result<bool, Error> {
        let (at, along) = (motion.at_stage(node, s), self.change.at_stage(node, s));
        let found = self.accelerations.find(system, uses, |accelerations| {
            accelerations.evaluate(system, &at, (motion.node_of_whole(node), motion.trajectory.compliance_from(node)))?;
            let found = accelerations.along(system, &at, &along);
            for (felt, found) in self.felt.iter_mut().zip(found) {
                felt.v.copy_from_slice(&found.v);
                felt.sigma.copy_from_slice(&found.sigma);
            }
            Ok(())
        })?;
        if found.is_none() {
            self.felt.iter_mut().flat_map(|felt| [&mut felt.v, &mut felt.sigma]).for_each(|x| x.fill(f64::NAN));
        }
        Ok(found.is_some())
    }

    /// Adds the sources of the equations of a stage; for a node with an event, after it.
    fn add_stage(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&Linearisation, &First),
        (node, s): (usize, usize),
    ) {
        self.sweep.cost_is_zero = false;
        let (record, programs) = (first.record, &mut self.programs);
        let of_event = record.event(node).filter(|_| s == motion.trajectory.last_stage());
        let stage = motion.block_column(node, s);
        if record.has_nothing(stage) {
            return;
        }
        let h_dot = self.change.length(node) * motion.trajectory.scheme.a(s, s);
        let (with, step, h_dot) = match of_event {
            Some(OfEvent { after: StageAdjoint { a, b, c, d, e }, .. }) => (Covector { c, d, e }, [&a[..], b], 0.0),
            None => (record.covector(stage), record.of_step(stage), h_dot),
        };
        let (at, along) = (motion.at_stage(node, s), self.change.at_stage(node, s));
        let of = OfStage { at, along, blocks: motion.stage_blocks(node, s), with, step, h_dot };
        of.add_sources(system, linearisation, programs, &mut self.sweep.cost);
        if self.suspect.is_none() && !self.sweep.cost.is_finite() {
            let mut rows = self.sweep.cost.clone();
            self.suspect =
                Some(system.bad_element_along((&of.at, &of.along), &of.with, &mut rows, motion.node_of_whole(node)));
        }
    }

    /// Computes u̇ = (u_i − u_{i−1})/Δt_i in the step that ends at a node, and its change.
    fn find_control_rates(&mut self, motion: &Motion, step: usize) {
        let [u_dot, change] = &mut self.u_dot;
        motion.inputs.control_rates(step, u_dot);
        let Some(length) = self.steps.get(step - 1) else { return };
        let [begin, end] = self.change.inputs.at_ends(step);
        for (k, change) in change.iter_mut().enumerate() {
            *change = (end[k] - begin[k] - u_dot[k] * length.eps) / length.re;
        }
    }

    /// Adds the contributions of costs on u̇ to the derivatives with respect to controls and step lengths.
    fn add_control_rates(&mut self, step: usize) {
        let Some(&Dual64 { re: length, eps: length_dot, .. }) = self.steps.get(step - 1) else { return };
        let ([u_dot, u_dot_change], sweep) = (&self.u_dot, &mut self.sweep);
        let (j, rows) = (&self.first_rows.u_dot, &mut sweep.cost.u_dot);
        let by_length = dot(j, u_dot) * length_dot / length - dot(rows, u_dot) - dot(j, u_dot_change);
        rows.iter_mut().zip(j).for_each(|(row, j)| *row = (*row - j * length_dot / length) / length);
        let controls = &mut sweep.gradient.controls;
        sweep.refinement.add_controls(step, 1.0, rows, controls);
        sweep.refinement.add_controls(step - 1, -1.0, rows, controls);
        sweep.refinement.add_step(step, by_length / length, &mut sweep.gradient.steps);
    }
}

/// A direction of (q, v, σ), with the direction of the inputs at a node.
pub(super) fn direction<'a>(change: &'a Motion, node: usize, state: [&'a [f64]; 3]) -> NodeView<'a, f64> {
    let NodeView { u, t, design, .. } = change.at(node);
    NodeView::of_equations(state, (u, t, design))
}
