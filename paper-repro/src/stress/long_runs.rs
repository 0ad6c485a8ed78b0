//! A million steps: effects of rebasing, projection and checkpoints.

use std::time::Instant;

use hamiltonian_adjoint::{Error, LongSolver, Settings, Solver, System};

use super::motion::{BOUNDED, GROWS, IN_PROPORTION, March, WANDERS, deviation, mechanics, no_solution, projected, rebased};
use super::row::{Found, Measure, Trial};
use crate::mechanisms as scenes;
use crate::statistics::{largest, relative_difference};

/// Number of steps between resets of σ of the cart.
const EVERY: usize = 100;
/// Permitted memory for a gradient of a million steps.
const BYTES: usize = 96_000_000;
/// Permitted peak memory of the whole process, in MB.
const MOST: f64 = 256.0;

pub fn trials(short: bool) -> Vec<Trial> {
    let steps = if short { 20_000 } else { 1_000_000 };
    let energy = |how: &str, settings: Settings, most: f64| {
        Trial::new(format!("energy of a chain, {how}, {steps} steps"), move || energy(steps, settings, most))
    };
    vec![
        Trial::new(format!("paper's cart, hanging, rebased at every {EVERY}th node, {steps} steps"), move || cart(steps)),
        Trial::new(format!("gradient of the paper's cart within 96 MB, {steps} steps"), move || gradient(steps)),
        Trial::new(
            "gradient of the paper's cart within 2 MB, compared with that of the stored motion, 20000 steps",
            against_stored,
        ),
        Trial::new(format!("chain under its weight, {steps} steps"), move || multipliers(steps))
            .or_refused(GROWS, no_solution),
        energy("rebased at every node", rebased(1), BOUNDED),
        energy("rebased at every 100th node", rebased(EVERY), WANDERS),
        energy("projected at every node", projected(), IN_PROPORTION),
    ]
}

fn hanging(system: &System, steps: usize) -> March<'_> {
    March { control: |t| 0.2 * (1.3 * t).sin(), settings: rebased(EVERY), ..March::new(system, steps, 0.005) }
}

/// Momenta contain only the impulse of the weight since the last restart, so velocities are as accurate after a million steps as at the
/// start. The right-hand side of M v = p* − Φ_qᵀσ is rounded to ε |σ| for any v, so dΦ/dt vanishes up to some ε |σ| (1/m + l²/(4 J)), the
/// effect of an impulse on the end of a link: an equation involves two links with two impulses each.
fn cart(steps: usize) -> Result<Vec<Measure>, Error> {
    let system = scenes::paper_cart(3)?;
    let march = hanging(&system, steps);
    let (mut sigma, mut p_star, mut speed, mut swing) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let mut rates = [0.0f64; 10];
    march.run(|at| {
        (sigma, p_star, speed) = (sigma.max(largest(at.sigma)), p_star.max(largest(at.p_star)), speed.max(largest(at.v)));
        // Links are at −π/2 rad.
        swing = swing.max(largest(at.q[3..].chunks(3).map(|link| link[2] + std::f64::consts::FRAC_PI_2)));
        let tenth = &mut rates[(10 * at.node / (steps + 1)).min(9)];
        *tenth = tenth.max(mechanics(&system, at).phi_dot().amax());
    })?;
    let rounding = f64::EPSILON * sigma * (1.0 / 0.4 + 0.25 / 0.083);
    let weight = 9.81 * (0.8 + 3.0 * 0.4) * EVERY as f64 * march.dt;
    Ok(vec![
        Measure::at_most("|σ| over the weight's impulse between restarts", sigma / weight, 1.1),
        Measure::at_most("|p*| over the weight's impulse between restarts", p_star / weight, 1.1),
        Measure::at_most("‖dΦ/dt‖ over ε |σ| (1/m + l²/(4 J))", largest(rates) / rounding, 4.0),
        Measure::reported("‖dΦ/dt‖/‖v‖", largest(rates) / speed),
        Measure::at_most("‖dΦ/dt‖, last tenth over first", rates[9] / rates[0], 1.5),
        Measure::between("largest swing [rad]", swing, (1e-3, 0.5)),
    ])
}

fn gradient(steps: usize) -> Result<Found, Error> {
    let system = scenes::paper_cart(3)?;
    let march = hanging(&system, steps);
    let inputs = march.inputs();
    let mut solver = LongSolver::new(&system, march.settings, BYTES);
    let start = Instant::now();
    solver.simulate(&inputs, |_| ())?;
    let (once, time) = (solver.report().factorisations, start.elapsed().as_secs_f64());
    let start = Instant::now();
    let gradient = solver.gradient(&inputs)?;
    let (size, of_gradient) = (gradient.controls.amax(), start.elapsed().as_secs_f64());
    let work = solver.report().factorisations as f64 / once as f64;
    let mut measures = vec![
        Measure::between("work of the forward sweep, in simulations", work, (1.0, 3.0)),
        Measure::between("|dJ/du|", size, (1e-6, 1e3)),
        Measure::reported("time, in simulations", of_gradient / time),
    ];
    measures.extend(peak().map(|megabytes| Measure::at_most("peak memory of the process [MB]", megabytes, MOST)));
    Ok(measures.into())
}

/// Peak resident memory of this process in MB, if the system reports it.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}

fn against_stored() -> Result<Vec<Measure>, Error> {
    let system = scenes::paper_cart(3)?;
    let march = hanging(&system, 20_000);
    let inputs = march.inputs();
    let mut stored = Solver::new(&system, march.settings);
    stored.simulate(&inputs)?;
    let once = stored.report().factorisations;
    let gradient = stored.gradient()?;
    let mut solver = LongSolver::new(&system, march.settings, 2_000_000);
    let long = solver.gradient(&inputs)?;
    let difference = [
        relative_difference(long.controls.as_slice(), gradient.controls.as_slice()),
        relative_difference(&long.steps, &gradient.steps),
    ];
    let work = solver.report().factorisations as f64 / once as f64;
    Ok(vec![
        Measure::at_most("dJ/du", difference[0], 1e-13),
        Measure::at_most("dJ/dΔt", difference[1], 1e-13),
        Measure::between("work of the forward sweep, in simulations", work, (1.5, 3.0)),
    ])
}

/// |σ| grows like the impulse of the weight on the hinges, g t (1 + 0.8 + 0.6); nothing else may grow.
fn multipliers(steps: usize) -> Result<Vec<Measure>, Error> {
    let mechanism = scenes::swinging_chain()?;
    let march = March::new(&mechanism.system, steps, 0.01);
    let (mut sigma, mut rate, mut early, mut speed) = (0.0f64, 0.0f64, 0.0, 0.0f64);
    march.run(|at| {
        (sigma, speed) = (sigma.max(largest(at.sigma)), speed.max(largest(at.v)));
        rate = rate.max(mechanics(&mechanism.system, at).phi_dot().amax());
        early = if at.node <= 2000 { rate } else { early };
    })?;
    Ok(vec![
        Measure::between("|σ| over the impulse of the weight", sigma / (9.81 * 2.4 * 0.01 * steps as f64), (0.9, 1.2)),
        Measure::at_most("‖dΦ/dt‖/‖v‖", rate / speed, 1e-10),
        Measure::reported("‖dΦ/dt‖/‖v‖ in the first 2000 steps", early / speed),
    ])
}

/// Energy error if multipliers do not grow; its permitted growth follows from the symmetry of the restarts.
fn energy(steps: usize, settings: Settings, most: f64) -> Result<Vec<Measure>, Error> {
    let mechanism = scenes::swinging_chain()?;
    let march = March { settings, ..March::new(&mechanism.system, steps, 0.01) };
    let mut drift = 0.0f64;
    let energies = march.record(|at| {
        drift = drift.max(mechanics(&mechanism.system, at).phi().amax());
        mechanism.energy(at.q, at.v)
    });
    let energies = energies.complete()?;
    let (first, last) = (deviation(&energies, (0.0, 0.1)), deviation(&energies, (0.9, 1.0)));
    Ok(vec![
        Measure::reported("energy error [J]", first.max(last)),
        Measure::at_most("last tenth over first", last / first, most),
        Measure::at_most("‖Φ‖ [m]", drift, if settings.drift_bound == 0.0 { 1e-12 } else { 1e-3 }),
    ])
}
