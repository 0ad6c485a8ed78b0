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

use common::largest;
use hamiltonian_adjoint::check::Input;
use hamiltonian_adjoint::{Cx, Gradient, Inputs, LiftedSolver, Settings, System, gradient};

fn list(all: &[Input], gradient: &Gradient) -> Vec<f64> {
    all.iter().map(|input| input.in_gradient(gradient)).collect()
}

/// The largest difference between the gradient and complex step, relative to the largest derivative.
fn error(system: &System, inputs: &Inputs, settings: Settings) -> f64 {
    let all = Input::all(inputs);
    let ours = list(&all, &gradient(system, inputs, settings).expect("a gradient"));
    let mut lifted = LiftedSolver::<Cx>::new(system, inputs, settings).expect("a motion");
    let reference: Vec<f64> = Vec::from_iter(all.iter().map(|input| {
        let mut moved = inputs.lift::<Cx>();
        *input.of(&mut moved) += Cx::new(0.0, 1e-30);
        lifted.simulate(&moved).expect("the same motion");
        lifted.cost().expect("a cost").0.im / 1e-30
    }));
    let differences: Vec<f64> = ours.iter().zip(&reference).map(|(a, b)| a - b).collect();
    largest(&differences) / largest(&reference)
}
