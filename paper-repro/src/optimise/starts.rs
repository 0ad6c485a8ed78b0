//! How often `solve` finds a minimum from starts with random controls, and in which time.

use std::f64::consts::PI;
use std::time::Instant;

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::optimize::{Guess, MotionProblem, Options, Variables, silent, solve};

use serde::Serialize;

use super::problems::Name;
use super::{Error, pose};
use crate::statistics::median;

/// Number of sines in a random control, and their largest coefficient, N or N m.
const SINES: usize = 6;
const LARGEST: f64 = 10.0;
/// Relative difference of values that are the same.
const ALIKE: f64 = 1e-3;

/// The outcome from a start.
#[derive(Serialize)]
pub struct Started {
    problem: String,
    converged: bool,
    value: f64,
    milliseconds: f64,
}

/// The outcomes from random starts; the first one is without controls.
pub fn solved(name: Name, starts: usize) -> Result<Vec<Started>, Error> {
    let (posed, options, mut random) = (pose(name)?, Options::default(), Random::new(1));
    let mut all = Vec::new();
    for start in 0..starts {
        let mut inputs = posed.inputs.clone();
        inputs.controls.fill(0.0);
        let steps = inputs.grid.steps.len() as f64;
        for mut control in inputs.controls.row_iter_mut().filter(|_| start > 0) {
            let sines: [f64; SINES] = std::array::from_fn(|_| random.uniform(-LARGEST, LARGEST));
            for (node, u) in control.iter_mut().enumerate() {
                let share = PI * node as f64 / steps;
                *u = (1..).zip(&sines).map(|(j, of)| of * (f64::from(j) * share).sin()).sum();
            }
        }
        let variables = Variables::new(&posed.system, &inputs, posed.free.clone())?;
        let mut problem = MotionProblem::new(&posed.system, posed.settings, inputs, variables)?;
        posed.constraints.iter().for_each(|(output, to)| problem.constrain(*output, *to));
        let begin = Instant::now();
        let found = solve(&mut problem, Guess::Straight, &options, &mut silent)?.outcome;
        all.push(Started {
            problem: name.text(),
            converged: found.reason.is_converged() && found.violation <= options.violation,
            value: found.value,
            milliseconds: 1e3 * begin.elapsed().as_secs_f64(),
        });
    }
    Ok(all)
}

/// A sentence about the outcomes of one problem.
pub fn sentence(all: &[Started]) -> String {
    let values: Vec<f64> = all.iter().filter(|of| of.converged).map(|of| of.value).collect();
    let best = values.iter().copied().fold(f64::INFINITY, f64::min);
    let alike = values.iter().filter(|value| **value <= best + ALIKE * best.abs()).count();
    let times: Vec<f64> = all.iter().map(|of| of.milliseconds).collect();
    format!(
        " `{}`: {} of {} starts with random controls converge, {alike} of them to the best value {best:.6}; the median time is {:.0} ms.",
        all.first().map_or("", |of| &of.problem),
        values.len(),
        all.len(),
        median(&times)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_that_do_not_converge_have_no_best_value() {
        let of = |converged, value| Started { problem: "arm".into(), converged, value, milliseconds: 2.0 };
        let text = sentence(&[of(true, 0.3), of(false, 0.1), of(true, 0.300_001)]);
        assert!(text.contains("`arm`: 2 of 3 starts") && text.contains("2 of them to the best value 0.300000"), "{text}");
    }
}
