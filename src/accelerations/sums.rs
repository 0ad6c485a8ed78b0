//! J and the outputs of a motion: costs at all nodes and stages, summed with the weights of the scheme or of the given nodes.

use nalgebra::DVector;

use super::{Accelerations, AccelerationsOfCosts};
use crate::motion::{Compliances, Refinement};
use crate::number::Real;
use crate::system::{Beside, CostFactors, CostRows, Depends, NodeValues, NodeView, Weights};
use crate::{Error, Inputs, System, Trajectory};

/// A function of the state and the weights at each place at which costs are evaluated.
type Visit<'a, R> = &'a mut dyn FnMut(&NodeView<R>, &Weights<R>) -> Result<(), Error>;

/// Data for the sum of costs: the refinement of the grid, factors of J and the outputs, and a workspace for v̇ and λ.
pub(crate) struct CostSum<'a> {
    refinement: &'a Refinement,
    pub(crate) factors: CostFactors,
    accelerations: AccelerationsOfCosts,
}

impl<'a> CostSum<'a> {
    pub(crate) fn new(refinement: &'a Refinement, factors: CostFactors) -> Self {
        CostSum { refinement, factors, accelerations: AccelerationsOfCosts::default() }
    }

    /// Adds all costs at a node, or at a stage of the step that ends there, to J and to the outputs.
    ///
    /// # Errors
    /// Accelerations that a cost depends on and that are not determined.
    pub(crate) fn add<R: Real>(
        &mut self,
        system: &System,
        (at, (node, compliance)): (&NodeView<R>, (usize, &Compliances)),
        weights: &Weights<R>,
        add: &mut dyn FnMut(usize, R),
    ) -> Result<(), Error> {
        let uses = system.use_of_accelerations(weights, &self.factors);
        if uses == Depends::Never {
            system.add_costs(at, weights, &self.factors, add);
            return Ok(());
        }
        let place = (self.refinement.node_of_whole(node), compliance);
        let with = (place, self.accelerations.by_programs);
        let lifted = self.accelerations.find(system, uses, |accelerations| accelerations.lift(system, at, with))?;
        let unknown = || [system.n(), system.m()].map(|len| vec![R::from(f64::NAN); len]);
        let [v_dot, lambda] = lifted.unwrap_or_else(unknown);
        system.add_costs(&NodeView { v_dot: &v_dot, lambda: &lambda, ..*at }, weights, &self.factors, add);
        Ok(())
    }
}

impl<R: Real> Trajectory<R> {
    /// J of Eq. (5): all costs of the scene, summed over the given nodes.
    ///
    /// `inputs` are those of the trajectory, on the computed grid: [`Solver::inputs`](crate::Solver::inputs).
    ///
    /// # Errors
    /// Inputs of wrong size, invalid inserted nodes, a cost or sum that is not finite, or a cost on accelerations that are not unique.
    pub fn cost(&self, system: &System, inputs: &Inputs<R>) -> Result<R, Error> {
        let factors = CostFactors::of_cost(system.outputs());
        Ok(self.sums_of_costs(system, inputs, (factors, &mut AccelerationsOfCosts::default()))?[0])
    }

    /// The values of all outputs, summed over the computed nodes.
    ///
    /// # Errors
    /// As [`cost`](Self::cost).
    pub fn outputs(&self, system: &System, inputs: &Inputs<R>) -> Result<DVector<R>, Error> {
        let factors = CostFactors::of_outputs(system.outputs());
        let sums = self.sums_of_costs(system, inputs, (factors, &mut AccelerationsOfCosts::default()))?;
        Ok(DVector::from_column_slice(&sums[1..]))
    }

    /// J and the outputs, as far as requested, with a workspace for v̇ and λ that other motions of the system can reuse.
    ///
    /// # Errors
    /// As [`cost`](Self::cost).
    pub(crate) fn sums_of_costs(
        &self,
        system: &System,
        inputs: &Inputs<R>,
        (factors, accelerations): (CostFactors, &mut AccelerationsOfCosts),
    ) -> Result<Vec<R>, Error> {
        self.check_fits(system, inputs)?;
        let refinement = self.refinement(inputs)?;
        let mut costs = CostSum { accelerations: std::mem::take(accelerations), ..CostSum::new(&refinement, factors) };
        let design = system.parameters().values(inputs.design.as_slice());
        let at = self.columns(0).with_inputs((inputs.controls_at(0), &design));
        system.costs_now(&NodeValues::of_costs(&at, |x| x.part(0)).view())?;
        let first = if system.has_running_cost(&costs.factors) { 0 } else { self.last() };
        let mut sums = vec![R::zero(); costs.factors.len()];
        for i in first..self.computed {
            self.sum_costs_of_step(system, (inputs, &design), &mut costs, (i, i), &mut sums)?;
        }
        *accelerations = costs.accelerations;
        check_sums(system, &sums)?;
        Ok(sums)
    }

    /// Adds to J and the outputs the contributions of node `i`, stored in `column`, and of the stages between it and the previous node.
    ///
    /// # Errors
    /// A cost that is not finite; accelerations that a cost depends on and that are not determined.
    pub(crate) fn sum_costs_of_step(
        &self,
        system: &System,
        (inputs, design): (&Inputs<R>, &[R]),
        costs: &mut CostSum,
        (i, column): (usize, usize),
        sums: &mut [R],
    ) -> Result<(), Error> {
        let mut all_finite = true;
        self.costs_of_step(system, (inputs, design), costs, (i, column), &mut |output, term| {
            all_finite &= is_finite(term);
            sums[output] += term;
        })?;
        if all_finite {
            return Ok(());
        }
        let missing = costs.accelerations.missing.take();
        Err(missing.unwrap_or_else(|| self.bad_cost(system, (inputs, design), costs, (i, column))))
    }

    /// Passes to `add` all contributions to J and the outputs of node `i`, stored in `column`, and of the stages between it and the previous node.
    ///
    /// # Errors
    /// Accelerations that a cost depends on and that are not determined.
    pub(crate) fn costs_of_step(
        &self,
        system: &System,
        (inputs, design): (&Inputs<R>, &[R]),
        costs: &mut CostSum,
        (i, column): (usize, usize),
        add: &mut dyn FnMut(usize, R),
    ) -> Result<(), Error> {
        costs.accelerations.missing = None;
        let (place, refinement) = ((i, self.compliance_from(i)), costs.refinement);
        self.each_place(system, (inputs, design), refinement, (i, column), &mut |at, weights| {
            costs.add(system, (at, place), weights, add)
        })
    }

    /// Visits the places at which the costs of a step are evaluated, with their weights: the stages between its nodes, and the node at its end.
    fn each_place(
        &self,
        system: &System,
        (inputs, design): (&Inputs<R>, &[R]),
        refinement: &Refinement,
        (i, column): (usize, usize),
        visit: Visit<R>,
    ) -> Result<(), Error> {
        let has_rates = system.has_control_rates();
        let mut u_dot = vec![R::zero(); if has_rates { system.k() } else { 0 }];
        if i > 0 && system.has_integral() {
            inputs.control_rates(i, &mut u_dot);
            for s in 1..self.last_stage() {
                let at = NodeView { design, u_dot: &u_dot, ..self.stage(column, s) };
                let weights = Weights::between(inputs.grid.steps[i - 1] * self.scheme.weight(s));
                visit(&at, &weights)?;
            }
        }
        for &side in Beside::of(i, inputs.grid.nodes(), has_rates) {
            inputs.control_rates(side.step(i), &mut u_dot);
            let weights = refinement.weights(&self.scheme, &inputs.grid.steps, i, side);
            let at = NodeView { u_dot: &u_dot, ..self.columns(column).with_inputs((inputs.controls_at(i), design)) };
            visit(&at, &weights)?;
        }
        Ok(())
    }

    /// Finds the cost of a step that is not finite.
    fn bad_cost(
        &self,
        system: &System,
        (inputs, design): (&Inputs<R>, &[R]),
        costs: &CostSum,
        (node, column): (usize, usize),
    ) -> Error {
        let mut rows = CostRows::new((system.n(), system.m(), system.k()), system.parameters().len(), system.outputs());
        rows.factors.copy_from(&costs.factors);
        let (mut accelerations, given) = (Accelerations::new(system), costs.refinement.node_of_whole(node));
        // Error at the last place, for sums that are not finite although every cost is finite.
        let mut of_all = Error::Overflow { what: "J".into(), value: f64::NAN };
        let visited = self.each_place(system, (inputs, design), costs.refinement, (node, column), &mut |at, weights| {
            let (real, weights) = (NodeValues::of_costs(at, |x| x.part(0)), weights.map(|x| x.part(0)));
            let at = real.view();
            if accelerations.evaluate(system, &at, (node, self.compliance_from(node))).is_err() {
                accelerations.forget();
            }
            let at = accelerations.with(at);
            let mut has_values = R::PARTS == 1;
            system.add_costs(&at, &weights, &costs.factors, &mut |_, term| has_values &= is_finite(term));
            if has_values {
                return Ok(());
            }
            if let Some(error) = system.find_bad_cost(&at, &weights, &mut rows, given) {
                return Err(error);
            }
            of_all = system.bad_part_of_cost(&at, given);
            Ok(())
        });
        visited.err().unwrap_or(of_all)
    }
}

/// Returns an error if J or an output has overflowed.
pub(crate) fn check_sums<R: Real>(system: &System, sums: &[R]) -> Result<(), Error> {
    let Some(k) = sums.iter().position(|sum| !is_finite(*sum)) else { return Ok(()) };
    let what = k.checked_sub(1).map_or_else(|| "J".into(), |output| format!("output `{}`", system.output_name(output)));
    Err(Error::Overflow { what, value: sums[k].part(0) })
}

fn is_finite<R: Real>(x: R) -> bool {
    (0..R::PARTS).all(|part| x.part(part).is_finite())
}
