//! Extreme masses, stiffness, damping, step lengths and angles.

use std::f64::consts::{FRAC_PI_2, TAU};

use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, Start, State, gradient, simulate};

use super::hard_starts::rough_step;
use super::motion::{
    CONTROLS, COORDINATES, March, RATES, deviation, gradient_error, gradient_error_of_cart, gradient_errors, shaken,
};
use super::row::{Curve, Found, Measure, Quantity, Trial};
use crate::assembly::Units;
use crate::mechanisms::{self as scenes, Pull};
use crate::statistics::{largest, relative_difference};

/// Permitted difference of an exact gradient from complex step in ordinary cases.
const EXACT: f64 = 1e-12;

pub fn trials(short: bool) -> Vec<Trial> {
    let mut trials = Vec::new();
    for ratio in [1e-8, 1e-4, 1e4, 1e8] {
        trials.push(Trial::new(format!("chain of five, alternating masses 1 : {ratio:.0e}"), move || mass_ratio(ratio)));
    }
    trials.push(Trial::new("chain, middle link of 1e-12 kg", || light_middle(1e-12)));
    trials.push(
        Trial::new("chain, middle link without mass", || light_middle(0.0))
            .or_refused("a body must have mass", |error| matches!(error, Error::Parameter { .. })),
    );
    trials.push(
        Trial::new("a coordinate between two bodies without inertia", massless_coordinate)
            .or_refused("a coordinate must have inertia", |error| matches!(error, Error::MissingInertia { .. })),
    );
    for stiffness in [1e4, 1e7, 1e10] {
        trials.push(Trial::new(format!("body in a potential of {stiffness:.0e} N/m, Δt 0.01 s"), move || {
            stiff_oscillator(Pull::Linear(stiffness), stiffness)
        }));
        trials.push(Trial::new(format!("body on a spring of {stiffness:.0e} N/m, Δt 0.01 s"), move || {
            stiff_oscillator(Pull::Spring(stiffness), 0.0)
        }));
    }
    for (stiffness, dt) in [(1e4, 0.01), (1e7, 0.01), (1e10, 0.002)] {
        let name = format!("rod hung on a spring of {stiffness:.0e} N/m, Δt {dt} s");
        trials.push(Trial::new(name, move || stiff_pendulum(stiffness, dt)));
    }
    trials.push(Trial::new("rod hung on a spring of 1e10 N/m, Δt 0.01 s: not resolved, with a warning", too_stiff_pendulum));
    for exponent in [-8, -4, 0, 4, 8] {
        trials.push(Trial::new(format!("body with a damper, c Δt/m = 1e{exponent}"), move || damped(exponent)));
    }
    trials.push(Trial::new("cart, Δt from 1e-9 s to 0.1 s", move || step_lengths(short)));
    trials.push(Trial::new("pendulum turned by 159,155 revolutions (1e6 rad)", large_angles));
    trials
}

fn mass_ratio(ratio: f64) -> Result<Vec<Measure>, Error> {
    let of = |masses: [f64; 5]| -> Result<f64, Error> {
        let chain = scenes::chain(Units::SI, &masses, -1.0, 0.0)?;
        gradient_error(&chain.system, &shaken(&chain.system, 100, 0.01, 5.0), Settings::default(), 12)
    };
    let (light_inside, light_outside) = (of([1.0, ratio, 1.0, ratio, 1.0])?, of([ratio, 1.0, ratio, 1.0, ratio])?);
    // Velocities are eliminated before multipliers, so as many digits are lost as the ratio has.
    let bound = 100.0 * f64::EPSILON * ratio.max(1.0 / ratio);
    Ok(vec![Measure::at_most("gradient error", light_inside.max(light_outside), bound)])
}

fn light_middle(share: f64) -> Result<Vec<Measure>, Error> {
    let chain = scenes::light_middle(share)?;
    let inputs = shaken(&chain.system, 100, 0.01, 5.0);
    let error = gradient_error(&chain.system, &inputs, Settings::default(), 12)?;
    Ok(vec![Measure::at_most("gradient error", error, 100.0 * f64::EPSILON / share)])
}

fn massless_coordinate() -> Result<Vec<Measure>, Error> {
    let system = scenes::coordinate_without_inertia()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.01));
    let error = gradient_error(&system, &inputs, Settings::default(), 12)?;
    Ok(vec![Measure::at_most("gradient error", error, EXACT)])
}

/// The rule conserves the energy of a linear oscillator exactly for any step length.
fn stiff_oscillator(pull: Pull, potential: f64) -> Result<Vec<Measure>, Error> {
    let mechanism = scenes::oscillator(pull, 0.0)?;
    let energy = |at: &State| mechanism.energy(at.q, at.v) + 0.5 * potential * (at.q[0] - 1.0) * (at.q[0] - 1.0);
    let record = March::new(&mechanism.system, 1000, 0.01).record(energy).complete()?;
    let energy = deviation(&record, (0.0, 1.0)) / record[0].1;
    let error = gradient_error(&mechanism.system, &shaken(&mechanism.system, 200, 0.01, 5.0), Settings::default(), 12)?;
    Ok(vec![Measure::at_most("energy error", energy, 1e-8), Measure::at_most("gradient error", error, 1e-9)])
}

/// The spring starts unstretched, so that only the weight excites its oscillation.
fn stiff_pendulum(stiffness: f64, dt: f64) -> Result<Vec<Measure>, Error> {
    let mechanism = scenes::spring_pendulum(stiffness)?;
    let steps = (10.0 / dt) as usize;
    let record = March::new(&mechanism.system, steps, dt).record(|at| mechanism.energy(at.q, at.v)).complete()?;
    // Work of the weight over 1 m.
    let energy = deviation(&record, (0.0, 1.0)) / 9.81;
    let error = gradient_error(&mechanism.system, &shaken(&mechanism.system, 100, dt, 1.0), Settings::default(), 12)?;
    // The spring's length of 1 m is rounded by an ulp in each of 100 steps; the reference is its stretch under the weight.
    let rounding = f64::EPSILON * stiffness / 9.81;
    Ok(vec![Measure::at_most("energy error", energy, 0.1), Measure::at_most("gradient error", error, 100.0 * rounding)])
}

/// Beyond Δt ω = 2 the spring's force changes its sign at each node, and its oscillation appears as a beat of frequency 4/(Δt² ω). Here
/// this is 0.4 rad/s, slower than the rod, which rotates the spring and thus excites the oscillation; at Δt = 0.002 s it is 10 rad/s and
/// the oscillation is not excited. The energy must be conserved until the report warns of rough steps, and it must warn.
fn too_stiff_pendulum() -> Result<Vec<Measure>, Error> {
    let mechanism = scenes::spring_pendulum(1e10)?;
    let mut record = Vec::new();
    let report = March::new(&mechanism.system, 1000, 0.01).run(|at| record.push((at.time, mechanism.energy(at.q, at.v))))?;
    let first = rough_step(&report);
    let told = if first.is_finite() { first as usize } else { record.len() };
    Ok(vec![
        Measure::at_most("energy error until the warning", deviation(&record[..told], (0.0, 1.0)) / 9.81, 0.1),
        Measure::between("first step reported as rough", first, (1.0, 1000.0)),
        Measure::reported("energy error at the end", deviation(&record, (0.0, 1.0)) / 9.81),
    ])
}

/// v_i = v_0 ((1 − x/2)/(1 + x/2))^i with x = c Δt/m.
fn damped(exponent: i32) -> Result<Vec<Measure>, Error> {
    let (dt, steps) = (0.01, 20);
    let x = 10f64.powi(exponent);
    let mechanism = scenes::oscillator(Pull::None, x / dt)?;
    let mut inputs = Inputs::at_rest(&mechanism.system, Grid::uniform(steps, dt));
    if let Start::Velocity { v, .. } = &mut inputs.start {
        v[0] = 1.0;
    }
    let motion = simulate(&mechanism.system, &inputs, Settings::default())?;
    let factor = (1.0 - 0.5 * x) / (1.0 + 0.5 * x);
    let worst = largest((0..=steps).map(|i| motion.v[(0, i)] - factor.powi(i as i32)));
    inputs.controls.fill(1.0);
    let kinds = [CONTROLS, COORDINATES, RATES];
    let [controls, start, rate] = gradient_errors(&mechanism.system, &inputs, Settings::default(), 30, kinds)?;
    Ok(vec![
        Measure::at_most("velocity error", worst, 1e-12),
        Measure::at_most("error of dJ/du, dJ/dq₀", largest([controls, start]), EXACT),
        // The derivative is nearly zero as the difference of numbers that are not.
        Measure::reported("error of dJ/dv₀", rate),
    ])
}

fn step_lengths(short: bool) -> Result<Found, Error> {
    let stride = if short { 2 } else { 1 };
    let exponents = (0..=16).step_by(stride).map(|k| -9.0 + 0.5 * f64::from(k));
    let at = |dt: f64| Ok((dt, gradient_error_of_cart(dt, Settings::default())?));
    let points: Vec<(f64, f64)> = exponents.map(|exponent| at(10f64.powf(exponent))).collect::<Result<_, Error>>()?;
    let worst = largest(points.iter().map(|point| point.1));
    let curve = Curve { of: Quantity::Gradient, over_time: false, name: "paper's cart, 100 steps or 2 s".into(), points };
    Ok(Found { measures: vec![Measure::at_most("gradient error", worst, EXACT)], curves: vec![curve], ..Found::default() })
}

/// Both motions are equal except for the rounding of angles: the ulp at 1e6 rad is 1e-10 rad.
fn large_angles() -> Result<Vec<Measure>, Error> {
    let revolutions = 159_155.0 * TAU;
    let run = |turned: f64| {
        let mechanism = scenes::cart(Units::SI, 3);
        let mut parts = mechanism.mechanism();
        for link in &parts.links {
            parts.scene.place(link.coordinates[2], -FRAC_PI_2 + turned);
        }
        let last = parts.links[2].coordinates[2];
        let cost = hamiltonian_adjoint::scenes::AngleError;
        let target = [(FRAC_PI_2 + turned).into()];
        parts.scene.cost("angle", cost, hamiltonian_adjoint::Sum::Terminal, [last], [], [], target);
        let system = parts.scene.compile()?;
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
        inputs.controls.fill(10.0);
        gradient(&system, &inputs, Settings::default())
    };
    let (near, far) = (run(0.0)?, run(revolutions)?);
    Ok(vec![
        Measure::at_most("change of J", ((far.value - near.value) / near.value).abs(), 1e-8),
        Measure::at_most("change of dJ/du", relative_difference(far.controls.as_slice(), near.controls.as_slice()), 1e-8),
        Measure::at_most("change of dJ/dΔt", relative_difference(&far.steps, &near.steps), 1e-8),
    ])
}
