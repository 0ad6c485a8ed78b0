//! How often `solve` finds a minimum from starts with random controls, and in which time.

use std::f64::consts::PI;
use std::time::Instant;

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::optimize::{Guess, MotionProblem, Options, Variables, silent, solve};

use super::problems::Name;
use super::{Error, pose};
use crate::statistics::median;

/// Number of sines in a random control, and their largest coefficient, N or N m.
const SINES: usize = 6;
const LARGEST: f64 = 10.0;
/// Relative difference of values that are the same.
const ALIKE: f64 = 1e-3;

/// A sentence about the outcomes from random starts; the first one is without controls.
pub fn solved(name: Name, starts: usize) -> Result<String, Error> {
    let (posed, options, mut random) = (pose(name)?, Options::default(), Random::new(1));
    let (mut values, mut times) = (Vec::new(), Vec::new());
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
        times.push(1e3 * begin.elapsed().as_secs_f64());
        if found.reason.is_converged() && found.violation <= options.violation {
            values.push(found.value);
        }
    }
    let best = values.iter().copied().fold(f64::INFINITY, f64::min);
    let alike = values.iter().filter(|value| **value <= best + ALIKE * best.abs()).count();
    Ok(format!(
        " `{}`: {} of {starts} starts with random controls converge, {alike} of them to the best value {best:.6}; the median time is {:.0} ms.",
        name.text(),
        values.len(),
        median(&times)
    ))
}
