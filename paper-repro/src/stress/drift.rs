//! Drift of positions from their constraints: velocities satisfy dΦ/dt = 0 exactly, positions follow by quadrature or by projection.

use std::time::Instant;

use hamiltonian_adjoint::{Error, Report, Settings, System};

use super::motion::{
    APART, GROWS, March, Record, deviation, drifted, envelope, gradient_error_of_cart, in_figures, last_over_first,
    mechanics, no_solution, projected, rebased,
};
use super::row::{Curve, Found, Measure, Quantity, Trial};
use crate::mechanisms as scenes;
use crate::statistics::largest;

const MOVING: &str = "paper's cart, kept moving";

type Build = fn() -> Result<System, Error>;
type Control = fn(f64) -> f64;

/// Permitted growth of violations, last half over first. Linear growth would yield 2, a random walk 1.4; the first half may miss the largest
/// swings of a motion. In a periodic motion that is symmetric in time the errors cancel.
const REPEATED: f64 = 1.7;
/// In a driven and damped motion they need not cancel: Φ is the sum of the errors, O(Δt³) each, of the quadrature of dΦ/dt.
const DRIVEN: f64 = 2.5;

pub fn trials(short: bool) -> Vec<Trial> {
    let (steps, many) = if short { (10_000, 100_000) } else { (100_000, 1_000_000) };
    let mut trials = vec![Trial::new("paper's cart, 2 s, as a function of Δt", over_step)];
    let moving: [(&str, Build, Control, f64); 2] = [
        (MOVING, || scenes::paper_cart(3), |t| 5.0 * (2.2 * t).sin(), DRIVEN),
        ("slider-crank without friction", || Ok(scenes::crank()?.system), |_| 0.0, REPEATED),
    ];
    for (name, build, control, most) in moving {
        let trial = |how: &str, settings: Settings, steps: usize, most: Option<f64>| {
            let name = format!("{name}{how}");
            Trial::new(format!("{name}, {steps} steps"), move || {
                let system = build()?;
                let march = March { control, settings, ..March::new(&system, steps, 0.01) };
                let mut found = most.map_or_else(|| rounding(&name, &march), |most| growth(&name, &march, most));
                found.curves.retain(|_| settings.rebase_every <= 1);
                Ok(found)
            })
        };
        trials.push(
            trial("", Settings::default(), steps, Some(DRIVEN)).or_refused(GROWS, no_solution).or_warned(APART, drifted),
        );
        trials.push(trial(", rebased at every node", rebased(1), steps, Some(most)));
        trials.push(trial(", rebased at every 100th node", rebased(100), steps, Some(most)));
        trials.push(trial(", projected at every node", projected(), many, None));
    }
    trials
        .push(Trial::new("gradient of the paper's cart, 100 steps, projected and rebased, as a function of Δt", gradients));
    trials.push(Trial::new("cost of projection at every node, paper's cart, 10000 steps", cost));
    trials
}

/// The largest violation, including that at the first node.
fn most(record: &[(f64, f64)]) -> f64 {
    largest(record.iter().map(|point| point.1))
}

fn over_step() -> Result<Found, Error> {
    let system = scenes::paper_cart(3)?;
    let violations = |settings| -> Result<Vec<(f64, f64)>, Error> {
        let at = |steps: usize| {
            let dt = 2.0 / steps as f64;
            Ok((dt, most(&March { control: |_| 10.0, settings, ..March::new(&system, steps, dt) }.violations().complete()?)))
        };
        [50, 100, 200, 400, 800, 1600].into_iter().map(at).collect()
    };
    let (plain, rebased, projected) = (violations(Settings::default())?, violations(rebased(1))?, violations(projected())?);
    let order = |points: &[(f64, f64)]| (points[4].1 / points[5].1).log2();
    Ok(Found {
        // The largest value in the paper's Fig. 4 is 3e-4 m.
        measures: vec![
            Measure::at_most("‖Φ‖ at the paper's 0.02 s", plain[1].1, 3.5e-4),
            Measure::between("order", order(&plain), (1.9, 2.1)),
            Measure::between("order, rebased at every node", order(&rebased), (1.9, 2.1)),
            Measure::at_most("projected", most(&projected), 1e-14),
        ],
        curves: [("paper's cart", plain), ("paper's cart, rebased", rebased), ("paper's cart, projected", projected)]
            .map(|(name, points)| Curve { of: Quantity::Drift, over_time: false, name: name.into(), points })
            .into(),
        ..Found::default()
    })
}

fn found(name: &str, Record { points, warnings, stopped }: Record, judged: Measure) -> Found {
    let curve = Curve { of: Quantity::Drift, over_time: true, name: in_figures(name), points: envelope(&points) };
    let told = Measure::reported("‖Φ‖ in the first hundredth of the motion", deviation(&points, (0.0, 0.01)));
    Found {
        measures: vec![told, Measure::reported("‖Φ‖ over the whole motion", most(&points)), judged],
        curves: vec![curve],
        warnings,
        stopped,
    }
}

/// Result for violations that may grow by the given factor.
fn growth(name: &str, march: &March, most: f64) -> Found {
    let record = march.violations();
    let growth = last_over_first(&record.points, 0.5);
    found(name, record, Measure::at_most("last half over first", growth, most))
}

/// Constraints satisfied at every node: a projection ends when no coordinate changes by more than 1e-15 ‖q‖ = 4.5 ε ‖q‖; an equation
/// contains three coordinates, and its evaluation has as many rounding errors.
fn rounding(name: &str, march: &March) -> Found {
    let mut place = 0.0f64;
    let record = march.record(|at| {
        place = place.max(largest(at.q));
        mechanics(march.system, at).phi().amax()
    });
    let share = most(&record.points) / (f64::EPSILON * place);
    let mut found = found(name, record, Measure::at_most("‖Φ‖ over ε ‖q‖", share, 20.0));
    found.measures.push(Measure::reported("‖q‖", place));
    found
}

fn gradients() -> Result<Found, Error> {
    let errors = |settings| -> Result<Vec<(f64, f64)>, Error> {
        let at = |dt: f64| Ok((dt, gradient_error_of_cart(dt, settings)?));
        [1e-5, 1e-4, 1e-3, 0.01, 0.02, 0.05].into_iter().map(at).collect()
    };
    let curves = [("paper's cart, projected", errors(projected())?), ("paper's cart, rebased", errors(rebased(1))?)];
    Ok(Found {
        measures: curves
            .iter()
            .map(|(name, points)| Measure::at_most(format!("gradient error, {name}"), most(points), 1e-11))
            .collect(),
        curves: curves
            .map(|(name, points)| Curve { of: Quantity::Gradient, over_time: false, name: name.into(), points })
            .into(),
        ..Found::default()
    })
}

/// Cost of projection, by counters and by time; only the number of restarts is judged.
fn cost() -> Result<Vec<Measure>, Error> {
    let system = scenes::paper_cart(3)?;
    let run = |settings| -> Result<(Report, f64), Error> {
        let march = March { control: |t| 5.0 * (2.2 * t).sin(), settings, ..March::new(&system, 10_000, 0.01) };
        let start = Instant::now();
        Ok((march.run(|_| ())?, start.elapsed().as_secs_f64()))
    };
    let ((plain, plain_time), (projected, time)) = (run(Settings::default())?, run(projected())?);
    let ratio = |of: fn(&Report) -> usize| of(&projected) as f64 / of(&plain) as f64;
    Ok(vec![
        Measure::between("restarts per step", projected.restarts as f64 / 1e4, (0.5, 1.0)),
        Measure::reported("factorisations relative to those without projection", ratio(|report| report.factorisations)),
        Measure::reported("Newton iterations, relative", ratio(|report| report.newton_iterations)),
        Measure::reported(
            "element evaluations, relative",
            ratio(|report| report.element_evaluations + report.sine_evaluations),
        ),
        Measure::reported("time", time / plain_time),
    ])
}
