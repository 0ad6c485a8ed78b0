//! Costs in the backward sweep: their terms at nodes and stages, and the derivatives of these.

use super::sweep::AdjointSweep;
use crate::motion::Motion;
use crate::number::{add, dot};
use crate::system::{Beside, CostRows, NodeView, Weights};
use crate::{Error, System};

impl AdjointSweep {
    /// Computes the terms of J at node `i`, their partial derivatives and those of their weights.
    pub(super) fn cost_rows(&mut self, system: &System, motion: &Motion, i: usize) -> Result<(), Error> {
        self.clear_cost();
        if !self.has_cost(system, motion, i) {
            return Ok(());
        }
        for &side in Beside::of(i, motion.nodes(), system.has_control_rates()) {
            let weights = self.refinement.weights(&motion.trajectory.scheme, &motion.inputs.grid.steps, i, side);
            self.add_cost(system, motion, &motion.at(i), &weights, (i, side.step(i)))?;
        }
        self.take_cost();
        self.add_lengths_of_node(system, motion, i);
        Ok(())
    }

    /// True if a cost may be evaluated at a node.
    pub(super) fn has_cost(&self, system: &System, motion: &Motion, i: usize) -> bool {
        let is_inside = i + 1 < motion.nodes();
        (!is_inside || system.has_running_cost(&self.cost.factors))
            && (system.has_integral() || self.refinement.given_node(i).is_some())
    }

    /// Adds the contributions of the costs of a node to the derivatives with respect to the lengths of adjacent steps, which change the weights.
    pub(super) fn add_lengths_of_node(&mut self, system: &System, motion: &Motion, i: usize) {
        let (scheme, last) = (&motion.trajectory.scheme, motion.nodes() - 1);
        let given = self.refinement.given_node(i);
        if let Some(before) = given.and_then(|given| given.checked_sub(1)) {
            self.gradient.steps[before] += self.cost.steps[0];
        }
        if let Some(after) = given.and_then(|given| self.gradient.steps.get_mut(given)) {
            *after += self.cost.steps[1];
        }
        if system.has_integral() {
            let (begin, end) = (scheme.weight(0), scheme.weight(scheme.stages()));
            for (step, by_length) in [(i, end * self.cost.integrands[0]), (i + 1, begin * self.cost.integrands[1])] {
                if (1..=last).contains(&step) {
                    self.refinement.add_step(step, by_length, &mut self.gradient.steps);
                }
            }
        }
    }

    /// Computes the terms of J at a stage between nodes, as [`cost_rows`](Self::cost_rows) does at a node.
    pub(super) fn stage_cost_rows(
        &mut self,
        system: &System,
        motion: &Motion,
        (node, s): (usize, usize),
    ) -> Result<(), Error> {
        self.clear_cost();
        if !system.has_integral() {
            return Ok(());
        }
        let weights = Weights::between(motion.trajectory.scheme.weight(s) * motion.length(node));
        self.add_cost(system, motion, &motion.at_stage(node, s), &weights, (node, node))?;
        self.take_cost();
        self.add_length_of_stage(motion, (node, s));
        Ok(())
    }

    /// Adds the contribution of the costs of a stage to the derivative with respect to the length of the step.
    pub(super) fn add_length_of_stage(&mut self, motion: &Motion, (node, s): (usize, usize)) {
        let weight = motion.trajectory.scheme.weight(s);
        self.refinement.add_step(node, weight * self.cost.integrands[0], &mut self.gradient.steps);
    }

    /// Adds the factors of the state at the last node to its rows.
    pub(super) fn take_end(&mut self) {
        let rows = &mut self.cost;
        let (n, end) = (rows.q.len(), rows.factors.of_end());
        if end.is_empty() {
            return;
        }
        let parts = [(&mut rows.q, &end[..n]), (&mut rows.v, &end[n..2 * n]), (&mut rows.p_star, &end[2 * n..])];
        parts.into_iter().for_each(|(sum, factors)| add(sum, factors));
        (rows.has_read_state, self.cost_is_zero) = (true, false);
    }

    pub(super) fn clear_cost(&mut self) {
        self.u.fill(0.0);
        if !self.cost_is_zero {
            self.cost.clear();
            self.cost_is_zero = true;
        }
    }

    /// Adds the contributions of the costs of a node, or of a stage of the step that ends there, to the rows, with u̇ of a step.
    fn add_cost(
        &mut self,
        system: &System,
        motion: &Motion,
        at: &NodeView<f64>,
        weights: &Weights<f64>,
        (node, step): (usize, usize),
    ) -> Result<(), Error> {
        self.cost_is_zero = false;
        if system.has_control_rates() {
            self.cost.clear_passed_on();
            motion.inputs.control_rates(step, &mut self.cost_node.u_dot);
        }
        let given = self.refinement.node_of_whole(node);
        let place = (given, motion.trajectory.compliance_from(node));
        self.cost_node.evaluate(system, (at, place), weights, &mut self.cost)?;
        self.report.cost_evaluations += std::mem::take(&mut self.cost.evaluations);
        if node == 0 {
            self.cost.time = 0.0;
        }
        if !self.cost.is_finite() {
            let missing = self.cost_node.accelerations.missing.take();
            return Err(missing.unwrap_or_else(|| system.bad_cost(&self.cost_node.view(at), weights, &mut self.cost, given)));
        }
        if system.has_control_rates() {
            self.add_control_rates(motion, step);
        }
        Ok(())
    }

    /// Adds the value and the input derivatives of the current rows to the gradient.
    pub(super) fn take_cost(&mut self) {
        self.gradient.value += self.cost.value;
        self.u.copy_from_slice(&self.cost.u);
        add(&mut self.design, &self.cost.design);
        self.time += self.cost.time;
    }

    /// Adds the input derivatives of other rows to the current ones.
    pub(super) fn add_inputs_of(&mut self, rows: &CostRows) {
        add(&mut self.u, &rows.u);
        add(&mut self.design, &rows.design);
        self.time += rows.time;
    }

    /// Adds derivatives with respect to u̇ = (u_i − u_{i−1})/Δt_i of a step to those of its controls and its length.
    fn add_control_rates(&mut self, motion: &Motion, step: usize) {
        let Some(length) = motion.inputs.grid.steps.get(step - 1) else { return };
        let (rows, controls) = (&self.cost.u_dot, &mut self.gradient.controls);
        self.refinement.add_controls(step, 1.0 / length, rows, controls);
        self.refinement.add_controls(step - 1, -1.0 / length, rows, controls);
        self.refinement.add_step(step, -dot(rows, &self.cost_node.u_dot) / length, &mut self.gradient.steps);
    }
}
