//! Steps that are too long, forces that jump, chains that are very long.

use hamiltonian_adjoint::{Error, Grid, Inputs, Report, Settings, Solver, Sum, System, Warning};

use super::motion::{March, amplification, gradient_error};
use super::row::{Measure, Trial};
use crate::mechanisms as scenes;

const TOO_LONG: &str = "Newton's iteration has no solution for this step";

pub fn trials() -> Vec<Trial> {
    let few = |system: &System, inputs: &Inputs| judged(system, inputs, 3);
    let many = |system: &System, inputs: &Inputs| judged(system, inputs, 20);
    let over = |dt: f64| ((2.0 / dt) as usize, dt);
    let swing_up = |dt: f64| cart(format!("cart, u = 10 N, Δt = {dt} s for 2 s"), 3, over(dt), |_| 10.0, many);
    let jumps = |force: f64, dt: f64| {
        cart(
            format!("cart, u = ±{force:e} N with a change of sign every 5 steps, Δt = {dt} s for 2 s"),
            3,
            over(dt),
            turns(force),
            many,
        )
    };
    let links = |links: usize, dt: f64| {
        cart(format!("cart with {links} links, u = 10 N, Δt = {dt} s, 100 steps"), links, (100, dt), |_| 10.0, few)
    };
    let unresolved =
        "cart, u = ±1e4 N with a change of sign every 5 steps, Δt = 0.02 s for 2 s: not resolved, with a warning";
    let heavy = "cart with 1000 links, u = 10 N, Δt = 0.01 s, 100 steps: not resolved, with a warning";
    vec![
        swing_up(0.1),
        swing_up(0.2),
        swing_up(0.5),
        swing_up(1.0),
        jumps(1e2, 0.02),
        cart(unresolved.into(), 3, over(0.02), turns(1e4), far_too_long),
        jumps(1e4, 0.002),
        links(100, 0.01),
        links(1000, 0.001),
        links(1000, 0.0025),
        cart(heavy.into(), 1000, (100, 0.01), |_| 10.0, heavy_chain),
        Trial::new("sled driven by v², two steps far too long", halved),
        Trial::new("slider-crank spun up by 3 N m, Δt = 0.02 s for 2 s", spun_up),
    ]
}

/// The cart with the given number of links, started from rest, with the given force in each step.
fn cart(
    tried: String,
    links: usize,
    (steps, dt): (usize, f64),
    force: impl Fn(usize) -> f64 + 'static,
    judge: impl Fn(&System, &Inputs) -> Result<Vec<Measure>, Error> + 'static,
) -> Trial {
    let run = move || {
        let system = scenes::paper_cart(links)?;
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = force(i));
        judge(&system, &inputs)
    };
    Trial::new(tried, run).or_refused(TOO_LONG, motion_has_no_solution)
}

/// A force that changes its sign every five steps.
fn turns(force: f64) -> impl Fn(usize) -> f64 {
    move |i| if (i / 5).is_multiple_of(2) { force } else { -force }
}

/// Six easy steps, two that must be halved, and one more: the warning states the step, and the gradient is that of the grid used.
fn halved() -> Result<Vec<Measure>, Error> {
    let (system, inputs) = scenes::sled(&[Sum::Trapezoidal])?;
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs)?;
    let (step, inserted, shortest) = halving(solver.report());
    let error = gradient_error(&system, &inputs, Settings::default(), 20)?;
    Ok(vec![
        Measure::at_most("gradient error", error, 1e-11),
        Measure::between("first halved step", step, (7.0, 7.0)),
        Measure::between("inserted nodes", inserted, (2.0, 100.0)),
        Measure::reported("shortest part [s]", shortest),
    ])
}

/// The warnings of the motion, not of a complex step through it.
fn motion_has_no_solution(error: &Error) -> bool {
    matches!(error, Error::Newton { equation, .. } if !equation.contains("complex"))
}

fn judged(system: &System, inputs: &Inputs, samples: usize) -> Result<Vec<Measure>, Error> {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs)?;
    let (motion, report) = (solver.trajectory(), solver.report());
    let speed = motion.v.amax();
    let rate = motion.phi_dot(system, solver.inputs())?.amax() / speed;
    let error = gradient_error(system, inputs, Settings::default(), samples)?;
    // See `chaos`.
    let amplified = amplification(system, inputs)?.max(1.0);
    Ok(vec![
        Measure::at_most("gradient error", error, (1e-11 * amplified * amplified).min(1e-2)),
        Measure::reported("|δq|/|δv₀|", amplified),
        Measure::at_most("‖dΦ/dt‖/‖v‖", rate, 1e-11),
        Measure::reported("largest v", speed),
        Measure::reported("most iterations", report.most_iterations as f64),
        Measure::reported("nodes inserted by halving", motion.inserted.len() as f64),
    ])
}

/// From 1.9 s on the initial guess is useless, and the equations of a step have further solutions with other energies; the error of the
/// intended one falls with the order of the rule.
fn spun_up() -> Result<Vec<Measure>, Error> {
    const TORQUE: f64 = 3.0;
    let mechanism = scenes::crank()?;
    let phi = mechanism.angle(0);
    let imbalance = |steps: usize| -> Result<(f64, f64), Error> {
        let (mut first, mut imbalance, mut work) = (None, 0.0f64, 0.0f64);
        let march = March { control: |_| TORQUE, ..March::new(&mechanism.system, steps, 2.0 / steps as f64) };
        let report = march.run(|at| {
            let energy = mechanism.energy(at.q, at.v);
            let (start, angle) = *first.get_or_insert((energy, at.q[phi]));
            work = work.max(TORQUE * (at.q[phi] - angle));
            imbalance = imbalance.max((energy - start - TORQUE * (at.q[phi] - angle)).abs());
        })?;
        Ok((imbalance / work, rough_step(&report)))
    };
    let [(long, rough), (short, _)] = [imbalance(100)?, imbalance(200)?];
    Ok(vec![
        Measure::reported("imbalance over the work done", long),
        Measure::between("order in Δt", (long / short).log2(), (1.7, 2.3)),
        Measure::between("first step reported as rough", rough, (90.0, 100.0)),
    ])
}

/// The first halved step, the number of inserted nodes and the shortest part, according to the report.
fn halving(report: &Report) -> (f64, f64, f64) {
    let found = report.warnings.iter().find_map(|warning| match warning {
        Warning::HalvedSteps { step, inserted, shortest, .. } => Some((*step as f64, *inserted as f64, *shortest)),
        _ => None,
    });
    found.unwrap_or((f64::NAN, 0.0, f64::NAN))
}

/// The first step that the report calls rough.
pub fn rough_step(report: &Report) -> f64 {
    let steps = report.warnings.iter().filter_map(|warning| match warning {
        Warning::Rough { step, .. } => Some(*step as f64),
        _ => None,
    });
    steps.fold(f64::NAN, f64::min)
}

/// A force that changes the velocity by ±200 m/s in each step: after 2 s angles turn by 1e6 rad and more per step, so their sines have few
/// correct digits and derivatives have none. The result must be a warning or an error.
fn far_too_long(system: &System, inputs: &Inputs) -> Result<Vec<Measure>, Error> {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs)?;
    let turn = solver.report().warnings.iter().find_map(|warning| match warning {
        Warning::Unresolved { turn, .. } => Some(*turn),
        _ => None,
    });
    Ok(vec![
        Measure::between("turn in one step, according to the report [rad]", turn.unwrap_or(0.0), (Warning::TURN, f64::MAX)),
        Measure::reported("largest v", solver.trajectory().v.amax()),
    ])
}

/// The links at the top carry 3.9 kN, so Δt² λ = m L, and multipliers and links jump from node to node. The report must warn of this.
fn heavy_chain(system: &System, inputs: &Inputs) -> Result<Vec<Measure>, Error> {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs)?;
    let (halved, ..) = halving(solver.report());
    Ok(vec![
        Measure::between("first halved step", halved, (1.0, 50.0)),
        Measure::reported("first rough step", rough_step(solver.report())),
        Measure::reported("largest v", solver.trajectory().v.amax()),
    ])
}
