//! How long a simulation, a gradient by the adjoint and one by complex step take.

use std::time::{Duration, Instant};

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Error, Inputs, Settings, Solver, System};

use crate::statistics::median;
use crate::table::{Row, Verdict};

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
pub fn claims(timing: &Timing) -> Vec<Row> {
    let faster = |paper: f64, ours: f64| format!("{ours:.2e} s, {:.0} times faster", paper / ours);
    let row = |what: &str, paper: String, ours: String, verdict| Row::new("Timing", what, paper, ours, verdict);
    let (adjoint, complex) = (timing.value_and_gradient, timing.complex_step);
    let (ratio, paper_ratio) = (complex / adjoint, PAPER_COMPLEX / PAPER_ADJOINT);
    let words = format!("{ratio:.0}: the adjoint is far cheaper here too");
    let (slow, fast) = (faster(PAPER_COMPLEX, complex), faster(PAPER_ADJOINT, adjoint));
    vec![
        row("one simulation", "not stated".into(), format!("{:.2e} s", timing.forward), Verdict::NotStated),
        row("value and gradient by the adjoint", format!("{PAPER_ADJOINT} s"), fast, Verdict::Differs),
        row("gradient by complex step", format!("{PAPER_COMPLEX} s"), slow, Verdict::Differs),
        // A simulation for each of the 101 controls against about two in all.
        row("complex step over adjoint", format!("{paper_ratio:.0}"), words, Verdict::reproduced_if(ratio > 30.0)),
    ]
}
