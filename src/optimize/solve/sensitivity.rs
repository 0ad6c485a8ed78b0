//! [`sensitivities`]: derivatives of a minimum by quantities of its problem.

use super::super::held;
use super::super::problem::{Interval, Problem};
use super::super::stages::{Change, derivatives};
use super::super::{MotionProblem, Options, Outcome};
use super::attempt::{At, Known, at_motion};
use super::guess::Guess;
use super::reach::without_known;
use super::ways::settles_at;
use crate::{Error, Output};

/// A quantity of a problem by which its minimum is differentiated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// The value that an output must have, or both ends of its interval.
    Target(Output),
    /// Both bounds of the variable with this index. If they are equal, this is the value of the variable: hold an initial value or a design variable
    /// by equal bounds ([`Free::within`](super::super::Free::within)) to differentiate by it.
    Bound(usize),
}

/// The derivatives of a minimum by one [`Parameter`].
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// dx/dp of the variables.
    pub x: Vec<f64>,
    /// dJ/dp.
    pub value: f64,
}

/// Computes the derivatives of a minimum x\*(p) by quantities p of its problem: targets, bounds, and the values of held variables.
///
/// They are the changes of a Newton step for the conditions of a minimum (Fiacco 1976), with one factorisation for all parameters:
///
/// ```text
///   K (dx/dp, dw/dp) = −∂/∂p (∇f + ∇c w, c),      K = [∇²(f + wᵀc) + Σ, ∇c; ∇cᵀ, 0],   Σ: curvature of the barrier of bounds
/// ```
///
/// If a bound is active but its multiplier is zero, x\*(p) has a kink, and the derivative is between those on both sides. The problem is left with the
/// motion of the minimum.
///
/// Source: A. V. Fiacco, Mathematical Programming 10 (1976), 287–311.
///
/// ```
/// use hamiltonian_adjoint::optimize::*;
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum};
///
/// let mut cart = CartPendulum::with_links(1).mechanism();
/// cart.scene.effort("effort", cart.force, 1e-2);
/// let place = cart.scene.end_state(cart.cart.coordinates[0]);
/// let system = cart.scene.compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
/// let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force)])?;
/// let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
/// problem.constrain(place.position, Interval::equal(0.5));
/// problem.constrain(place.rate, Interval::ZERO);
/// let options = Options::default();
/// let best = solve(&mut problem, Guess::Straight, &options, &mut silent)?.outcome;
/// let by = sensitivities(&mut problem, &best, &[Parameter::Target(place.position)], &options)?;
/// // The multiplier of a target is the derivative of −J.
/// let multiplier = best.multipliers[place.position.index()];
/// assert!((by[0].value + multiplier).abs() < 1e-5 * multiplier.abs());
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// # Errors
/// An outcome that does not fit the problem or is not a minimum ([`Error::NoMinimum`]); an index without a variable; a held quantity of the start
/// that constraints determine ([`Error::NotFree`]); a problem that
/// [`MultipleShooting`](super::super::MultipleShooting) does not support.
///
/// # Panics
/// If an output belongs to another scene.
pub fn sensitivities(
    problem: &mut MotionProblem,
    minimum: &Outcome,
    by: &[Parameter],
    options: &Options,
) -> Result<Vec<Sensitivity>, Error> {
    Guess::from(minimum).check(problem)?;
    if !minimum.reason.is_converged() {
        return Err(Error::NoMinimum { why: format!("the method ended because {}", minimum.reason) });
    }
    let variables = problem.variables();
    let change = |parameter: &Parameter| match *parameter {
        Parameter::Target(output) => Ok(Change::Output(problem.solver.system().place_of(output))),
        Parameter::Bound(i) if i < variables => Ok(Change::Variable(i)),
        Parameter::Bound(i) => Err(Error::NotAVariable { what: format!("number {i}, counted from 0,"), variables }),
    };
    let changes = by.iter().map(change).collect::<Result<Vec<_>, Error>>()?;
    check_moved(problem, &minimum.x, &changes)?;
    let found = without_known(problem, options.violation, |problem| {
        settles_at(problem, &minimum.x)?;
        let known = Known::of(problem, &minimum.multipliers)?;
        let At { mut shooting, x, near } = at_motion(problem, &known)?;
        derivatives(&mut shooting, (&x, &near), &changes, options)
    })?;
    let of_problem = |x: Vec<f64>| x[..variables].to_vec();
    Ok(found.into_iter().map(|of| Sensitivity { x: of_problem(of.x), value: of.value }).collect())
}

/// Rejects changes of held quantities of the start that constraints determine: the start would violate them.
///
/// # Errors
/// Such a quantity.
fn check_moved(problem: &MotionProblem, x: &[f64], changes: &[Change]) -> Result<(), Error> {
    let mut free = problem.free().free().to_vec();
    for ((_, range), free) in problem.free().parts().zip(&mut free) {
        if changes.iter().any(|change| matches!(change, Change::Variable(i) if range.contains(i))) {
            free.bounds = Interval::FREE;
        }
    }
    held::check(problem.solver.system(), &problem.solver.settings(), &problem.inputs_at(x), &free)
}
