//! Motions through configurations in which the constraints lose rank.

use std::f64::consts::{FRAC_PI_2, PI};

use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, Start, simulate};
use nalgebra::DVector;

use super::motion::{March, deviation, gradient_error_on_constraints, mechanics};
use super::row::{Measure, Trial};
use crate::assembly::{Mechanism, Units};
use crate::mechanisms as scenes;

const SINGULAR: &str = "the configuration is singular";
const CRANK: &str = "slider-crank of equal lengths through dead centre";
const PARALLELOGRAM: &str = "parallelogram that passes flat";
const FOUR_BAR: &str = "four-bar of equal lengths through its branch point";

pub fn trials() -> Vec<Trial> {
    type Build = fn() -> Result<Mechanism, Error>;
    let through = |what: &str, build: Build, speed: f64| {
        Trial::new(what, move || {
            let mechanism = build()?;
            passes(&mechanism, turned(&mechanism, speed)?)
        })
    };
    let gradient = |what: &str, build: Build, speed: f64| {
        Trial::new(format!("{what}, gradient"), move || {
            let mechanism = build()?;
            is_exact(&mechanism, turned(&mechanism, speed)?)
        })
    };
    let started = |what: &str, build: Build| {
        Trial::new(what, move || {
            let mechanism = build()?;
            passes(&mechanism, March::new(&mechanism.system, 1, 1.0).start)
        })
        .must_refuse(SINGULAR, |error| matches!(error, Error::SingularConfiguration { step: 0, .. }))
    };
    vec![
        Trial::new(CRANK, || {
            let mechanism = equal_slider_crank(1.0)?;
            passes_with_order(&mechanism, &turned(&mechanism, 6.0)?)
        }),
        gradient(CRANK, || equal_slider_crank(1.0), 6.0),
        through(PARALLELOGRAM, || scenes::parallelogram(2, 1.0), -6.0),
        gradient(PARALLELOGRAM, || scenes::parallelogram(2, 1.0), -6.0),
        through(FOUR_BAR, || scenes::rhombus(1.0), -4.0),
        gradient(FOUR_BAR, || scenes::rhombus(1.0), -4.0),
        started("slider-crank of equal lengths, started at dead centre", || equal_slider_crank(FRAC_PI_2)),
        started("parallelogram, started flat", || scenes::parallelogram(2, 0.0)),
        started("parallelogram, started flat at half a turn", || scenes::parallelogram(2, PI)),
        started("four-bar of equal lengths, started at its branch point", || scenes::rhombus(0.0)),
        through(
            "slider-crank of equal lengths, at rest 1e-6 rad beside dead centre",
            || equal_slider_crank(FRAC_PI_2 - 1e-6),
            0.0,
        )
        .or_refused(SINGULAR, |error| matches!(error, Error::SingularConfiguration { .. })),
    ]
}

fn equal_slider_crank(angle: f64) -> Result<Mechanism, Error> {
    scenes::slider_crank(Units::SI, 0.6, 0.6, angle)
}

/// The start at which the first body turns at this speed (rad/s); all other velocities follow.
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

/// A motion of 3 s from this start.
fn march(steps: usize, mechanism: &Mechanism, start: Start) -> March<'_> {
    March { start, ..March::new(&mechanism.system, steps, 3.0 / steps as f64) }
}

/// The rule has order two, and a singular configuration does not change this if the motion is determined: the energy error near the
/// configuration falls like Δt², and most of it disappears afterwards.
fn passes_with_order(mechanism: &Mechanism, start: &Start) -> Result<Vec<Measure>, Error> {
    let energies = |steps: usize| -> Result<[f64; 2], Error> {
        let of = march(steps, mechanism, start.clone()).record(|at| mechanism.energy(at.q, at.v)).complete()?;
        Ok([deviation(&of, (0.0, 1.0)), (of[steps].1 - of[0].1).abs()])
    };
    let [long, middle, short] = [energies(600)?, energies(1200)?, energies(2400)?];
    Ok(vec![
        Measure::between("order of the energy error", (long[0] / middle[0]).log2(), (1.9, 2.1)),
        Measure::between("order of the energy error, from shorter steps", (middle[0] / short[0]).log2(), (1.9, 2.1)),
        Measure::reported("energy error [J] at Δt = 5 ms", long[0]),
        Measure::reported("energy error [J] after 3 s", long[1]),
    ])
}

/// Measures of energy and constraints.
fn passes(mechanism: &Mechanism, start: Start) -> Result<Vec<Measure>, Error> {
    let (mut drift, mut record) = (0.0f64, Vec::new());
    let (phi, mut least, mut most) = (mechanism.angle(0), f64::INFINITY, f64::NEG_INFINITY);
    let report = march(600, mechanism, start).run(|at| {
        drift = drift.max(mechanics(&mechanism.system, at).phi().amax());
        (least, most) = (least.min(at.q[phi]), most.max(at.q[phi]));
        record.push((at.time, mechanism.energy(at.q, at.v)));
    })?;
    Ok(vec![
        Measure::at_most("energy error [J]", deviation(&record, (0.0, 1.0)), 0.1),
        Measure::at_most("‖Φ‖ [m]", drift, 1e-2),
        Measure::reported("turned by [rad]", most - least),
        Measure::reported("smallest pivot", report.worst_pivot),
    ])
}

/// A solve loses as many digits as the pivot, and a derivative is the product of two solves.
fn is_exact(mechanism: &Mechanism, start: Start) -> Result<Vec<Measure>, Error> {
    let march = march(600, mechanism, start);
    let pivot = march.run(|_| ())?.worst_pivot;
    let error = gradient_error_on_constraints(&mechanism.system, &march.inputs(), 6)?;
    Ok(vec![Measure::at_most("gradient error", error, (1e-13 / pivot.powi(2)).min(1e-4))])
}
