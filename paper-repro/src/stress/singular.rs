//! Motions through configurations where the constraints lose rank.

use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, Start, simulate};
use nalgebra::DVector;

use super::assembly::{Mechanism, Units};
use super::motion::{March, deviation, gradient_error};
use super::row::{Found, Measure, Trial};
use super::scenes;

const GROUP: &str = "singular";
const SINGULAR: &str = "the configuration is singular";

pub fn trials() -> Vec<Trial> {
    let through = |what: &str, build: fn() -> Result<Mechanism, Error>, speed: f64| {
        Trial::new(GROUP, what, move || {
            let mechanism = build()?;
            passes(&mechanism, turned(&mechanism, speed)?)
        })
        .or_refused(SINGULAR)
    };
    vec![
        through("slider-crank of equal lengths through dead centre", || scenes::slider_crank(Units::SI, 0.6, 0.6, 1.0), 6.0)
            .open("steps across the singular configuration do not keep the energy"),
        through("parallelogram that passes flat", || scenes::parallelogram(2, 1.0), -6.0),
        through("rhombus through the meeting of its branches", || scenes::rhombus(1.0), -4.0),
        through(
            "slider-crank of equal lengths, at dead centre",
            || scenes::slider_crank(Units::SI, 0.6, 0.6, std::f64::consts::FRAC_PI_2),
            6.0,
        ),
        through("parallelogram, started flat", || scenes::parallelogram(2, 0.0), 0.0),
        through("rhombus, started flat", || scenes::rhombus(0.0), 0.0),
        through(
            "slider-crank of equal lengths, 1e-6 rad beside dead centre",
            || scenes::slider_crank(Units::SI, 0.6, 0.6, std::f64::consts::FRAC_PI_2 - 1e-6),
            0.0,
        ),
    ]
}

/// The start at which the first body turns at this speed (rad/s) and all else follows.
fn turned(mechanism: &Mechanism, speed: f64) -> Result<Start, Error> {
    let system = &mechanism.system;
    let angle = mechanism.angle(0);
    let mut inputs = Inputs::at_rest(system, Grid::uniform(1, 1e-6));
    let mut push = DVector::zeros(system.n());
    push[angle] = 1.0;
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star: push.clone() };
    let response = simulate(system, &inputs, Settings::default())?.v[(angle, 0)];
    Ok(Start::Momentum { q: system.initial_coordinates(), p_star: push * (speed / response) })
}

/// 3 s with energy kept, constraints kept, and the exact gradient.
fn passes(mechanism: &Mechanism, start: Start) -> Result<Found, Error> {
    let march = March { start: start.clone(), ..March::new(&mechanism.system, 600, 0.005) };
    let record = march.record(|q, v| mechanism.energy(q, v)).complete()?;
    let drift = march.violations().complete()?.iter().fold(0.0, |most, (_, violation)| f64::max(most, *violation));
    let report = march.run(|_, _| {})?;
    let mut inputs = super::motion::shaken(&mechanism.system, 600, 0.005, 0.0);
    inputs.start = start;
    let error = gradient_error(&mechanism.system, &inputs, Settings::default(), 6)?;
    Ok(vec![
        Measure::at_most("energy error [J]", deviation(&record, (0.0, 1.0)), 0.1),
        Measure::at_most("‖Φ‖ [m]", drift, 1e-2),
        // A solve loses the digits of a pivot, and a derivative is the product of two.
        Measure::at_most("gradient error", error, (1e-13 / report.worst_pivot.powi(2)).min(1e-4)),
        Measure::told("smallest pivot", report.worst_pivot),
    ]
    .into())
}
