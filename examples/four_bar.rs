//! A crank and rocker with variable lengths: computes their effect on the final angle and speed of the rocker.
//!
//! Masses and moments of inertia depend on the lengths, and so does the start, which is assembled from a guess with the crank held.
//!
//! `cargo run --release --example four_bar`

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, Solver, Start, check};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rods = [("crank", 0.2, [0.0, 0.1, 1.6]), ("coupler", 0.6, [0.3, 0.4, 0.6]), ("rocker", 0.5, [0.7, 0.3, 1.8])];
    let [crank, coupler, rocker] = rods.map(|(name, length, place)| {
        let l = scene.design(name, length); // m, 1 kg/m
        (scene.body(name, l, l * l * l / 12.0, place), l * 0.5)
    });
    scene.revolute("A", Body::GROUND.at(0.0, 0.0), crank.0.at(-crank.1, 0.0));
    scene.revolute("B", crank.0.at(crank.1, 0.0), coupler.0.at(-coupler.1, 0.0));
    scene.revolute("C", coupler.0.at(coupler.1, 0.0), rocker.0.at(rocker.1, 0.0));
    scene.revolute("D", Body::GROUND.at(0.8, 0.0), rocker.0.at(-rocker.1, 0.0));
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, crank.0, torque);
    let end = scene.end_state(rocker.0.coordinates[2]);
    let system = scene.compile()?;

    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.005));
    inputs.start = Start::assembled(&system).hold(&[crank.0.coordinates[2]]);
    inputs.set_control(torque, |_| 1.5);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs)?;
    let values = solver.outputs()?.clone();
    let gradients = solver.jacobian()?;
    for (what, unit, of) in [("angle", "rad", end.position.index()), ("speed", "rad/s", end.rate.index())] {
        let by_length = &gradients[of].design;
        println!(
            "{what} {:+.6} {unit}, derivatives with respect to the lengths {:+.6?} {unit}/m",
            values[of],
            by_length.as_slice()
        );
    }
    let report = check::gradient(&system, &inputs, Settings::default()).output(end.rate).run()?;
    println!("{report}");
    if report.passed() { Ok(()) } else { Err("a derivative is wrong".into()) }
}
