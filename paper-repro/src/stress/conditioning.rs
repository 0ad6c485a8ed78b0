//! Digits lost in linear solves, and growth of the adjoint.

use hamiltonian_adjoint::{Error, Settings, Solver, System};

use super::motion::{March, shaken};
use super::row::{Measure, Trial};
use crate::assembly::Units;
use crate::mechanisms as scenes;

pub fn trials(short: bool) -> Vec<Trial> {
    let steps = if short { 2_000 } else { 20_000 };
    let pivot = |what: &str, least: f64, build: fn() -> Result<System, Error>| {
        Trial::new(format!("smallest pivot, {what}"), move || {
            let report = March { control: |t| 2.0 * (3.0 * t).sin(), ..March::new(&build()?, 200, 0.01) }.run(|_| ())?;
            Ok(vec![Measure::between("pivot over its summands", report.worst_pivot, (least, 1.0))])
        })
    };
    vec![
        pivot("cart with 3 links", 0.05, || scenes::paper_cart(3)),
        pivot("cart with 300 links", 1e-3, || scenes::paper_cart(300)),
        pivot("slider-crank", 0.02, || Ok(scenes::crank()?.system)),
        pivot("parallelogram", 0.02, || Ok(scenes::parallelogram(2, -1.2)?.system)),
        pivot("chain, alternating masses 1 : 1e8", 1e-10, || {
            Ok(scenes::chain(Units::SI, &[1.0, 1e8, 1.0, 1e8, 1.0], -1.0, 0.0)?.system)
        }),
        Trial::new(format!("adjoint of a damped chain, {steps} steps back"), move || adjoint_growth(steps)),
    ]
}

/// A stable motion has a bounded adjoint: the adjoint variables are compared with their values at the end.
fn adjoint_growth(steps: usize) -> Result<Vec<Measure>, Error> {
    let mechanism = scenes::chain(Units::SI, &[1.0, 0.8, 0.6], -1.5, 0.5)?;
    let settings = Settings { keep_adjoint: true, ..Settings::default() };
    let mut solver = Solver::new(&mechanism.system, settings);
    solver.simulate(&shaken(&mechanism.system, steps, 0.01, 0.3))?;
    solver.gradient()?;
    let (pivot, adjoint) = (solver.adjoint_report().worst_pivot, solver.adjoint_variables());
    let growth = adjoint.map_or(f64::NAN, |w| {
        let window = steps / 10;
        let late = w.b.columns(steps - window, window).amax();
        w.b.columns(1, steps - window).amax() / late
    });
    Ok(vec![
        Measure::at_most("largest b before the last tenth of the motion over the largest in it", growth, 1.0),
        Measure::between("pivot over its summands", pivot, (0.01, 1.0)),
    ])
}
