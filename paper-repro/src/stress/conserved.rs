//! What a motion keeps: energy, momenta, and the balance of power.

use hamiltonian_adjoint::{Error, KineticEnergy, PotentialEnergy, Start, System};
use nalgebra::{DVector, SVector};

use super::assembly::{Mechanism, Units};
use super::motion::{March, Record, deviation, envelope};
use super::row::{Curve, Found, Measure, Quantity, Trial};
use super::scenes::{self, DoublePendulum};

const GROUP: &str = "conserved";
/// The order of the rule, as far as two step lengths show it.
const SECOND: (f64, f64) = (1.9, 2.1);
/// A bounded error is in the last tenth of a motion what it was in the first.
const BOUNDED: f64 = 1.25;

pub fn trials(short: bool) -> Vec<Trial> {
    let steps = if short { 10_000 } else { 100_000 };
    let trial = |what: &str, run: fn(usize) -> Result<Found, Error>| {
        Trial::new(GROUP, format!("{what}, {steps} steps"), move || run(steps))
    };
    let grows = |trial: Trial| trial.open("multipliers grow with time, and with them the error");
    let drifts = |trial: Trial| trial.open("restarts are not symmetric in time, and their errors add up");
    vec![
        trial("energy of a double pendulum in its angles, M(q)", minimal),
        grows(trial("energy of a chain of three", |steps| chain(steps, false))),
        trial("energy of a chain of three, restarted from q and v at every step", |steps| chain(steps, true)),
        grows(trial("energy of a slider-crank", |steps| slider_crank(steps, false))),
        drifts(trial("energy of a slider-crank, restarted from q and v at every step", |steps| slider_crank(steps, true))),
        grows(trial("momenta of free hinged pairs on springs", |steps| momenta(steps, false))),
        drifts(trial("momenta of free hinged pairs on springs, restarted from q and v at every step", |steps| {
            momenta(steps, true)
        })),
        Trial::new(GROUP, "work of motor and friction against the energy of a chain", power),
        Trial::new(GROUP, "energy of three scenes over Δt", energy_over_step),
    ]
}

/// What is judged of the energies at a step length and at half of it, relative to `unit`.
fn energy(name: &str, unit: f64, run: impl Fn(usize) -> Record) -> Result<Found, Error> {
    let (coarse, fine) = (run(1), run(2));
    let most = |record: &Record| deviation(&record.points, (0.0, 1.0));
    let (first, last) = (deviation(&coarse.points, (0.0, 0.1)), deviation(&coarse.points, (0.9, 1.0)));
    let points = envelope(&coarse.points).into_iter().map(|(t, error)| (t, error / unit)).collect();
    Ok(Found {
        measures: vec![
            Measure::told("error", most(&coarse) / unit),
            Measure::at_most("last tenth over first", last / first, BOUNDED),
            Measure::between("order", (most(&coarse) / most(&fine)).log2(), SECOND),
        ],
        curves: vec![Curve { of: Quantity::Energy, over_time: true, name: name.into(), points }],
        stopped: coarse.stopped.or(fine.stopped),
    })
}

/// A small swing, which is quasi-periodic.
fn swinging_chain() -> Result<Mechanism, Error> {
    scenes::chain(Units::SI, &[1.0, 0.8, 0.6], -1.2, 0.0)
}

fn crank() -> Result<Mechanism, Error> {
    scenes::slider_crank(Units::SI, 0.4, 0.9, 1.0)
}

/// The energies of a motion with multipliers rebased or not.
fn energies(mechanism: &Mechanism, steps: usize, dt: f64, rebased: bool) -> Record {
    March { rebased, ..March::new(&mechanism.system, steps, dt) }.record(|q, v| mechanism.energy(q, v))
}

fn chain(steps: usize, rebased: bool) -> Result<Found, Error> {
    let (mechanism, name) = (swinging_chain()?, if rebased { "chain, restarted" } else { "chain" });
    energy(name, 9.81, |refine| energies(&mechanism, steps * refine, 0.01 / refine as f64, rebased))
}

fn slider_crank(steps: usize, rebased: bool) -> Result<Found, Error> {
    let (mechanism, name) = (crank()?, if rebased { "slider-crank, restarted" } else { "slider-crank" });
    energy(name, 9.81, |refine| energies(&mechanism, steps * refine, 0.01 / refine as f64, rebased))
}

fn minimal_energies(system: &System, steps: usize, dt: f64) -> Record {
    March::new(system, steps, dt).record(|q, v| {
        let ([q, v], b) = ([q, v].map(SVector::<f64, 2>::from_column_slice), SVector::from([]));
        DoublePendulum.kinetic_energy(&q, &v, &b) + DoublePendulum.potential_energy(&q, &b, 0.0)
    })
}

fn minimal(steps: usize) -> Result<Found, Error> {
    let system = scenes::minimal()?;
    energy("double pendulum, M(q)", 9.81, |refine| minimal_energies(&system, steps * refine, 0.01 / refine as f64))
}

/// Linear momentum is linear in the state, and kept to rounding; angular momentum is not, and kept as the energy is.
fn momenta(steps: usize, rebased: bool) -> Result<Found, Error> {
    let mechanism = scenes::free_pairs()?;
    let n = mechanism.system.n();
    let p_star = DVector::from_fn(n, |i, _| 0.4 * (12.9 * (i + 1) as f64).sin());
    let start = Start::Momentum { q: mechanism.system.initial_coordinates(), p_star };
    let record = |refine: usize| -> Result<[Vec<(f64, f64)>; 3], Error> {
        let mut parts: [Vec<(f64, f64)>; 3] = Default::default();
        let dt = 0.01 / refine as f64;
        let march = March { start: start.clone(), rebased, ..March::new(&mechanism.system, steps * refine, dt) };
        march.run(|motion, _| {
            for i in 0..motion.computed {
                let momenta = mechanism.momenta(motion.q.column(i).as_slice(), motion.v.column(i).as_slice());
                parts.iter_mut().zip(momenta).for_each(|(part, p)| part.push((motion.times[i], p)));
            }
        })?;
        Ok(parts)
    };
    let (coarse, fine) = (record(1)?, record(2)?);
    let most = |part: &[(f64, f64)]| deviation(part, (0.0, 1.0));
    let (first, last) = (deviation(&coarse[2], (0.0, 0.1)), deviation(&coarse[2], (0.9, 1.0)));
    Ok(vec![
        Measure::at_most("linear [N s]", most(&coarse[0]).max(most(&coarse[1])), 1e-16 * steps as f64),
        Measure::told("angular [N m s]", most(&coarse[2])),
        Measure::at_most("its last tenth over first", last / first, BOUNDED),
        Measure::between("its order", (most(&coarse[2]) / most(&fine[2])).log2(), SECOND),
    ]
    .into())
}

/// E − E_0 = ∫ (u φ̇ − c φ̇²) dt, the integral by the trapezoidal rule.
fn power() -> Result<Found, Error> {
    const FRICTION: f64 = 0.3;
    let torque = |t: f64| 4.0 * (3.0 * t).sin();
    let mechanism = scenes::chain(Units::SI, &[1.0, 0.8, 0.6], -1.2, FRICTION)?;
    let imbalance = |steps: usize| -> Result<f64, Error> {
        let dt = 5.0 / steps as f64;
        let march = March { control: torque, ..March::new(&mechanism.system, steps, dt) };
        let (mut work, mut before, mut start, mut worst) = (0.0, None, None, 0.0f64);
        let phi = mechanism.angle(0);
        march.run(|motion, inputs| {
            // The first node of a later piece is the last of the one before.
            for i in usize::from(start.is_some())..motion.computed {
                let (q, v) = (motion.q.column(i), motion.v.column(i));
                let power = inputs.controls[(0, i)] * v[phi] - FRICTION * v[phi] * v[phi];
                let energy = mechanism.energy(q.as_slice(), v.as_slice());
                work += before.map_or(0.0, |before: f64| 0.5 * dt * (before + power));
                before = Some(power);
                worst = worst.max((energy - *start.get_or_insert(energy) - work).abs());
            }
        })?;
        Ok(worst)
    };
    let (coarse, fine) = (imbalance(1000)?, imbalance(2000)?);
    Ok(vec![Measure::told("imbalance at 5 ms [J]", coarse), Measure::between("order", (coarse / fine).log2(), SECOND)]
        .into())
}

fn energy_over_step() -> Result<Found, Error> {
    let (chain, crank) = (swinging_chain()?, crank()?);
    let lengths = [0.04, 0.02, 0.01, 0.005, 0.0025];
    let over = |run: &dyn Fn(usize, f64) -> Record| -> Result<Vec<(f64, f64)>, Error> {
        let error = |dt: f64| Ok((dt, deviation(&run((20.0 / dt) as usize, dt).complete()?, (0.0, 1.0)) / 9.81));
        lengths.into_iter().map(error).collect()
    };
    let angles = scenes::minimal()?;
    let curves = [
        ("chain, restarted", over(&|steps, dt| energies(&chain, steps, dt, true))?),
        ("slider-crank, restarted", over(&|steps, dt| energies(&crank, steps, dt, true))?),
        ("double pendulum, M(q)", over(&|steps, dt| minimal_energies(&angles, steps, dt))?),
    ];
    let order = |points: &[(f64, f64)]| (points[3].1 / points[4].1).log2();
    let measures = curves.iter().map(|(name, points)| Measure::between(format!("order, {name}"), order(points), SECOND));
    let measures = measures.collect();
    let curve = |(name, points): (&str, _)| Curve { of: Quantity::Energy, over_time: false, name: name.into(), points };
    Ok(Found { measures, curves: curves.map(curve).into(), stopped: None })
}
