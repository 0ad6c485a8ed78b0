//! Conserved quantities: energy, momenta, and the balance of power.

use hamiltonian_adjoint::{Error, Settings, Start, System};
use nalgebra::DVector;

use super::motion::{
    APART, BOUNDED, GROWS, IN_PROPORTION, March, Record, WANDERS, deviation, drifted, envelope, in_figures, last_over_first,
    no_solution, projected, rebased, refined,
};
use super::row::{Curve, Found, Measure, Quantity, Trial};
use crate::assembly::{Mechanism, Units};
use crate::by_hand::DoublePendulum;
use crate::mechanisms as scenes;

/// Accepted range of the order two, estimated from two step lengths.
const SECOND: (f64, f64) = (1.9, 2.1);

pub fn trials(short: bool) -> Vec<Trial> {
    let steps = if short { 10_000 } else { 100_000 };
    let trial = |what: String, run: Box<dyn Fn(usize) -> Result<Found, Error>>| {
        Trial::new(format!("{what}, {steps} steps"), move || run(steps))
    };
    let mut trials = vec![trial("energy of a double pendulum in its angles, M(q)".into(), Box::new(minimal))];
    for (what, build) in SWINGING {
        for (how, settings, dt) in ways() {
            let run = move |steps| {
                let mechanism = build()?;
                let run = |refine| {
                    let settings = refined(settings, refine);
                    energies(&mechanism, steps * refine, dt / refine as f64, settings)
                };
                let mut found = energy(&named(what, how), theory(settings), run)?;
                found.curves.retain(|_| settings.rebase_every <= 1);
                Ok(found)
            };
            let trial = trial(format!("energy of a {}, {} ms", named(what, how), 1e3 * dt), Box::new(run));
            let grows = settings == Settings::default();
            trials.push(if grows { trial.or_refused(GROWS, no_solution).or_warned(APART, drifted) } else { trial });
        }
    }
    for (how, settings, _) in ways() {
        let what = named("momenta of free hinged pairs on springs", how);
        trials.push(trial(what, Box::new(move |steps| Ok(momenta(steps, settings)?.into()))));
    }
    trials.push(Trial::new("balance of the energy of a chain with the work of motor and friction", power));
    trials.push(Trial::new("energy of three scenes as a function of Δt", energy_over_step));
    trials
}

type Build = fn() -> Result<Mechanism, Error>;

const SWINGING: [(&str, Build); 2] = [("chain of three", scenes::swinging_chain), ("slider-crank", scenes::crank)];

/// Treatment at nodes, its settings, and the step length at which energies are judged. A slider-crank that is rebased once per second is
/// judged at 5 ms: at 10 ms ¼ Δt² σ Φ_qqq v is a tenth of M, the mean of σ and the motion disturb each other chaotically, and
/// starts that are 1e-13 rad apart end with energy errors between 0.01 and 0.05.
fn ways() -> [(&'static str, Settings, f64); 5] {
    [
        ("", Settings::default(), 0.01),
        ("rebased at every node", rebased(1), 0.01),
        ("rebased at every 10th node", rebased(10), 0.01),
        ("rebased at every 100th node", rebased(100), 0.005),
        ("projected at every node", projected(), 0.01),
    ]
}

/// Name of the treatment in a row.
fn named(what: &str, how: &str) -> String {
    if how.is_empty() { what.into() } else { format!("{what}, {how}") }
}

/// Permitted growth of the energy error from the first tenth to the last, and its order. The error of a symmetric rule is bounded. If σ is
/// reset from time to time, its mean may drift, and with it the error terms Δt² σ, (Δt² σ)², …. A projection that takes place entirely
/// after a step, not half before and half after, is not symmetric to O(Δt⁴) and adds an error Δt³ t. Without either, σ and the error grow
/// in proportion to time.
fn theory(settings: Settings) -> (f64, Measured) {
    match settings.rebase_every {
        1 => (BOUNDED, |order| Measure::between("order", order, SECOND)),
        0 if settings.drift_bound == 0.0 => (IN_PROPORTION, |order| Measure::between("order", order, (SECOND.0, 3.2))),
        2.. => (WANDERS, |order| Measure::at_least("order", order, SECOND.0)),
        0 => (IN_PROPORTION, |order| Measure::at_least("order", order, SECOND.0)),
    }
}

type Measured = fn(f64) -> Measure;

/// Measures of the energies at a step length and at half of it, relative to the work of 1 kg that falls by 1 m.
fn energy(name: &str, (growth, order): (f64, Measured), run: impl Fn(usize) -> Record) -> Result<Found, Error> {
    let (coarse, fine) = (run(1), run(2));
    let most = |record: &Record| deviation(&record.points, (0.0, 1.0));
    let points = envelope(&coarse.points).into_iter().map(|(t, error)| (t, error / 9.81)).collect();
    Ok(Found {
        measures: vec![
            Measure::reported("error", most(&coarse) / 9.81),
            Measure::at_most("last tenth over first", last_over_first(&coarse.points, 0.1), growth),
            order((most(&coarse) / most(&fine)).log2()),
        ],
        curves: vec![Curve { of: Quantity::Energy, over_time: true, name: in_figures(name), points }],
        warnings: [coarse.warnings, fine.warnings].concat(),
        stopped: coarse.stopped.or(fine.stopped),
    })
}

fn energies(mechanism: &Mechanism, steps: usize, dt: f64, settings: Settings) -> Record {
    March { settings, ..March::new(&mechanism.system, steps, dt) }.record(|at| mechanism.energy(at.q, at.v))
}

fn minimal_energies(system: &System, steps: usize, dt: f64) -> Record {
    March::new(system, steps, dt).record(|at| DoublePendulum::energy(at.q, at.v))
}

fn minimal(steps: usize) -> Result<Found, Error> {
    let system = scenes::minimal()?;
    energy("double pendulum, M(q)", theory(rebased(1)), |refine| {
        minimal_energies(&system, steps * refine, 0.01 / refine as f64)
    })
}

/// Linear momentum is linear in the state and conserved to rounding. Angular momentum is quadratic; the trapezoidal rule, unlike the
/// midpoint rule, conserves it to O(Δt²) only. Its order is judged over 1 s, because the pairs on springs do not move periodically.
fn momenta(steps: usize, settings: Settings) -> Result<Vec<Measure>, Error> {
    let mechanism = scenes::free_pairs()?;
    let n = mechanism.system.n();
    let p_star = DVector::from_fn(n, |i, _| 0.4 * (12.9 * (i + 1) as f64).sin());
    let start = Start::Momentum { q: mechanism.system.initial_coordinates(), p_star };
    let record = |settings: Settings, steps: usize, dt: f64| -> Result<[Vec<(f64, f64)>; 3], Error> {
        let mut parts: [Vec<(f64, f64)>; 3] = Default::default();
        let march = March { start: start.clone(), settings, ..March::new(&mechanism.system, steps, dt) };
        march.run(|at| {
            let momenta = mechanism.momenta(at.q, at.v);
            parts.iter_mut().zip(momenta).for_each(|(part, p)| part.push((at.time, p)));
        })?;
        Ok(parts)
    };
    let (all, coarse, fine) =
        (record(settings, steps, 0.01)?, record(settings, 1000, 0.001)?, record(refined(settings, 2), 2000, 0.0005)?);
    let most = |part: &[(f64, f64)]| deviation(part, (0.0, 1.0));
    let order = (most(&coarse[2]) / most(&fine[2])).log2();
    Ok(vec![
        Measure::at_most("linear momentum [N s]", most(&all[0]).max(most(&all[1])), 1e-16 * steps as f64),
        Measure::between(
            "order of the angular momentum over 1 s (a quadratic invariant, conserved to O(Δt²) only)",
            order,
            SECOND,
        ),
        Measure::reported("angular momentum over 1 s at 1 ms [N m s]", most(&coarse[2])),
        Measure::reported("angular momentum over all steps at 10 ms", most(&all[2])),
    ])
}

/// E − E_0 = ∫ (u φ̇ − c φ̇²) dt; the integral is computed by the trapezoidal rule.
fn power() -> Result<Vec<Measure>, Error> {
    const FRICTION: f64 = 0.3;
    let torque = |t: f64| 4.0 * (3.0 * t).sin();
    let mechanism = scenes::chain(Units::SI, &[1.0, 0.8, 0.6], -1.2, FRICTION)?;
    let imbalance = |steps: usize| -> Result<f64, Error> {
        let dt = 5.0 / steps as f64;
        let march = March { control: torque, ..March::new(&mechanism.system, steps, dt) };
        let (mut work, mut before, mut start, mut worst) = (0.0, None, None, 0.0f64);
        let phi = mechanism.angle(0);
        march.run(|at| {
            let power = torque(at.time) * at.v[phi] - FRICTION * at.v[phi] * at.v[phi];
            let energy = mechanism.energy(at.q, at.v);
            work += before.map_or(0.0, |before: f64| 0.5 * dt * (before + power));
            before = Some(power);
            worst = worst.max((energy - *start.get_or_insert(energy) - work).abs());
        })?;
        Ok(worst)
    };
    let (coarse, fine) = (imbalance(1000)?, imbalance(2000)?);
    Ok(vec![Measure::reported("imbalance at 5 ms [J]", coarse), Measure::between("order", (coarse / fine).log2(), SECOND)])
}

fn energy_over_step() -> Result<Found, Error> {
    let (chain, crank, angles) = (scenes::swinging_chain()?, scenes::crank()?, scenes::minimal()?);
    let lengths = [0.04, 0.02, 0.01, 0.005, 0.0025];
    let over = |run: &dyn Fn(usize, f64) -> Record| -> Result<Vec<(f64, f64)>, Error> {
        let error = |dt: f64| Ok((dt, deviation(&run((20.0 / dt) as usize, dt).complete()?, (0.0, 1.0)) / 9.81));
        lengths.into_iter().map(error).collect()
    };
    let of = |mechanism: &Mechanism, settings: Settings| over(&|steps, dt| energies(mechanism, steps, dt, settings));
    let curves = [
        ("chain of three, rebased", of(&chain, rebased(1))?),
        ("chain of three, projected", of(&chain, projected())?),
        ("slider-crank, rebased", of(&crank, rebased(1))?),
        ("slider-crank, projected", of(&crank, projected())?),
        ("double pendulum, M(q)", over(&|steps, dt| minimal_energies(&angles, steps, dt))?),
    ];
    let order = |points: &[(f64, f64)]| (points[3].1 / points[4].1).log2();
    let measures = curves.iter().map(|(name, points)| Measure::between(format!("order, {name}"), order(points), SECOND));
    let measures = measures.collect();
    let curve = |(name, points): (&str, _)| Curve { of: Quantity::Energy, over_time: false, name: name.into(), points };
    Ok(Found { measures, curves: curves.map(curve).into(), ..Found::default() })
}
