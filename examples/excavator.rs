//! An excavator's boom and stick, moved by two hydraulic cylinders: computes the height of the stick and its dependence on a pin.
//!
//! No derivative is derived by hand: the start is assembled from a guess, the cylinders are ready-made parts, the position of the boom's pin is a
//! design variable, and the derivative with respect to it includes the assembly.
//!
//! `cargo run --release --example excavator`

use hamiltonian_adjoint::check;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Animation, Grid, Inputs, Scene, Settings, Solver, Start};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let pin = scene.design("pin of the cylinder along the boom", 0.6); // m, from the middle
    let boom = scene.body("boom", 900.0, 2400.0, [2.0, 1.5, 0.6]);
    let stick = scene.body("stick", 500.0, 400.0, [4.5, 2.0, -0.9]);
    scene.revolute("foot", Body::GROUND.at(0.0, 0.0), boom.at(-2.5, 0.0));
    scene.revolute("knee", boom.at(2.5, 0.0), stick.at(-1.0, 0.0));
    let [lift, crowd] = ["lift", "crowd"].map(|name| scene.control(name));
    scene.two_point_actuator("boom cylinder", Body::GROUND.at(0.6, -0.4), boom.at(pin, -0.2), lift);
    scene.two_point_actuator("stick cylinder", boom.at(0.4, 0.5), stick.at(-1.4, 0.3), crowd);
    scene.effort("effort", lift, 1e-10);
    let height = scene.end_state(stick.coordinates[1]).position;
    let system = scene.compile()?;

    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    inputs.start = Start::assembled(&system).hold(&[boom.coordinates[2], stick.coordinates[2]]);
    inputs.set_control(lift, |_| 9.0e4);
    inputs.set_control(crowd, |t| -1.2e4 + 4.0e3 * (6.0 * t).sin());

    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs)?.clone();
    let page = std::env::temp_dir().join("excavator.html");
    Animation::new(&system, solver.inputs(), &motion)?.title("Excavator").write_html(&page)?;
    println!(
        "animation: {}; the middle of the stick is at a height of {:.3} m after 1 s",
        page.display(),
        solver.outputs()?[height.index()]
    );

    let of_pin = solver.jacobian()?[height.index()].design[0];
    let effort = solver.gradient()?;
    println!("d(height)/d(pin) = {of_pin:+.6} m/m; d(effort)/d(force at 0.5 s) = {:+.3e}", effort.controls[(0, 50)]);
    let report = check::gradient(&system, &inputs, Settings::default()).output(height).run()?;
    println!("{report}");
    if report.passed() { Ok(()) } else { Err("a derivative is wrong".into()) }
}
