//! Direct differentiation: the tangent system of the whole motion, in one direction of the inputs.
//!
//! With δ for d/ds along the direction, every step solves the same linear system as Newton,
//!
//! ```text
//!   K δ(v, σ)_i = −(derivative of the step's residual with q₋, v₋, p*₋, ṗ*₋, u, b, h moved and (v, σ)_i held)
//! ```
//!
//! once (and once more to confirm it), with the derivatives of the plain element formulas by dual numbers. One sweep gives
//! dJ/ds and dy/ds at all nodes: for a few design variables and many outputs it is the better half of the two methods.

use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;

use crate::number::Real;
use crate::{Error, Grid, Inputs, LiftedSolver, Settings, Stages, Start, System, Trajectory};

/// How a motion and its cost change along a direction of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// dJ/ds.
    pub cost: f64,
    /// dy/ds at all nodes.
    pub motion: Trajectory,
}

/// dJ/ds and dy/ds at s = 0 for the inputs x + s·`direction`.
///
/// `direction` has the shape of the inputs; [`no_change`] gives one of zeros to set what shall move. Initial values
/// may leave the constraints: the derivative is that of the motion from the moved values.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, check, gradient, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
/// inputs.controls.fill(10.0);
/// let mut push = check::no_change(&inputs);
/// push.controls.row_mut(0).fill(1.0);
/// let settings = Settings::default();
/// let sensitivity = check::direct_differentiation(&system, &inputs, settings, &push)?;
/// let adjoint = gradient(&system, &inputs, settings)?.controls.sum();
/// assert!((sensitivity.cost - adjoint).abs() < 1e-12 * adjoint.abs());
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// # Errors
/// As [`Solver::simulate`](crate::Solver::simulate); a direction of another shape, or with numbers that are not finite.
pub fn direct_differentiation(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    direction: &Inputs,
) -> Result<Sensitivity, Error> {
    let mut solver = LiftedSolver::<Dual64>::new(system, inputs, settings)?;
    let moved = moved(inputs, direction, Dual64::new)?;
    let motion = derivative(solver.simulate(&moved)?);
    Ok(Sensitivity { cost: solver.cost()?.eps, motion })
}

/// A direction of zeros, to be changed.
pub fn no_change(inputs: &Inputs) -> Inputs {
    let zero = |x: &DVector<f64>| DVector::zeros(x.len());
    let start = match &inputs.start {
        Start::Velocity { q, v } => Start::Velocity { q: zero(q), v: zero(v) },
        Start::Momentum { q, p_star } => Start::Momentum { q: zero(q), p_star: zero(p_star) },
        Start::Assembled { q, v, held } => Start::Assembled { q: zero(q), v: zero(v), held: held.clone() },
    };
    let grid = Grid { start: 0.0, steps: vec![0.0; inputs.grid.steps.len()], ..inputs.grid };
    Inputs { grid, start, controls: inputs.controls.map(|_| 0.0), design: zero(&inputs.design) }
}

/// The inputs on other numbers, each made of its value and its change.
pub(super) fn moved<R: Real>(inputs: &Inputs, direction: &Inputs, make: impl Fn(f64, f64) -> R) -> Result<Inputs<R>, Error> {
    let sizes = [
        ("direction: time steps", inputs.grid.steps.len(), direction.grid.steps.len()),
        ("direction: q0", inputs.start.q().len(), direction.start.q().len()),
        ("direction: v0 or p*0", inputs.start.rate().len(), direction.start.rate().len()),
        ("direction: controls: rows (channels)", inputs.controls.nrows(), direction.controls.nrows()),
        ("direction: controls: columns (nodes)", inputs.controls.ncols(), direction.controls.ncols()),
        ("direction: design variables", inputs.design.len(), direction.design.len()),
    ];
    if let Some((what, expected, found)) = sizes.into_iter().find(|(_, expected, found)| expected != found) {
        return Err(Error::Size { what, expected, found });
    }
    inputs.start.check_kind(&direction.start)?;
    let starts = direction.start.q().iter().chain(direction.start.rate().iter());
    let changes = direction.grid.steps.iter().chain([&direction.grid.start]).chain(starts);
    let mut changes = changes.chain(direction.controls.iter()).chain(direction.design.iter());
    if let Some(&value) = changes.find(|x| !x.is_finite()) {
        return Err(Error::NotFinite { what: "a number of the direction".into(), value });
    }
    let mut moved = inputs.lift::<R>();
    let change = |to: &mut [R], from: &[f64], by: &[f64]| {
        to.iter_mut().zip(from.iter().zip(by)).for_each(|(to, (&x, &d))| *to = make(x, d));
    };
    change(&mut moved.grid.steps, &inputs.grid.steps, &direction.grid.steps);
    moved.grid.start = make(inputs.grid.start, direction.grid.start);
    change(moved.start.q_mut().as_mut_slice(), inputs.start.q().as_slice(), direction.start.q().as_slice());
    change(moved.start.rate_mut().as_mut_slice(), inputs.start.rate().as_slice(), direction.start.rate().as_slice());
    change(moved.controls.as_mut_slice(), inputs.controls.as_slice(), direction.controls.as_slice());
    change(moved.design.as_mut_slice(), inputs.design.as_slice(), direction.design.as_slice());
    Ok(moved)
}

fn derivative(motion: &Trajectory<Dual64>) -> Trajectory {
    let part = |matrix: &DMatrix<Dual64>| matrix.map(|x| x.eps);
    Trajectory {
        computed: motion.computed,
        times: motion.times.iter().map(|t| t.eps).collect(),
        q: part(&motion.q),
        v: part(&motion.v),
        p_star: part(&motion.p_star),
        p_star_dot: part(&motion.p_star_dot),
        sigma: part(&motion.sigma),
        compliance: motion.compliance.clone(),
        inserted: motion.inserted.clone(),
        restarted: motion.restarted.clone(),
        scheme: motion.scheme,
        stages: Stages {
            times: motion.stages.times.iter().map(|t| t.eps).collect(),
            q: part(&motion.stages.q),
            v: part(&motion.stages.v),
            p_star: part(&motion.stages.p_star),
            p_star_dot: part(&motion.stages.p_star_dot),
            sigma: part(&motion.stages.sigma),
            u: part(&motion.stages.u),
        },
    }
}
