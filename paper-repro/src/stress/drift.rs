//! How far positions drift from their constraints: velocities satisfy dΦ/dt = 0 exactly, positions follow by quadrature.

use hamiltonian_adjoint::{Error, System};

use super::assembly::Units;
use super::motion::{March, Record, deviation, envelope};
use super::row::{Curve, Found, Measure, Quantity, Trial};
use super::scenes;

const GROUP: &str = "drift";
const GROWS: &str = "multipliers grow with time, until a step has no solution";

pub fn trials(short: bool) -> Vec<Trial> {
    let steps = if short { 10_000 } else { 100_000 };
    vec![
        Trial::new(GROUP, "paper's cart, 2 s, over Δt", over_step),
        Trial::new(GROUP, format!("paper's cart, kept moving, {steps} steps"), move || long_cart(steps, false)).open(GROWS),
        Trial::new(
            GROUP,
            format!("paper's cart, kept moving, restarted from q and v at every step, {steps} steps"),
            move || long_cart(steps, true),
        ),
        Trial::new(GROUP, format!("slider-crank without friction, {steps} steps"), move || long_crank(steps, false))
            .open(GROWS),
        Trial::new(
            GROUP,
            format!("slider-crank without friction, restarted from q and v at every step, {steps} steps"),
            move || long_crank(steps, true),
        ),
    ]
}

/// The largest violation, at the first node too.
fn most(record: &[(f64, f64)]) -> f64 {
    record.iter().fold(0.0, |most, (_, violation)| f64::max(most, *violation))
}

fn over_step() -> Result<Found, Error> {
    let system = scenes::cart(Units::SI, 3).scene().compile()?;
    let violation = |steps: usize| -> Result<(f64, f64), Error> {
        let dt = 2.0 / steps as f64;
        Ok((dt, most(&March { control: |_| 10.0, ..March::new(&system, steps, dt) }.violations().complete()?)))
    };
    let points: Vec<(f64, f64)> = [50, 100, 200, 400, 800, 1600].map(violation).into_iter().collect::<Result<_, _>>()?;
    let order = (points[4].1 / points[5].1).log2();
    let (paper, curve) = (
        points[1].1,
        Curve { of: Quantity::Drift, over_time: false, name: "paper's cart, 2 s".into(), points: points.clone() },
    );
    Ok(Found {
        // The paper's Fig. 4 has 3e-4 m at its largest.
        measures: vec![
            Measure::at_most("‖Φ‖ at the paper's 0.02 s", paper, 3.5e-4),
            Measure::between("order", order, (1.9, 2.1)),
        ],
        curves: vec![curve],
        stopped: None,
    })
}

/// The growth of the violations, last half over first.
fn long(name: &str, march: &March) -> Found {
    let Record { points, stopped } = march.violations();
    let growth = deviation(&points, (0.5, 1.0)) / deviation(&points, (0.0, 0.5));
    let curve = Curve { of: Quantity::Drift, over_time: true, name: name.into(), points: envelope(&points) };
    Found {
        measures: vec![
            Measure::told("‖Φ‖ in the first hundredth", deviation(&points, (0.0, 0.01))),
            Measure::told("‖Φ‖ in all", most(&points)),
            // In proportion to time it would be 2, as a random walk 1.4; the first half may miss the largest swings of a motion.
            Measure::at_most("last half over first", growth, 1.7),
        ],
        curves: vec![curve],
        stopped,
    }
}

fn long_cart(steps: usize, rebased: bool) -> Result<Found, Error> {
    let system: System = scenes::cart(Units::SI, 3).scene().compile()?;
    let name = if rebased { "paper's cart, restarted" } else { "paper's cart" };
    let control = |t: f64| 5.0 * (2.2 * t).sin();
    Ok(long(name, &March { control, rebased, ..March::new(&system, steps, 0.01) }))
}

fn long_crank(steps: usize, rebased: bool) -> Result<Found, Error> {
    let mechanism = scenes::slider_crank(Units::SI, 0.4, 0.9, 1.0)?;
    let name = if rebased { "slider-crank, restarted" } else { "slider-crank" };
    Ok(long(name, &March { rebased, ..March::new(&mechanism.system, steps, 0.01) }))
}
