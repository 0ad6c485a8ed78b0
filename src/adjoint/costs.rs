//! Costs in the backward sweep: their terms at nodes and stages, and the derivatives of these.

use super::sweep::AdjointSweep;
use crate::forward::{AccelerationsOfCosts, Motion, control_rates};
use crate::motion::Compliances;
use crate::number::{add, dot};
use crate::system::{Beside, CostRows, Depends, NodeView, Weights};
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
            self.gradient.steps[before] += self.cost.step_before;
        }
        if let Some(after) = given.and_then(|given| self.gradient.steps.get_mut(given)) {
            *after += self.cost.step_after;
        }
        if system.has_integral() {
            let (begin, end) = (scheme.weight(0), scheme.weight(scheme.stages()));
            for (step, by_length) in [(i, end * self.cost.integrand_before), (i + 1, begin * self.cost.integrand_after)] {
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
        self.refinement.add_step(node, weight * self.cost.integrand_before, &mut self.gradient.steps);
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
            control_rates(&motion.inputs, step, &mut self.cost_node.u_dot);
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

/// Quantities at a node that costs may need in addition to y and u.
pub(super) struct CostNode {
    accelerations: AccelerationsOfCosts,
    /// Empty if no cost needs it.
    u_dot: Vec<f64>,
    /// Derivatives at another λ, computed if constraints depend on each other.
    aside: Option<Box<CostRows>>,
}

impl CostNode {
    pub(super) fn new(system: &System) -> Self {
        let u_dot = vec![0.0; if system.has_control_rates() { system.k() } else { 0 }];
        CostNode { accelerations: AccelerationsOfCosts::default(), u_dot, aside: None }
    }

    /// Begins another motion.
    pub(super) fn begin(&mut self) {
        self.accelerations.own.iter_mut().for_each(|accelerations| accelerations.begin());
    }

    fn view<'a>(&'a self, at: &NodeView<'a, f64>) -> NodeView<'a, f64> {
        let at = NodeView { u_dot: &self.u_dot, ..*at };
        self.accelerations.own.as_ref().map_or(at, |accelerations| accelerations.with(at))
    }

    /// Evaluates the costs of a node or stage, including their dependence on v̇ and λ.
    fn evaluate(
        &mut self,
        system: &System,
        (at, place): (&NodeView<f64>, (usize, &Compliances)),
        weights: &Weights<f64>,
        rows: &mut CostRows,
    ) -> Result<(), Error> {
        self.accelerations.missing = None;
        let uses = system.use_of_accelerations(weights, &rows.factors);
        if uses > Depends::Never {
            self.accelerations.find(system, uses, |accelerations| accelerations.evaluate(system, at, place))?;
        }
        let here = self.view(at);
        system.costs().gradient(&here, weights, rows);
        if uses > Depends::Never && self.accelerations.missing.is_none() {
            self.check_aside(system, at, weights, rows)?;
        }
        match &mut self.accelerations.own {
            Some(accelerations) => accelerations.pull_back(system, at, rows),
            None => Ok(()),
        }
    }

    /// Returns an error for costs on undetermined reactions, even if their derivatives happen to be zero.
    fn check_aside(
        &mut self,
        system: &System,
        at: &NodeView<f64>,
        weights: &Weights<f64>,
        rows: &mut CostRows,
    ) -> Result<(), Error> {
        let CostNode { accelerations, u_dot, aside } = self;
        let Some(accelerations) = accelerations.own.as_mut().filter(|own| own.is_compliant()) else { return Ok(()) };
        let sizes = (system.n(), system.m(), system.k());
        let aside = aside.get_or_insert_with(|| Box::new(CostRows::new(sizes, system.parameters().len(), system.outputs())));
        aside.factors.copy_from(&rows.factors);
        // The workspace of programs belongs to the current rows.
        std::mem::swap(&mut aside.memory, &mut rows.memory);
        let at = NodeView { u_dot, ..*at };
        let checked = accelerations.check_aside(system, &at, aside, |there, aside| {
            system.costs().gradient(there, weights, aside);
        });
        std::mem::swap(&mut aside.memory, &mut rows.memory);
        checked
    }
}
