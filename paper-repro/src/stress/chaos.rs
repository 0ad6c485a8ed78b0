//! A chaotic triple pendulum: the meaning of its gradient, and the number of correct digits.

use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, Solver, System, gradient, simulate};

use super::motion::{
    APART, GROWS, March, Record, amplification, deviation, drifted, envelope, gradient_error, last_over_first, no_solution,
    projected, rebased,
};
use super::row::{Curve, Found, Measure, Quantity, Trial};
use crate::assembly::{Mechanism, Units};
use crate::mechanisms as scenes;
use crate::statistics::{largest, relative_difference};

const DT: f64 = 0.01;
/// Rounding error accumulated over some hundred steps; a motion amplifies it like any change of the state.
const ROUNDING: f64 = 1e-13;

pub fn trials(short: bool) -> Vec<Trial> {
    let steps = if short { 10_000 } else { 100_000 };
    let gradients = |name: &'static str, settings| {
        Trial::new(format!("{name}, gradient over the horizon to 10 s"), move || horizons(name, settings))
    };
    let energies = |name: &'static str, settings| {
        Trial::new(format!("{name}, energy over {steps} steps of 5 ms"), move || energy(name, steps, settings))
    };
    vec![
        Trial::new("triple pendulum, 500 steps, against 40 digits", against_forty_digits),
        gradients("triple pendulum", Settings::default()),
        gradients("triple pendulum, rebased", rebased(1)),
        gradients("triple pendulum, projected", projected()),
        energies("triple pendulum", Settings::default()).or_refused(GROWS, no_solution).or_warned(APART, drifted),
        energies("triple pendulum, rebased", rebased(1)),
        energies("triple pendulum, projected", projected()),
        Trial::new(format!("triple pendulum, gradient over {steps} steps"), move || gradient_at_the_end(steps))
            .or_refused(GROWS, no_solution),
    ]
}

/// Released from rest, stretched out along the x axis.
fn pendulum() -> Result<Mechanism, Error> {
    scenes::chain(Units::SI, &[1.0; 3], 0.0, 0.0)
}

fn released(system: &System, steps: usize) -> Inputs {
    Inputs::at_rest(system, Grid::uniform(steps, DT))
}

/// The reference was computed by `paper-repro/references/triple_pendulum.py`.
fn against_forty_digits() -> Result<Vec<Measure>, Error> {
    let file: serde_json::Value =
        serde_json::from_str(include_str!("../../references/triple_pendulum.json")).expect("a reference file");
    let list = |key: &str| -> Vec<f64> {
        file[key].as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
    };
    let mechanism = pendulum()?;
    let mut solver = Solver::new(&mechanism.system, Settings::default());
    let inputs = released(&mechanism.system, 500);
    let motion = solver.simulate(&inputs)?;
    let angles: Vec<f64> = (0..3).map(|k| motion.q[(mechanism.angle(k), 500)]).collect();
    // Momenta contain σ, which grows under the weight, and have its rounding errors.
    let largest_multiplier = motion.sigma.amax();
    let gradient = solver.gradient()?;
    let nodes = list("nodes").into_iter().map(|i| gradient.controls[(0, i as usize)]).collect::<Vec<f64>>();
    let steps = list("steps").into_iter().map(|i| gradient.steps[i as usize - 1]).collect::<Vec<f64>>();
    let amplified = amplification(&mechanism.system, &inputs)?;
    let bound = ROUNDING * largest_multiplier * amplified;
    Ok(vec![
        Measure::at_most("angles", relative_difference(&angles, &list("angles")), bound),
        Measure::at_most("dJ/du", relative_difference(&nodes, &list("gradient")), bound),
        Measure::at_most("dJ/dΔt", relative_difference(&steps, &list("step_gradient")), bound),
        Measure::reported("|δq|/|δv₀|", amplified),
        Measure::reported("|σ| [N s]", largest_multiplier),
    ])
}

/// The adjoint is the derivative of the computed motion, regardless of its size. Rounding changes this motion by ε A with the amplification
/// A, and a derivative of size A then changes by ε A²: it loses twice as many digits as the motion.
fn horizons(name: &str, settings: Settings) -> Result<Found, Error> {
    let mechanism = pendulum()?;
    let (mut points, mut shares, mut sizes) = (Vec::new(), Vec::new(), Vec::new());
    for steps in [100, 200, 500, 700, 1000] {
        let inputs = released(&mechanism.system, steps);
        let error = gradient_error(&mechanism.system, &inputs, settings, 4)?;
        points.push((steps as f64 * DT, error));
        let motion = simulate(&mechanism.system, &inputs, settings)?;
        let rounded = motion.sigma.amax().max(motion.p_star.amax());
        let amplified = amplification(&mechanism.system, &inputs)?;
        shares.push(error / (10.0 * ROUNDING * rounded * amplified * amplified).min(1e-2));
        sizes.push(gradient(&mechanism.system, &inputs, settings)?.controls.amax());
    }
    let curve = Curve { of: Quantity::Gradient, over_time: true, name: name.into(), points: points.clone() };
    Ok(Found {
        measures: vec![
            Measure::at_most("gradient error over 1e-12 |σ, p*| (|δq|/|δv₀|)²", largest(&shares), 1.0),
            Measure::reported("gradient error after 5 s", points[2].1),
            Measure::reported("gradient error after 10 s", points[4].1),
            Measure::reported("|dJ/du| after 5 s", sizes[2]),
            Measure::reported("|dJ/du| after 10 s", sizes[4]),
        ],
        curves: vec![curve],
        ..Found::default()
    })
}

/// The energy error is bounded or, if σ grows without bound, grows like the error Δt² σ of a step.
fn energy(name: &str, steps: usize, settings: Settings) -> Result<Found, Error> {
    let mechanism = pendulum()?;
    let mut multipliers = Vec::with_capacity(steps + 1);
    let Record { points, warnings, stopped } =
        March { settings, ..March::new(&mechanism.system, steps, 0.005) }.record(|at| {
            multipliers.push(largest(at.sigma));
            mechanism.energy(at.q, at.v)
        });
    // Work of the weight when three rods fall from horizontal to vertical.
    let unit = 9.81 * 4.5;
    let shown = envelope(&points).into_iter().map(|(t, error)| (t, error / unit)).collect();
    let curve = Curve { of: Quantity::Energy, over_time: true, name: name.into(), points: shown };
    let error = deviation(&points, (0.0, 1.0)) / unit;
    let measures = if settings == Settings::default() {
        let start = points.first().map_or(0.0, |first| first.1);
        let beside =
            |(&(t, energy), sigma): (&(f64, f64), &f64)| (t, if energy == start { 0.0 } else { (energy - start) / sigma });
        let per_multiplier: Vec<_> = points.iter().zip(&multipliers).map(beside).collect();
        vec![
            Measure::reported("energy error", error),
            Measure::at_most("energy error over |σ|, last half over first", last_over_first(&per_multiplier, 0.5), 1.5),
        ]
    } else {
        vec![
            Measure::at_most("energy error", error, 0.05),
            Measure::at_most("last half over first", last_over_first(&points, 0.5), 3.0),
        ]
    };
    Ok(Found { measures, curves: vec![curve], warnings, stopped })
}

fn gradient_at_the_end(steps: usize) -> Result<Vec<Measure>, Error> {
    let mechanism = pendulum()?;
    let inputs = released(&mechanism.system, steps);
    let size = gradient(&mechanism.system, &inputs, Settings::default())?.controls.amax();
    let error = gradient_error(&mechanism.system, &inputs, Settings::default(), 2)?;
    Ok(vec![Measure::at_most("gradient error", error, 1e-6), Measure::reported("log10 |dJ/du|", size.log10())])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_that_fails_is_told() {
        // No iterate satisfies this tolerance.
        let found = energy("", 10, Settings { velocity_tolerance: -1.0, ..Settings::default() }).expect("a scene");
        assert!(found.stopped.is_some());
    }
}
