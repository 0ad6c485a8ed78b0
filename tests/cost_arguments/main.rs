//! What costs may depend on beside coordinates, velocities and controls: accelerations and reactions, rates of controls, lists of any length.

#[path = "../common/mod.rs"]
mod common;
#[path = "../scenes/elements.rs"]
#[allow(dead_code)]
mod elements;
#[path = "../scenes/ready_parts.rs"]
#[allow(dead_code)]
mod ready_parts;
#[path = "../scenes/seven_bodies.rs"]
#[allow(dead_code)]
mod seven_bodies;
#[path = "../scenes/varying.rs"]
#[allow(dead_code)]
mod varying;

mod accelerations;
mod coupled;

use common::relative_error;
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
