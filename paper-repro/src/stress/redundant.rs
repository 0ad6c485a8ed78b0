//! Constraints that follow from others: the motion must be that of an independent subset.

use hamiltonian_adjoint::planar::Harmonic;
use hamiltonian_adjoint::{Error, Settings, Solver, Warning};

use super::motion::{gradient_error_on_constraints, shaken};
use super::row::{Measure, Trial};
use crate::assembly::{GROUND, Mechanism};
use crate::mechanisms as scenes;
use crate::statistics::relative_difference;

/// Permitted effect of a compliance of 1e-11, and permitted difference of an exact gradient from complex step with it.
const SAME: f64 = 1e-9;

pub fn trials() -> Vec<Trial> {
    type Build = fn() -> Result<Mechanism, Error>;
    let like = |what: &str, named: f64, redundant: Build, independent: Build| {
        Trial::new(what, move || compare(&redundant()?, &independent()?, named))
    };
    let refused = |what: &str, names: [&'static str; 2], build: Build| {
        let by_name = move |error: &Error| match error {
            Error::ContradictoryConstraints { equations, .. } => {
                names.iter().all(|name| equations.iter().any(|equation| equation.contains(name)))
            }
            _ => false,
        };
        Trial::new(what, move || compare(&build()?, &scenes::doubled_hinge(1)?, 0.0))
            .must_refuse("constraints that contradict each other, by name", by_name)
    };
    vec![
        like("double pendulum, elbow hinged twice", 4.0, || scenes::doubled_hinge(2), || scenes::doubled_hinge(1)),
        like("double pendulum, elbow hinged three times", 6.0, || scenes::doubled_hinge(3), || scenes::doubled_hinge(1)),
        like(
            "parallelogram with a third crank, compared with one held by half a hinge",
            12.0,
            || scenes::parallelogram(3, -1.2),
            || scenes::parallelogram_with_half_a_hinge(-1.2),
        ),
        like("triangle closed by a third weld", 9.0, || scenes::triangle(true), || scenes::triangle(false)),
        refused("elbow hinged at two places", ["hinge 2", "hinge 3"], || {
            scenes::elbow(|assembly, [upper, lower]| {
                let (a, b) = (assembly.point(upper, [1.0, 0.1]), assembly.point(lower, [1.0, 0.0]));
                assembly.scene.revolute("hinge 3", a, b);
            })
        }),
        refused("two drives of one angle that diverge", ["first drive", "second drive"], || {
            scenes::elbow(|assembly, [upper, _]| {
                for (name, amplitude) in [("first drive", 0.3), ("second drive", 0.301)] {
                    let (ground, upper) = (assembly.frame(GROUND), assembly.frame(upper));
                    let constants = [-amplitude, amplitude, 3.0, std::f64::consts::FRAC_PI_2].map(Into::into);
                    assembly.scene.driven_angle(name, ground, upper, Harmonic, constants);
                }
            })
        }),
    ]
}

/// A motion, its gradient, and the report of the run.
struct Run {
    q: Vec<f64>,
    gradient: Vec<f64>,
    multiplier: f64,
    /// Number of equations that the warning names.
    named: usize,
}

fn run(mechanism: &Mechanism) -> Result<Run, Error> {
    let mut solver = Solver::new(&mechanism.system, Settings::default());
    let motion = solver.simulate(&shaken(&mechanism.system, 200, 0.005, 5.0))?;
    let (q, multiplier) = (motion.q.as_slice().to_vec(), motion.sigma.amax());
    let gradient = solver.gradient()?.controls.as_slice().to_vec();
    let of = |warning: &Warning| match warning {
        Warning::DependentConstraints { equations, .. } => equations.len(),
        _ => 0,
    };
    Ok(Run { q, gradient, multiplier, named: solver.report().warnings.iter().map(of).sum() })
}

/// Both scenes have the same coordinates, controls and cost.
fn compare(redundant: &Mechanism, independent: &Mechanism, named: f64) -> Result<Vec<Measure>, Error> {
    let (expected, found) = (run(independent)?, run(redundant)?);
    let error = gradient_error_on_constraints(&redundant.system, &shaken(&redundant.system, 40, 0.005, 5.0), 12)?;
    Ok(vec![
        Measure::at_most("motion", relative_difference(&found.q, &expected.q), SAME),
        Measure::at_most("gradient", relative_difference(&found.gradient, &expected.gradient), SAME),
        Measure::at_most("gradient error", error, SAME),
        Measure::at_most("|σ| over that without redundancy", found.multiplier / expected.multiplier, 3.0),
        Measure::between("equations that the warning names", found.named as f64, (named, named)),
        Measure::at_most("equations that it names without redundancy", expected.named as f64, 0.0),
    ])
}
