//! How long a simulation, a gradient by the adjoint and one by complex step take.

use std::time::{Duration, Instant};

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Error, Inputs, Settings, Solver, System};

use crate::statistics::median;
use crate::table::{Claim, Verdict};

/// T_adjoint of the paper, s.
const PAPER_ADJOINT: f64 = 0.35;
/// T_complex of the paper, s.
const PAPER_COMPLEX: f64 = 150.0;

/// Medians over repeats, s.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// One simulation.
    pub forward: f64,
    /// One simulation and the gradient with respect to all controls by the adjoint.
    pub value_and_gradient: f64,
    /// The same gradient by complex step.
    pub complex_step: f64,
}

/// Measures on one thread, memory allocated and caches warm.
///
/// # Errors
/// A simulation without a solution.
pub fn measure(system: &System, inputs: &Inputs, controls: &[Input]) -> Result<Timing, Error> {
    let settings = Settings::default();
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs)?;
    solver.gradient()?;
    Ok(Timing {
        forward: median_time(|| solver.simulate(inputs).map(|_| ()))?,
        value_and_gradient: median_time(|| {
            solver.simulate(inputs)?;
            solver.gradient().map(|_| ())
        })?,
        complex_step: median_time(|| complex_step(system, inputs, settings, controls).map(|_| ()))?,
    })
}

/// The median time of a call, s, over at least five calls and half a second.
fn median_time(mut run: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
    const ENOUGH: (usize, Duration) = (5, Duration::from_millis(500));
    let (begin, mut times) = (Instant::now(), Vec::new());
    while times.len() < ENOUGH.0 || begin.elapsed() < ENOUGH.1 {
        let start = Instant::now();
        run()?;
        times.push(start.elapsed().as_secs_f64());
    }
    Ok(median(&times))
}

/// The times beside those of the paper, which no claim can fail: they are another computer's.
pub fn claims(timing: &Timing) -> Vec<Claim> {
    let faster = |paper: f64, ours: f64| format!("{ours:.2e} s, {:.0} times faster", paper / ours);
    let row = |what: &str, paper: String, ours: String, verdict| Claim {
        figure: "Timing".into(),
        what: what.into(),
        paper,
        ours,
        verdict,
    };
    let ratio = timing.complex_step / timing.value_and_gradient;
    let paper_ratio = PAPER_COMPLEX / PAPER_ADJOINT;
    vec![
        row("one simulation", "not stated".into(), format!("{:.2e} s", timing.forward), Verdict::NotStated),
        row(
            "value and gradient by the adjoint",
            format!("{PAPER_ADJOINT} s"),
            faster(PAPER_ADJOINT, timing.value_and_gradient),
            Verdict::Differs,
        ),
        row(
            "gradient by complex step",
            format!("{PAPER_COMPLEX} s"),
            faster(PAPER_COMPLEX, timing.complex_step),
            Verdict::Differs,
        ),
        row(
            "complex step over adjoint",
            format!("{paper_ratio:.0}"),
            format!("{ratio:.0}: the adjoint is far cheaper here too"),
            // A simulation for each of the 101 controls against about two in all.
            if ratio > 30.0 { Verdict::Reproduced } else { Verdict::Differs },
        ),
    ]
}
