//! Direct differentiation: the tangent system of the whole motion, in one direction of the inputs.
//!
//! With δ = d/ds along the direction, every step solves the linear system of Newton's method,
//!
//! ```text
//!   K δ(v, σ)_i = −(derivative of the step's residual with q₋, v₋, p*₋, ṗ*₋, u, b, h varied and (v, σ)_i fixed)
//! ```
//!
//! once (and once more to confirm it), with the derivatives of the plain element formulas by dual numbers. One sweep computes
//! dJ/ds and dy/ds at all nodes: for few design variables and many outputs it is cheaper than the adjoint method.

use nalgebra::DVector;
use num_dual::Dual64;

use crate::number::Real;
use crate::{Error, Inputs, LiftedSolver, Settings, System, Trajectory};

/// Derivatives of a motion, its cost and its outputs along a direction of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// dJ/ds.
    pub cost: f64,
    /// dr/ds of all outputs r.
    pub outputs: DVector<f64>,
    /// dy/ds at all nodes.
    pub motion: Trajectory,
}

/// dJ/ds and dy/ds at s = 0 for the inputs x + s·`direction`.
///
/// `direction` has the shape of the inputs; start from the zeros of [`Inputs::no_change`]. Initial values along the direction may violate
/// the constraints: the derivative is that of the motion from the shifted values.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, check, gradient, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
/// inputs.controls.fill(10.0);
/// let mut push = inputs.no_change();
/// push.controls.row_mut(0).fill(1.0);
/// let settings = Settings::default();
/// let sensitivity = check::direct_differentiation(&system, &inputs, settings, &push)?;
/// let adjoint = gradient(&system, &inputs, settings)?.controls.sum();
/// assert!((sensitivity.cost - adjoint).abs() < 1e-12 * adjoint.abs());
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// # Errors
/// As [`Solver::simulate`](crate::Solver::simulate), or a direction of wrong size or with numbers that are not finite.
pub fn direct_differentiation(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    direction: &Inputs,
) -> Result<Sensitivity, Error> {
    let mut solver = LiftedSolver::<Dual64>::new(system, inputs, settings)?;
    let moved = moved(inputs, direction, Dual64::new)?;
    let motion = solver.simulate(&moved)?;
    let motion = motion.zip_map(motion, |y, _| y.eps);
    Ok(Sensitivity { cost: solver.cost()?.eps, outputs: solver.outputs()?.map(|r| r.eps), motion })
}

/// Converts the inputs to another number type; each number is made from its value and its change along the direction.
pub(super) fn moved<R: Real>(inputs: &Inputs, direction: &Inputs, make: impl Fn(f64, f64) -> R) -> Result<Inputs<R>, Error> {
    inputs.check_direction(direction, 0)?;
    Ok(inputs.along(direction, make))
}
