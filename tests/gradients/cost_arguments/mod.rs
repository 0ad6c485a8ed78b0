//! What costs may depend on beside coordinates, velocities and controls: accelerations and reactions, rates of controls, lists of any length.

mod accelerations;
mod coupled;

use crate::common::relative_error;
use crate::scenes::{elements, ready_parts, seven_bodies, varying};
use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Gradient, Inputs, Settings, System, gradient};

fn list(all: &[Input], gradient: &Gradient) -> Vec<f64> {
    all.iter().map(|input| input.in_gradient(gradient)).collect()
}

/// The largest difference between the gradient and complex step, relative to the largest derivative.
fn error(system: &System, inputs: &Inputs, settings: Settings) -> f64 {
    let all = Input::all(inputs);
    let ours = list(&all, &gradient(system, inputs, settings).expect("a gradient"));
    relative_error(&ours, &complex_step(system, inputs, settings, &all).expect("the same motion"))
}
