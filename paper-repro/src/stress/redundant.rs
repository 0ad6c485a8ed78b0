//! Constraints that follow from others: the motion must be that of an independent subset.

use hamiltonian_adjoint::{Error, Gradient, Settings, Solver};

use super::assembly::Mechanism;
use super::motion::{gradient_error, shaken};
use super::row::{Found, Measure, Trial};
use super::scenes;
use crate::statistics::relative_difference;

const GROUP: &str = "redundant";
const DEPENDENT: &str = "constraints depend on each other";

pub fn trials() -> Vec<Trial> {
    type Build = fn() -> Result<Mechanism, Error>;
    let like = |what: &str, redundant: Build, independent: Build| {
        Trial::new(GROUP, what, move || compare(&redundant()?, &independent()?)).or_refused(DEPENDENT)
    };
    vec![
        like("double pendulum, elbow hinged twice", || scenes::doubled_hinge(2), || scenes::doubled_hinge(1)),
        like("parallelogram with a third crank", || scenes::parallelogram(3, 1.0), || scenes::parallelogram_with_idle(1.0)),
        like("triangle closed by a third weld", || scenes::triangle(true), || scenes::triangle(false)),
    ]
}

fn numbers(mechanism: &Mechanism) -> Result<(Vec<f64>, Gradient, f64), Error> {
    let inputs = shaken(&mechanism.system, 200, 0.005, 5.0);
    let mut solver = Solver::new(&mechanism.system, Settings::default());
    let q = solver.simulate(&inputs)?.q.as_slice().to_vec();
    let gradient = solver.gradient()?.clone();
    Ok((q, gradient, gradient_error(&mechanism.system, &inputs, Settings::default(), 6)?))
}

/// Both have the same coordinates, controls and cost.
fn compare(redundant: &Mechanism, independent: &Mechanism) -> Result<Found, Error> {
    let (reference, exact, _) = numbers(independent)?;
    let (q, gradient, error) = numbers(redundant)?;
    let difference = relative_difference(gradient.controls.as_slice(), exact.controls.as_slice());
    Ok(vec![
        Measure::at_most("motion", relative_difference(&q, &reference), 1e-8),
        Measure::at_most("gradient", difference, 1e-7),
        Measure::at_most("gradient error", error, 1e-8),
    ]
    .into())
}
