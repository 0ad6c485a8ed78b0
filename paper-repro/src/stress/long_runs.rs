//! A million steps: what rebasing, projection and checkpoints are for.

use hamiltonian_adjoint::Error;

use super::assembly::Units;
use super::motion::{March, deviation};
use super::row::{Found, Measure, Trial};
use super::scenes;

const GROUP: &str = "long runs";

pub fn trials(short: bool) -> Vec<Trial> {
    let steps = if short { 20_000 } else { 1_000_000 };
    vec![
        Trial::new(GROUP, format!("chain under its weight, {steps} steps"), move || multipliers(steps))
            .open("multipliers grow with time, until a step has no solution"),
        Trial::new(GROUP, format!("the same, restarted from q and v at every step, {steps} steps"), move || {
            restarted(steps)
        })
        .open("restarts are not symmetric in time, and their errors add up"),
    ]
}

/// |σ| grows as the weight that the hinges carry, g t (1 + 0.8 + 0.6), and nothing else grows with it.
fn multipliers(steps: usize) -> Result<Found, Error> {
    let mechanism = scenes::chain(Units::SI, &[1.0, 0.8, 0.6], -1.2, 0.0)?;
    let march = March::new(&mechanism.system, steps, 0.01);
    let (mut sigma, mut rate, mut early, mut time) = (0.0f64, 0.0f64, None, 0.0);
    march.run(|motion, inputs| {
        let worst = motion.phi_dot(&mechanism.system, inputs).expect("the inputs of this piece").amax() / motion.v.amax();
        (sigma, rate, time) = (sigma.max(motion.sigma.amax()), rate.max(worst), motion.times[motion.computed - 1]);
        early.get_or_insert(worst);
    })?;
    Ok(vec![
        Measure::between("|σ| over the impulse of the weight", sigma / (9.81 * 2.4 * time), (0.9, 1.2)),
        Measure::at_most("‖dΦ/dt‖/‖v‖", rate, 1e-10),
        Measure::told("the same in the first piece", early.unwrap_or(f64::NAN)),
    ]
    .into())
}

/// What remains when multipliers do not grow.
fn restarted(steps: usize) -> Result<Found, Error> {
    let mechanism = scenes::chain(Units::SI, &[1.0, 0.8, 0.6], -1.2, 0.0)?;
    let march = March { rebased: true, ..March::new(&mechanism.system, steps, 0.01) };
    let (mut energies, mut drift) = (Vec::with_capacity(steps), 0.0f64);
    march.run(|motion, inputs| {
        let i = motion.computed - 1;
        drift = drift.max(motion.phi(&mechanism.system, inputs).expect("the inputs of this piece").amax());
        let energy = mechanism.energy(motion.q.column(i).as_slice(), motion.v.column(i).as_slice());
        energies.push((motion.times[i], energy));
    })?;
    let (first, last) = (deviation(&energies, (0.0, 0.1)), deviation(&energies, (0.9, 1.0)));
    Ok(vec![
        Measure::told("energy error [J]", first.max(last)),
        Measure::at_most("last tenth over first", last / first, 1.25),
        Measure::at_most("‖Φ‖ [m]", drift, 1e-3),
    ]
    .into())
}
