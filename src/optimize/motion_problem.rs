//! [`MotionProblem`]: a motion's cost and outputs as functions of what is free of its inputs.

use nalgebra::DMatrix;

use super::problem::{Interval, Problem, set_row};
use super::variables::Variables;
use crate::{Error, Inputs, Output, Settings, Solver, System};

/// minimise J subject to what outputs must be: equal to zero, unless something else is said; of those of an
/// [`EndState`](crate::EndState) nothing is asked. Of a scene without costs J is 0, and any point where outputs are what they must be a minimum.
pub struct MotionProblem<'s> {
    /// The solver, with the motion of the point that was evaluated last.
    pub solver: Solver<'s>,
    inputs: Inputs,
    variables: Variables,
    constraints: Vec<Interval>,
    x: Vec<f64>,
    /// What was asked for last, and a direction of the inputs.
    gradient: Vec<f64>,
    direction: Inputs,
}

impl<'s> MotionProblem<'s> {
    /// With these inputs, of which the variables are free.
    ///
    /// # Errors
    /// Inputs that do not fit the system, variables that were made for another system or another number of nodes.
    pub fn new(system: &'s System, settings: Settings, inputs: Inputs, mut variables: Variables) -> Result<Self, Error> {
        inputs.check(system)?;
        variables.check(system, &inputs)?;
        let constraints = default_constraints(system);
        let (x, solver, direction) = (variables.take(&inputs)?, Solver::new(system, settings), inputs.no_change());
        Ok(MotionProblem { solver, inputs, variables, constraints, gradient: vec![0.0; x.len()], x, direction })
    }

    /// Says what an output must be; [`Interval::FREE`] for one that is looked at alone.
    ///
    /// # Panics
    /// If the system has no such output.
    pub fn constrain(&mut self, output: Output, to: Interval) {
        self.constraints[output.index()] = to;
    }

    /// The variables of the inputs that it was made with, changed to, or evaluated last.
    pub fn start(&self) -> Vec<f64> {
        self.x.clone()
    }

    /// The inputs that belong to a point.
    pub fn inputs_at(&self, x: &[f64]) -> Inputs {
        let mut inputs = self.inputs.clone();
        self.variables.apply(x, &mut inputs);
        inputs
    }

    /// Changes the inputs, such as the lengths of their steps, not their number.
    ///
    /// # Errors
    /// Inputs that do not fit the system any more, or the variables; then nothing is changed.
    pub fn change(&mut self, by: impl FnOnce(&mut Inputs)) -> Result<(), Error> {
        let mut inputs = self.inputs.clone();
        by(&mut inputs);
        inputs.check(self.solver.system())?;
        self.variables.check(self.solver.system(), &inputs)?;
        self.inputs.start.check_kind(&inputs.start)?;
        let mut variables = self.variables.clone();
        let has_same_steps = inputs.grid.steps == self.inputs.grid.steps;
        // Shares of the same steps, taken again, would be others by their rounding.
        self.x = if has_same_steps { variables.finite(&inputs)? } else { variables.take(&inputs)? };
        (self.inputs, self.variables) = (inputs, variables);
        Ok(())
    }

    /// Sets the time at which the motion starts, which nothing depends on.
    pub(super) fn start_at(&mut self, time: f64) {
        self.inputs.grid.start = time;
    }

    /// The number of outputs.
    pub(super) fn outputs(&self) -> usize {
        self.constraints.len()
    }

    /// What is free.
    pub fn free(&self) -> &Variables {
        &self.variables
    }
}

/// What outputs must be unless it is said.
pub(super) fn default_constraints(system: &System) -> Vec<Interval> {
    let of = |k| if system.is_looked_at(k) { Interval::FREE } else { Interval::ZERO };
    (0..system.outputs()).map(of).collect()
}

impl Problem for MotionProblem<'_> {
    fn variables(&self) -> usize {
        self.variables.len()
    }

    fn bounds(&self) -> Vec<Interval> {
        self.variables.bounds()
    }

    fn constraints(&self) -> Vec<Interval> {
        self.constraints.clone()
    }

    fn variable_name(&self, i: usize) -> String {
        self.variables.name(i).to_string()
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.x.copy_from_slice(x);
        self.variables.apply(x, &mut self.inputs);
        self.solver.simulate(&self.inputs)?;
        if !c.is_empty() {
            c.copy_from_slice(self.solver.outputs()?.as_slice());
        }
        self.solver.cost()
    }

    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let of = self.solver.weighted_gradient(f_weight, c_weights)?;
        self.variables.pull_back(&self.x, of, gradient);
        self.gradient.copy_from_slice(gradient);
        Ok(())
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        let mut row = vec![0.0; self.x.len()];
        for (k, of) in self.solver.output_gradients(rows)?.enumerate() {
            self.variables.pull_back(&self.x, of, &mut row);
            set_row(jacobian, k, &row);
        }
        Ok(())
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        self.variables.push_forward(&self.x, direction, &mut self.direction);
        change.copy_from_slice(self.solver.push_forward(&self.direction)?.as_slice());
        Ok(())
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.variables.push_forward(&self.x, direction, &mut self.direction);
        let of = self.solver.hessian_product(&self.direction)?;
        self.variables.pull_back(&self.x, of, product);
        self.variables.add_curvature(direction, &self.gradient, product);
        Ok(())
    }
}
