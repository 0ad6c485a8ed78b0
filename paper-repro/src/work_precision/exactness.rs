//! Differences between the adjoint and complex step on composed grids: only rounding errors.

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Error, System, gradient};
use serde::Serialize;

use super::{METHODS, Method};
use crate::statistics::relative_difference;

/// Number of controls, and of step lengths, that are compared on each grid.
const SAMPLES: usize = 24;

/// The differences on one grid, in the maximum norm, relative to the largest derivative of that kind.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Exactness {
    pub scheme: &'static str,
    pub macro_steps: usize,
    /// Steps of the rule per macro step.
    pub stages: usize,
    pub controls: f64,
    pub steps: f64,
}

pub fn measure(system: &System, all_macro_steps: &[usize]) -> Result<Vec<Exactness>, Error> {
    let grids = METHODS.iter().flat_map(|method| all_macro_steps.iter().map(move |&n| (method, n)));
    grids.map(|(method, macro_steps)| compare(system, method, macro_steps)).collect()
}

fn compare(system: &System, method: &Method, macro_steps: usize) -> Result<Exactness, Error> {
    let (inputs, settings) = (method.constant_force(system, macro_steps), method.settings());
    let adjoint = gradient(system, &inputs, settings)?;
    let difference = |sample: Vec<Input>| {
        let ours: Vec<f64> = sample.iter().map(|input| input.in_gradient(&adjoint)).collect();
        complex_step(system, &inputs, settings, &sample).map(|theirs| relative_difference(&ours, &theirs))
    };
    let last = inputs.grid.steps.len();
    Ok(Exactness {
        scheme: method.name,
        macro_steps,
        stages: method.stages(),
        controls: difference(sample(0, last).map(|node| Input::Control { channel: 0, node }).collect())?,
        steps: difference(sample(1, last).map(Input::Step).collect())?,
    })
}

/// Whole numbers from the first to the last, spread as evenly as possible, so that every stage occurs.
fn sample(first: usize, last: usize) -> impl Iterator<Item = usize> {
    let count = SAMPLES.min(last - first + 1);
    (0..count).map(move |index| first + index * (last - first) / (count - 1).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_have_both_ends_and_every_stage() {
        for method in METHODS {
            let (stages, last) = (method.composition.stages(), 50 * method.composition.stages());
            let nodes: Vec<usize> = sample(0, last).collect();
            assert_eq!((nodes[0], nodes[SAMPLES - 1]), (0, last));
            assert!((0..stages).all(|stage| nodes.iter().any(|node| node % stages == stage)), "{}", method.name);
        }
        assert!(sample(1, 3).eq([1, 2, 3]));
    }
}
