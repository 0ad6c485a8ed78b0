//! [`MotionProblem`]: the cost and the outputs of a motion as functions of its free inputs.

use nalgebra::DMatrix;

use super::free::{Quantity, check_reading_times};
use super::held;
use super::problem::{Interval, Problem, set_row};
use super::sizes::Sizes;
use super::variables::Variables;
use crate::estimate::{GridErrors, grid_errors};
use crate::motion::Watch;
use crate::solver::Asked;
use crate::{Error, Inputs, Output, Scheme, Settings, Solver, System, Warning};

/// The problem of minimising J of a motion subject to constraints on its outputs. Outputs must be zero unless
/// [`constrain`](Self::constrain) sets another interval; those of an [`EndState`](crate::EndState) are free. In a scene without costs J is 0,
/// and every feasible point is a minimum.
#[derive(Debug)]
pub struct MotionProblem {
    /// The solver, with the motion of the last evaluated point.
    pub solver: Solver,
    variables: Variables,
    constraints: Vec<Interval>,
    /// The point given at construction, that of the last change, or of the last successful evaluation.
    known: Point,
    /// The point evaluated last, with or without a value: that of the solver.
    tried: Point,
    /// The last computed gradient, and workspace for a direction of the inputs.
    gradient: Vec<f64>,
    direction: Inputs,
    /// False if all weights of the last gradient were zero: no sweep runs then, and Hessian products are zero.
    asked: bool,
}

/// Variables, and the corresponding inputs.
#[derive(Clone, Debug)]
struct Point {
    x: Vec<f64>,
    inputs: Inputs,
}

/// A problem without its solver, for use by several threads. Its motions report to the progress callback of the solver.
pub(super) struct Statement {
    system: System,
    settings: Settings,
    inputs: Inputs,
    pub(super) variables: Variables,
    constraints: Vec<Interval>,
    watch: Watch,
}

impl Statement {
    /// The problem at a point.
    ///
    /// # Errors
    /// Inputs at this point that do not fit.
    pub(super) fn at(&self, x: &[f64]) -> Result<MotionProblem, Error> {
        let mut inputs = self.inputs.clone();
        self.variables.write(x, &mut inputs);
        self.with(inputs, self.variables.clone())?.started_at(x)
    }

    /// The problem with another scheme.
    pub(super) fn by(mut self, scheme: Scheme) -> Self {
        self.settings.scheme = scheme;
        self
    }

    /// The problem with other inputs, and with variables for them.
    ///
    /// # Errors
    /// Inputs or variables that do not fit.
    pub(super) fn with(&self, inputs: Inputs, variables: Variables) -> Result<MotionProblem, Error> {
        let mut problem = MotionProblem::new(&self.system, self.settings, inputs, variables)?;
        problem.constraints.clone_from(&self.constraints);
        problem.solver.forward_mut().watch = self.watch.shared([0, 0]);
        Ok(problem)
    }
}

/// Changed inputs, and the variables on their grid.
pub(super) struct Changed {
    known: Point,
    variables: Variables,
}

impl MotionProblem {
    /// A problem with these inputs and free variables.
    ///
    /// # Errors
    /// Inputs that do not fit the system, or variables for another system or number of nodes. For a start that is not assembled: a free
    /// coordinate, velocity or design variable (such as the length of a link) that constraints determine ([`Error::NotFree`]). Readings whose nodes
    /// are at other times ([`Inputs::check_reading_times`]), unless the duration or lengths of steps are free.
    pub fn new(system: &System, settings: Settings, inputs: Inputs, mut variables: Variables) -> Result<Self, Error> {
        inputs.check(system)?;
        variables.check(system, &inputs)?;
        let [before, behind] = inputs.grid.around;
        // The variables of a segment are chosen to fit, and its readings are checked together with the others.
        if before == 0 {
            held::check(system, &settings, &inputs, variables.free())?;
        }
        if before + behind == 0 {
            check_reading_times(system, &inputs, variables.free())?;
        }
        let constraints = default_constraints(system);
        let (x, solver, direction) = (variables.take(&inputs)?, Solver::new(system, settings), inputs.no_change());
        let gradient = vec![0.0; x.len()];
        let known = Point { x, inputs };
        Ok(MotionProblem { solver, variables, constraints, tried: known.clone(), known, gradient, asked: false, direction })
    }

    /// What the problem states, without a solver.
    pub(super) fn statement(&self) -> Statement {
        Statement {
            system: self.solver.system().clone(),
            settings: self.solver.settings(),
            inputs: self.known.inputs.clone(),
            variables: self.variables.clone(),
            constraints: self.constraints.clone(),
            watch: self.solver.forward().watch.shared([0, 0]),
        }
    }

    /// The problem with this start, of which the inputs have only the controls at nodes.
    ///
    /// # Errors
    /// A wrong number of variables.
    pub(super) fn started_at(mut self, x: &[f64]) -> Result<Self, Error> {
        self.sizes().point(x)?;
        self.known.x.copy_from_slice(x);
        self.variables.write(x, &mut self.known.inputs);
        self.tried = self.known.clone();
        Ok(self)
    }

    /// The errors of J and of the outputs at the last evaluated point that the grid causes, if they can be estimated from steps divided into so many parts.
    ///
    /// # Errors
    /// No motion with divided steps.
    pub(super) fn errors_of(&self, values: (f64, &[f64]), parts: usize) -> Result<Option<GridErrors>, Error> {
        grid_errors(self.solver.system(), (&self.tried.inputs, parts), self.solver.settings(), values)
    }

    /// Makes a point the current one, with its motion, if it has one.
    pub(super) fn settle_at(&mut self, x: &[f64]) {
        if self.try_at(x, &mut []).is_ok() {
            self.settle();
        }
    }

    /// Sets the interval of an output; [`Interval::FREE`] only reports it.
    ///
    /// # Panics
    /// If the output belongs to another scene.
    pub fn constrain(&mut self, output: Output, to: Interval) {
        self.set(self.solver.system().place_of(output), to);
    }

    /// Sets the interval of the output with an index.
    pub(super) fn set(&mut self, output: usize, to: Interval) {
        self.constraints[output] = to;
    }

    /// Sets the same interval for several outputs, for example for those of [`Scene::outputs_at`](crate::Scene::outputs_at).
    ///
    /// # Panics
    /// If an output belongs to another scene.
    pub fn constrain_all(&mut self, outputs: &[Output], to: Interval) {
        outputs.iter().for_each(|output| self.constrain(*output, to));
    }

    /// The variables of the current inputs. These are the inputs given to [`new`](Self::new), those set by [`change`](Self::change), or
    /// those of the last point whose evaluation succeeded, whichever is most recent.
    pub fn start(&self) -> Vec<f64> {
        self.known.x.clone()
    }

    /// The inputs at a point.
    ///
    /// # Panics
    /// If the point has fewer variables than the problem.
    pub fn inputs_at(&self, x: &[f64]) -> Inputs {
        assert!(
            x.len() >= self.variables.len(),
            "the point has {} entries, the problem {} variables",
            x.len(),
            self.variables.len()
        );
        let mut inputs = self.known.inputs.clone();
        self.variables.write(x, &mut inputs);
        inputs
    }

    /// Changes the inputs at [`start`](Self::start), such as the lengths of steps, but not their number.
    ///
    /// # Errors
    /// Inputs that no longer fit the system or the variables; nothing is changed in this case.
    pub fn change(&mut self, by: impl FnOnce(&mut Inputs)) -> Result<(), Error> {
        let changed = self.changed(by)?;
        self.take_over(changed);
        Ok(())
    }

    /// Sets the bounds of a free quantity, in its unit, as [`Free::within`](super::Free::within) does when the problem is stated.
    ///
    /// # Errors
    /// A quantity that is not free; empty bounds, or bounds that do not fit its scale or logarithm. Nothing is changed in these cases.
    pub fn bound(&mut self, quantity: &Quantity, to: Interval) -> Result<(), Error> {
        self.variables = self.variables.bounded(self.solver.system(), &self.known.inputs, (quantity, to))?;
        Ok(())
    }

    /// The result of [`change`](Self::change), without applying it.
    pub(super) fn changed(&self, by: impl FnOnce(&mut Inputs)) -> Result<Changed, Error> {
        let known = &self.known.inputs;
        let mut inputs = known.clone();
        by(&mut inputs);
        inputs.check(self.solver.system())?;
        self.variables.check(self.solver.system(), &inputs)?;
        known.start.check_kind(&inputs.start)?;
        let mut variables = self.variables.clone();
        let has_same_steps = inputs.grid.steps == known.grid.steps;
        // If the steps are unchanged, their shares are kept: recomputed ones would differ by rounding.
        let mut x = if has_same_steps { variables.finite(&inputs)? } else { variables.take(&inputs)? };
        if inputs.controls == known.controls {
            // Controls at nodes do not determine coefficients of splines.
            let controls = variables.parts().filter(|(free, _)| free.quantity.control().is_some());
            controls.for_each(|(_, range)| x[range.clone()].copy_from_slice(&self.known.x[range]));
        }
        Ok(Changed { known: Point { x, inputs }, variables })
    }

    /// Applies a change; there is no motion until the next point is evaluated.
    pub(super) fn take_over(&mut self, changed: Changed) {
        (self.known, self.variables) = (changed.known, changed.variables);
        self.tried = self.known.clone();
        self.solver.drop_motion();
    }

    /// Sets the start time of the motion at the next tried point. If it varies, nothing may depend on time explicitly.
    pub(super) fn start_at(&mut self, time: f64) {
        self.tried.inputs.grid.start = time;
    }

    /// As [`evaluate`](Problem::evaluate), but the point does not become the current one.
    ///
    /// # Errors
    /// As `evaluate`.
    pub(super) fn try_at(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        // Callers that need only f pass an empty c.
        if c.is_empty() {
            self.sizes().point(x)?
        } else {
            self.sizes().values(x, c)?
        }
        self.tried.x.copy_from_slice(x);
        self.variables.write(x, &mut self.tried.inputs);
        self.solver.simulate(&self.tried.inputs)?;
        if !c.is_empty() {
            c.copy_from_slice(self.solver.outputs()?.as_slice());
        }
        self.solver.cost()
    }

    /// The inputs of the next tried point.
    pub(super) fn next_inputs(&mut self, x: &[f64]) -> &Inputs {
        self.variables.write(x, &mut self.tried.inputs);
        &self.tried.inputs
    }

    /// Makes the last tried point, which has a value, the current one.
    pub(super) fn settle(&mut self) {
        let Point { x, inputs } = &mut self.known;
        x.copy_from_slice(&self.tried.x);
        inputs.grid.start = self.tried.inputs.grid.start;
        self.variables.write(x, inputs);
    }

    fn sizes(&self) -> Sizes {
        Sizes { variables: self.variables.len(), constraints: self.constraints.len() }
    }

    /// The number of outputs.
    pub(super) fn outputs(&self) -> usize {
        self.constraints.len()
    }

    /// As [`gradient`](Problem::gradient), with weights of (q, v, p\*) at the last node, if there are any.
    ///
    /// # Errors
    /// As `gradient`.
    pub(super) fn gradient_with_end(
        &mut self,
        f_weight: f64,
        (of_outputs, of_end): (&[f64], &[f64]),
        gradient: &mut [f64],
    ) -> Result<(), Error> {
        self.sizes().gradient(of_outputs, gradient)?;
        self.asked = f_weight != 0.0 || of_outputs.iter().chain(of_end).any(|w| *w != 0.0);
        if !self.asked {
            gradient.fill(0.0);
            self.gradient.fill(0.0);
            return Ok(());
        }
        // The one that belongs to the values of this grid.
        let of = self.solver.discrete_gradient(f_weight, of_outputs, of_end)?;
        self.variables.pull_back(&self.tried.x, of, gradient);
        self.gradient.copy_from_slice(gradient);
        Ok(())
    }

    /// The derivatives of outputs and of entries of the state at the last node.
    ///
    /// # Errors
    /// As [`jacobian`](Problem::jacobian).
    pub(super) fn jacobian_of(&mut self, asked: &[Asked], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        let mut row = vec![0.0; self.variables.len()];
        for (k, of) in self.solver.gradients_of_all(asked)?.enumerate() {
            self.variables.pull_back(&self.tried.x, of, &mut row);
            set_row(jacobian, k, &row);
        }
        Ok(())
    }

    /// Begins the Hessian of the function differentiated last along a number of directions; false if it is zero.
    ///
    /// # Errors
    /// As `product`.
    pub(super) fn begin_hessian(&mut self, directions: usize) -> Result<bool, Error> {
        if self.asked {
            self.solver.begin_hessian(directions)?;
        }
        Ok(self.asked)
    }

    /// The next row of the Hessian, along a direction of controls, or of the start if momenta are given, which changes nothing before a node: a part for
    /// each variable, and a part for each of the directions up to this one.
    ///
    /// # Errors
    /// As `product`.
    pub(super) fn hessian_along(&mut self, direction: &[f64], node: usize, own: &mut [f64]) -> Result<&[f64], Error> {
        self.variables.push_forward(&self.tried.x, direction, &mut self.direction);
        let (of, others) = self.solver.hessian_along(&self.direction, node)?;
        self.variables.pull_back(&self.tried.x, of, own);
        self.variables.add_curvature(direction, &self.gradient, own);
        Ok(others)
    }

    /// The free quantities.
    pub fn free(&self) -> &Variables {
        &self.variables
    }
}

/// The default intervals of the outputs.
pub(super) fn default_constraints(system: &System) -> Vec<Interval> {
    let of = |k| if system.is_report_only(k) { Interval::FREE } else { Interval::ZERO };
    (0..system.outputs()).map(of).collect()
}

impl Problem for MotionProblem {
    fn warnings(&self) -> Vec<Warning> {
        let is_asked = self.solver.system().has_cost() || self.constraints.iter().any(|of| *of != Interval::FREE);
        self.solver.report().warnings.iter().cloned().chain((!is_asked).then_some(Warning::NothingAsked)).collect()
    }

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

    fn constraint_name(&self, j: usize) -> String {
        format!("output `{}`", self.solver.system().output_name(j))
    }

    fn is_reading(&self, j: usize) -> bool {
        self.solver.system().is_reading(j)
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        let f = self.try_at(x, c)?;
        self.settle();
        Ok(f)
    }

    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.gradient_with_end(f_weight, (c_weights, &[]), gradient)
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        self.sizes().jacobian(rows, jacobian)?;
        let asked: Vec<Asked> = rows.iter().map(|row| Asked::Output(*row)).collect();
        self.jacobian_of(&asked, jacobian)
    }

    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        let asked: Vec<Asked> = rows.iter().map(|row| Asked::Output(*row)).collect();
        self.solver.jacobian_work(&asked, self.variables.len())
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        self.sizes().push_forward(direction, change)?;
        if direction.iter().all(|x| *x == 0.0) {
            change.fill(0.0);
            return Ok(());
        }
        self.variables.push_forward(&self.tried.x, direction, &mut self.direction);
        change.copy_from_slice(self.solver.push_forward(&self.direction)?.as_slice());
        Ok(())
    }

    fn grid_errors(&self) -> Result<Option<Vec<f64>>, Error> {
        let outputs = self.solver.outputs()?;
        Ok(self.errors_of((0.0, outputs.as_slice()), 2)?.map(|errors| errors.outputs))
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.sizes().product(direction, product)?;
        if !self.asked {
            product.fill(0.0);
            return Ok(());
        }
        self.variables.push_forward(&self.tried.x, direction, &mut self.direction);
        let of = self.solver.hessian_product(&self.direction)?;
        self.variables.pull_back(&self.tried.x, of, product);
        self.variables.add_curvature(direction, &self.gradient, product);
        Ok(())
    }
}
