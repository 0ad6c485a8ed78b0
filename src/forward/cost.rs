//! J and the outputs of a motion: the costs of all its nodes and stages, with the weights of the scheme or of the given nodes.

use nalgebra::DVector;

use super::accelerations::{Accelerations, Parts};
use crate::motion::Refinement;
use crate::number::Real;
use crate::system::{CostRows, Depends, NodeView, Weights, factors_of};
use crate::{Error, Inputs, System, Trajectory};

/// What the costs of a motion are summed with: how its grid is refined, the factors of J and of the outputs, and what v̇ and λ need.
pub(crate) struct CostSum<'a> {
    refinement: &'a Refinement,
    factors: Vec<f64>,
    accelerations: Option<Box<Accelerations>>,
}

impl<'a> CostSum<'a> {
    /// For J, 0, or for an output, from 1 on.
    pub(crate) fn new(system: &System, refinement: &'a Refinement, which: usize) -> Self {
        CostSum { refinement, factors: factors_of(which, system.outputs()), accelerations: None }
    }

    /// The sum of all costs at a node, or at a stage of the step into it.
    ///
    /// # Errors
    /// Accelerations that a cost depends on and that are not determined.
    pub(crate) fn at<R: Real>(
        &mut self,
        system: &System,
        at: &NodeView<R>,
        weights: &Weights<R>,
        node: usize,
    ) -> Result<R, Error> {
        let uses = system.use_of_accelerations(weights, &self.factors);
        if uses == Depends::Never {
            return Ok(system.cost(at, weights, &self.factors));
        }
        let accelerations = self.accelerations.get_or_insert_with(|| Box::new(Accelerations::new(system)));
        let [v_dot, lambda] = match accelerations.lift(system, at, self.refinement.given_step(node)) {
            Ok(lifted) => lifted,
            // Whether it matters, the value will tell.
            Err(_) if uses == Depends::Perhaps => [system.n(), system.m()].map(|len| vec![R::from(f64::NAN); len]),
            Err(error) => return Err(error),
        };
        Ok(system.cost(&NodeView { v_dot: &v_dot, lambda: &lambda, ..*at }, weights, &self.factors))
    }
}

impl<R: Real> Trajectory<R> {
    /// J of Eq. (5): all costs of the scene, summed over the given nodes.
    ///
    /// `inputs` are those the trajectory was computed from, on the grid that was taken: [`Solver::inputs`](crate::Solver::inputs).
    ///
    /// # Errors
    /// Inputs of other sizes; a cost or a sum that is not finite; accelerations that a cost depends on and that are not determined.
    pub fn cost(&self, system: &System, inputs: &Inputs<R>) -> Result<R, Error> {
        self.sum_of_costs(system, inputs, 0)
    }

    /// The values of all outputs of the nodes computed, as [`cost`](Self::cost) gives J.
    ///
    /// # Errors
    /// As [`cost`](Self::cost).
    pub fn outputs(&self, system: &System, inputs: &Inputs<R>) -> Result<DVector<R>, Error> {
        let values = (1..=system.outputs()).map(|k| self.sum_of_costs(system, inputs, k));
        Ok(DVector::from_vec(values.collect::<Result<Vec<R>, Error>>()?))
    }

    fn sum_of_costs(&self, system: &System, inputs: &Inputs<R>, which: usize) -> Result<R, Error> {
        self.check_fits(system, inputs)?;
        let lengths: Vec<f64> = inputs.grid.steps.iter().map(|dt| dt.part(0)).collect();
        let refinement = Refinement::new(&lengths, &self.inserted);
        let mut costs = CostSum::new(system, &refinement, which);
        let design = system.parameters().values(inputs.design.as_slice());
        let first = if system.has_running_cost(&costs.factors) { 0 } else { self.computed.saturating_sub(1) };
        let mut sum = R::zero();
        for i in first..self.computed {
            let value = self.cost_of_step(system, (inputs, &design), &mut costs, i)?;
            if !is_finite(value) {
                return Err(self.bad_cost(system, (inputs, &design), &costs, i));
            }
            sum += value;
        }
        if is_finite(sum) { Ok(sum) } else { Err(Error::Overflow { what: "J".into(), value: sum.part(0) }) }
    }

    /// All that J gets from node `i` and from the stages between it and the node before.
    ///
    /// # Errors
    /// Accelerations that a cost depends on and that are not determined.
    pub(crate) fn cost_of_step(
        &self,
        system: &System,
        (inputs, design): (&Inputs<R>, &[R]),
        costs: &mut CostSum,
        i: usize,
    ) -> Result<R, Error> {
        let (mut sum, mut u_dot) = (R::zero(), Vec::new());
        if system.has_control_rates() {
            u_dot.resize(system.k(), R::zero());
            control_rates(inputs, i, &mut u_dot);
        }
        if i > 0 && system.has_integral() {
            for s in 1..self.last_stage() {
                let at = NodeView { design, u_dot: &u_dot, ..self.stage(i, s) };
                let weights = Weights::between(inputs.grid.steps[i - 1] * self.scheme.weight(s));
                sum += costs.at(system, &at, &weights, i)?;
            }
        }
        let weights = costs.refinement.weights(&self.scheme, &inputs.grid.steps, i);
        let at = NodeView { u_dot: &u_dot, ..self.at((inputs, design), i) };
        Ok(sum + costs.at(system, &at, &weights, i)?)
    }

    /// Which cost of a node is not finite.
    fn bad_cost(&self, system: &System, (inputs, design): (&Inputs<R>, &[R]), costs: &CostSum, node: usize) -> Error {
        let real = |list: &[R]| list.iter().map(|x| x.part(0)).collect::<Vec<f64>>();
        let (at, mut u_dot) = (self.at((inputs, design), node), vec![R::zero(); system.k()]);
        control_rates(inputs, node, &mut u_dot);
        let u_dot = real(&u_dot);
        let [p_star, p_star_dot, steps] = [at.p_star, at.p_star_dot, &inputs.grid.steps].map(real);
        let state = Parts::of(&at, 0);
        let at = state.view();
        let mut accelerations = Accelerations::new(system);
        if accelerations.evaluate(system, &at, node).is_err() {
            accelerations.forget();
        }
        let at = accelerations.with(NodeView { p_star: &p_star, p_star_dot: &p_star_dot, u_dot: &u_dot, ..at });
        let mut rows = CostRows::new((system.n(), system.m(), system.k()), system.parameters().len(), system.outputs());
        rows.factors.copy_from_slice(&costs.factors);
        let weights = costs.refinement.weights(&self.scheme, &steps, node);
        system.bad_cost(&at, &weights, &mut rows, costs.refinement.given_step(node))
    }
}

/// u̇ in the step into a node, or out of node 0.
pub(crate) fn control_rates<R: Real>(inputs: &Inputs<R>, node: usize, u_dot: &mut [R]) {
    let step = node.max(1);
    let Some(&length) = inputs.grid.steps.get(step - 1) else { return };
    let [begin, end] = inputs.at_ends(step);
    u_dot.iter_mut().zip(begin.iter().zip(end)).for_each(|(u_dot, (&begin, &end))| *u_dot = (end - begin) / length);
}

fn is_finite<R: Real>(x: R) -> bool {
    (0..R::PARTS).all(|part| x.part(part).is_finite())
}
