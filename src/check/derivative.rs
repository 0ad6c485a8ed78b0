//! dJ/dx for single inputs x, without the adjoint.

use num_dual::Dual64;

use super::draw::check_number;
use crate::number::Real;
use crate::{Cx, Error, Gradient, Inputs, LiftedSolver, Settings, Solver, System};

/// One scalar input of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Input {
    /// A control channel at a node.
    Control {
        /// The channel.
        channel: usize,
        /// The node, 0 … N.
        node: usize,
    },
    /// A design variable.
    Design(usize),
    /// A coordinate of q₀.
    Coordinate(usize),
    /// A component of v₀ or p*₀.
    Rate(usize),
    /// The length of step i = 1 … N.
    Step(usize),
}

impl Input {
    /// All controls, design variables, initial values and step lengths of a motion.
    pub fn all(inputs: &Inputs) -> Vec<Input> {
        let (channels, nodes) = inputs.controls.shape();
        let n = inputs.start.q().len();
        let controls = (0..nodes).flat_map(|node| (0..channels).map(move |channel| Input::Control { channel, node }));
        controls
            .chain((0..inputs.design.len()).map(Input::Design))
            .chain((0..n).map(Input::Coordinate))
            .chain((0..n).map(Input::Rate))
            .chain((1..nodes).map(Input::Step))
            .collect()
    }

    /// Name for reports; it is defined even for an input that the system does not have.
    pub fn name(&self, system: &System) -> String {
        let (n, k, designs) = (system.n(), system.k(), system.designs());
        match *self {
            Input::Control { channel, node } if channel < k => format!("`{}` at node {node}", system.control_name(channel)),
            Input::Design(p) if p < designs => format!("`{}`", system.design_name(p)),
            Input::Coordinate(i) if i < n => format!("the initial value of `{}`", system.coordinate_name(i)),
            Input::Rate(i) if i < n => format!("the initial rate of `{}`", system.coordinate_name(i)),
            other @ Input::Step(_) => other.plain_name(),
            other => format!("{} (of another system)", other.plain_name()),
        }
    }

    /// Name made of indices, for an input that the system does not have.
    fn plain_name(self) -> String {
        match self {
            Input::Control { channel, node } => format!("control {channel} at node {node}"),
            Input::Design(p) => format!("design variable {p}"),
            Input::Coordinate(i) => format!("initial coordinate {i}"),
            Input::Rate(i) => format!("initial rate {i}"),
            Input::Step(i) => format!("the length of step {i}"),
        }
    }

    /// Returns an error for an input that the motion does not have.
    fn check(self, inputs: &Inputs) -> Result<(), Error> {
        let (channels, nodes) = inputs.controls.shape();
        let exists = match self {
            Input::Control { channel, node } => channel < channels && node < nodes,
            Input::Design(p) => p < inputs.design.len(),
            Input::Coordinate(i) | Input::Rate(i) => i < inputs.start.q().len(),
            Input::Step(i) => (1..nodes).contains(&i),
        };
        if exists { Ok(()) } else { Err(Error::NoSuchInput { input: self.plain_name() }) }
    }

    /// Mutable access to the value in the inputs.
    ///
    /// # Panics
    /// If the input is not one of [`Input::all`] for these inputs.
    pub fn of<R: Real>(self, inputs: &mut Inputs<R>) -> &mut R {
        match self {
            Input::Control { channel, node } => &mut inputs.controls[(channel, node)],
            Input::Design(p) => &mut inputs.design[p],
            Input::Coordinate(i) => &mut inputs.start.q_mut()[i],
            Input::Rate(i) => &mut inputs.start.rate_mut()[i],
            Input::Step(i) => &mut inputs.grid.steps[i - 1],
        }
    }

    /// The derivative with respect to this input, read from a gradient.
    ///
    /// # Panics
    /// If the input is not one of [`Input::all`] for the inputs of the gradient.
    pub fn in_gradient(self, gradient: &Gradient) -> f64 {
        match self {
            Input::Control { channel, node } => gradient.controls[(channel, node)],
            Input::Design(p) => gradient.design[p],
            Input::Coordinate(i) => gradient.start.q()[i],
            Input::Rate(i) => gradient.start.rate()[i],
            Input::Step(i) => gradient.steps[i - 1],
        }
    }
}

/// dJ/dx = Im J(x + i h)/h with h = 1e-30, one simulation for each input.
///
/// # Errors
/// As [`Solver::simulate`], or an input that the motion does not have.
pub fn complex_step(system: &System, inputs: &Inputs, settings: Settings, with: &[Input]) -> Result<Vec<f64>, Error> {
    const STEP: f64 = 1e-30;
    through_lifted::<Cx>(system, inputs, settings, with, STEP)
}

/// dJ/dx by dual numbers through the entire simulation, one simulation for each input.
///
/// # Errors
/// As [`Solver::simulate`]; an input that the motion does not have.
pub fn tangent(system: &System, inputs: &Inputs, settings: Settings, with: &[Input]) -> Result<Vec<f64>, Error> {
    through_lifted::<Dual64>(system, inputs, settings, with, 1.0)
}

fn through_lifted<R: Real>(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    with: &[Input],
    step: f64,
) -> Result<Vec<f64>, Error> {
    let mut solver = LiftedSolver::<R>::new(system, inputs, settings)?;
    let lifted = inputs.lift::<R>();
    let one = |input: &Input| {
        input.check(inputs)?;
        let mut perturbed = lifted.clone();
        input.of(&mut perturbed).add_to_part(1, step);
        solver.simulate(&perturbed)?;
        Ok(solver.cost()?.part(1) / step)
    };
    with.iter().map(one).collect()
}

/// dJ/dx ≈ (J(x + s) − J(x − s))/2s with s = `step` · max(1, |x|), two simulations for each input.
///
/// Shifted initial values that violate the constraints by more than the tolerances are an error, as in any simulation.
///
/// # Errors
/// As [`Solver::simulate`], an input that the motion does not have, or a step that is NaN or below rounding.
pub fn central_differences(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    with: &[Input],
    step: f64,
) -> Result<Vec<f64>, Error> {
    let visible = step.is_finite() && step.abs() >= f64::EPSILON;
    check_number("the step of the differences", step, visible, "finite and not below rounding, 2.2e-16")?;
    let mut solver = Solver::new(system, settings);
    let mut cost = |input: Input, change: f64| -> Result<f64, Error> {
        let mut perturbed = inputs.clone();
        *input.of(&mut perturbed) += change;
        solver.simulate(&perturbed)?;
        solver.cost()
    };
    let one = |&input: &Input| {
        input.check(inputs)?;
        let x = *input.of(&mut inputs.clone());
        // The step rounded such that x + s is exact.
        let s = (x + step * x.abs().max(1.0)) - x;
        Ok((cost(input, s)? - cost(input, -s)?) / (2.0 * s))
    };
    with.iter().map(one).collect()
}
