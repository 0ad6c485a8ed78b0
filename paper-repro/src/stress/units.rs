//! One mechanism in several units: after conversion, motion and gradient are the same numbers.

use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, Solver, System};

use super::row::{Measure, Trial};
use crate::assembly::Units;
use crate::mechanisms as scenes;
use crate::statistics::relative_difference;

/// Permitted rounding error of a hundred steps.
const SAME: f64 = 1e-12;

pub fn trials() -> Vec<Trial> {
    let unit = |length, mass, time| Units { length, mass, time };
    let systems = [
        ("mm, t, s", unit(1e3, 1e-3, 1.0)),
        ("mm, t, ms", unit(1e3, 1e-3, 1e3)),
        ("lengths × 1e6", unit(1e6, 1.0, 1.0)),
        ("lengths × 1e-6", unit(1e-6, 1.0, 1.0)),
        ("masses × 1e6", unit(1.0, 1e6, 1.0)),
        ("masses × 1e-6", unit(1.0, 1e-6, 1.0)),
        ("lengths and masses × 1e6", unit(1e6, 1e6, 1.0)),
        ("lengths and masses × 1e-6", unit(1e-6, 1e-6, 1.0)),
        ("lengths × 1e-12, masses × 1e-20, times × 1e6", unit(1e-12, 1e-20, 1e6)),
    ];
    let of = |name: &'static str, run: fn(Units) -> Result<Vec<Measure>, Error>| {
        systems.map(|(words, units)| Trial::new(format!("{name}, {words}"), move || run(units)))
    };
    let scenes = [of("cart with three links", cart), of("slider-crank with a closed loop", slider_crank)];
    scenes.into_iter().flatten().collect()
}

fn cart(units: Units) -> Result<Vec<Measure>, Error> {
    let build = |units| scenes::cart(units, 3).scene().compile();
    compare((&build(Units::SI)?, 10.0), (&build(units)?, 10.0 * units.force()), units)
}

fn slider_crank(units: Units) -> Result<Vec<Measure>, Error> {
    let build = |units| scenes::slider_crank(units, 0.4, 0.9, 1.0);
    compare((&build(Units::SI)?.system, 3.0), (&build(units)?.system, 3.0 * units.torque()), units)
}

/// The coordinates in m and rad, u dJ/du, and the smallest pivot.
fn numbers((system, control): (&System, f64), units: Units) -> Result<(Vec<f64>, Vec<f64>, f64), Error> {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(100, 0.01 * units.time));
    inputs.controls.fill(control);
    let settings = Settings {
        position_tolerance: 1e-9 * units.length,
        velocity_tolerance: 1e-9 * units.speed(),
        ..Settings::default()
    };
    let mut solver = Solver::new(system, settings);
    let motion = solver.simulate(&inputs)?;
    // (x, y, φ) of each body.
    let lengths = |i: usize| if i % 3 == 2 { 1.0 } else { units.length };
    let q = motion.q.iter().enumerate().map(|(i, q)| q / lengths(i % system.n())).collect();
    let gradient = solver.gradient()?.controls.iter().map(|d| d * control).collect();
    Ok((q, gradient, solver.report().worst_pivot))
}

fn compare(of_si: (&System, f64), of_units: (&System, f64), units: Units) -> Result<Vec<Measure>, Error> {
    let ((q, gradient, pivot), (other_q, other_gradient, other_pivot)) =
        (numbers(of_si, Units::SI)?, numbers(of_units, units)?);
    Ok(vec![
        Measure::at_most("motion", relative_difference(&other_q, &q), SAME),
        Measure::at_most("gradient", relative_difference(&other_gradient, &gradient), SAME),
        Measure::between("ratio of the smallest pivots", other_pivot / pivot, (0.5, 2.0)),
    ])
}
