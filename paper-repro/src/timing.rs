//! Run times of a simulation, of a gradient by the adjoint and of a gradient by complex step.

use std::time::Duration;

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Error, Inputs, Settings, System};

use crate::stopwatch::{self, Job, Repeats, simulation};
use crate::table::{Row, Verdict};

/// T_adjoint of the paper, s.
const PAPER_ADJOINT: f64 = 0.35;
/// T_complex of the paper, s.
const PAPER_COMPLEX: f64 = 150.0;

/// Measured times, s.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    pub forward: f64,
    /// One simulation and the gradient with respect to all controls by the adjoint.
    pub value_and_gradient: f64,
    /// The same gradient by complex step.
    pub complex_step: f64,
}

/// Measures on one thread with allocated memory and warm caches.
pub fn measure(system: &System, inputs: &Inputs, controls: &[Input]) -> Result<Timing, Error> {
    let mut jobs: [Job; 3] = [
        simulation(system, inputs),
        stopwatch::value_and_gradient(system, inputs),
        Box::new(|| complex_step(system, inputs, Settings::default(), controls).map(|_| ())),
    ];
    let repeats = Repeats { turns: 5, turn: Duration::from_millis(100) };
    let [forward, value_and_gradient, complex_step] = repeats.times(&mut jobs)?[..] else { unreachable!("three jobs") };
    Ok(Timing { forward, value_and_gradient, complex_step })
}

/// The times beside those of the paper. No claim can fail, because the paper's times are from another computer.
pub fn claims(timing: &Timing) -> Vec<Row> {
    let faster = |paper: f64, ours: f64| format!("{ours:.2e} s, {:.0} times faster", paper / ours);
    let row = |what: &str, paper: String, ours: String, verdict| Row::new("Timing", what, paper, ours, verdict);
    let (adjoint, complex) = (timing.value_and_gradient, timing.complex_step);
    let (ratio, paper_ratio) = (complex / adjoint, PAPER_COMPLEX / PAPER_ADJOINT);
    let words = format!("{ratio:.0}: the adjoint is far cheaper here too, but by a different factor");
    let (slow, fast) = (faster(PAPER_COMPLEX, complex), faster(PAPER_ADJOINT, adjoint));
    vec![
        row("one simulation", "not stated".into(), format!("{:.2e} s", timing.forward), Verdict::NotStated),
        row("value and gradient by the adjoint", format!("{PAPER_ADJOINT} s"), fast, Verdict::Differs),
        row("gradient by complex step", format!("{PAPER_COMPLEX} s"), slow, Verdict::Differs),
        // Complex step needs a simulation for each of the 101 controls, the adjoint the time of about two in all.
        row(
            "complex step over adjoint",
            format!("{paper_ratio:.0}"),
            words,
            Verdict::reproduced_if((0.5..2.0).contains(&(ratio / paper_ratio))),
        ),
    ]
}
