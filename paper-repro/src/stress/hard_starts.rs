//! Steps that are too long, forces that jump, chains that are very long.

use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, Solver, System};

use super::assembly::Units;
use super::motion::{amplification, gradient_error};
use super::row::{Found, Measure, Trial};
use super::scenes;

const GROUP: &str = "hard starts";
const TOO_LONG: &str = "Newton's iteration has no solution for this step";

pub fn trials() -> Vec<Trial> {
    let swing_up = |dt: f64| {
        Trial::new(GROUP, format!("cart, u = 10 N, Δt = {dt} s for 2 s"), move || {
            let system = cart(3)?;
            judged(&system, &pushed(&system, (2.0 / dt) as usize, dt, |_| 10.0), 20)
        })
        .or_refused(TOO_LONG)
    };
    let jumps = |force: f64, dt: f64| {
        Trial::new(GROUP, format!("cart, u = ±{force:e} N in turns of 5 steps, Δt = {dt} s for 2 s"), move || {
            let system = cart(3)?;
            let turns = move |i: usize| if (i / 5).is_multiple_of(2) { force } else { -force };
            judged(&system, &pushed(&system, (2.0 / dt) as usize, dt, turns), 20)
        })
        .or_refused(TOO_LONG)
    };
    let links = |links: usize, dt: f64| {
        Trial::new(GROUP, format!("cart with {links} links, u = 10 N, Δt = {dt} s, 100 steps"), move || {
            let system = cart(links)?;
            judged(&system, &pushed(&system, 100, dt, |_| 10.0), 3)
        })
        .or_refused(TOO_LONG)
    };
    vec![
        swing_up(0.1),
        swing_up(0.2),
        swing_up(0.5),
        swing_up(1.0),
        jumps(1e2, 0.02),
        jumps(1e4, 0.02),
        jumps(1e4, 0.002),
        links(100, 0.01),
        links(1000, 0.001),
        links(1000, 0.01),
    ]
}

fn cart(links: usize) -> Result<System, Error> {
    scenes::cart(Units::SI, links).scene().compile()
}

fn pushed(system: &System, steps: usize, dt: f64, force: impl Fn(usize) -> f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, dt));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = force(i));
    inputs
}

fn judged(system: &System, inputs: &Inputs, samples: usize) -> Result<Found, Error> {
    let mut solver = Solver::new(system, Settings::default());
    let motion = solver.simulate(inputs)?;
    let speed = motion.v.amax();
    let rate = motion.phi_dot(system, inputs)?.amax() / speed;
    let report = solver.report().clone();
    let error = gradient_error(system, inputs, Settings::default(), samples)?;
    // See `chaos`.
    let amplified = amplification(system, inputs)?.max(1.0);
    Ok(vec![
        Measure::at_most("gradient error", error, (1e-11 * amplified * amplified).min(1e-2)),
        Measure::told("|δq|/|δv₀|", amplified),
        Measure::at_most("‖dΦ/dt‖/‖v‖", rate, 1e-11),
        Measure::told("largest v", speed),
        Measure::told("most iterations", report.most_iterations as f64),
    ]
    .into())
}
