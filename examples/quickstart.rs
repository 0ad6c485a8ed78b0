//! The paper's example: simulates the cart with three links, computes the gradient and verifies it.
//!
//! `cargo run --release --example quickstart`

use std::error::Error;

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes::CartPendulum};

fn main() -> Result<(), Box<dyn Error>> {
    // The mechanism with its terminal cost S = ½ Σ (φ_j − π/2)².
    let mechanism = CartPendulum::default();
    let system = mechanism.scene().compile()?;
    println!("{} coordinates, {} constraints, {} control", system.n(), system.m(), system.k());

    // N = 100 steps of 0.02 s from rest; the force on the cart is 10 N at all 101 nodes.
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    inputs.controls.fill(10.0);

    // The motion: one column of q, v, p*, ṗ*, σ for each node.
    let settings = Settings::default();
    let mut solver = Solver::new(&system, settings);
    solver.simulate(&inputs)?;
    let motion = solver.trajectory();
    let last = motion.last();
    println!("t = {:.2} s:  x of the cart {:.4} m", motion.times[last], motion.q[(0, last)]);
    for i in (0..system.n()).filter(|&i| system.coordinate_name(i).starts_with("link") && i % 3 == 2) {
        println!("            {} = {:.4} rad", system.coordinate_name(i), motion.q[(i, last)]);
    }
    let (phi, phi_dot) = (motion.phi(&system, solver.inputs())?.amax(), motion.phi_dot(&system, solver.inputs())?.amax());
    println!("largest |Φ| {phi:.1e}, largest |dΦ/dt| {phi_dot:.1e}");

    // The gradient, by one backward sweep.
    let gradient = solver.gradient()?;
    println!("J = {:.14}", gradient.value);
    for i in [0, 1, 50, 99, 100] {
        println!("dJ/du_{i:<3} = {:+.6e}", gradient.controls[(0, i)]);
    }

    // The same derivatives by complex step: 101 simulations in complex numbers.
    let controls: Vec<Input> = (0..inputs.grid.nodes()).map(|node| Input::Control { channel: 0, node }).collect();
    let reference = complex_step(&system, &inputs, settings, &controls)?;
    let largest = reference.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let error = gradient.controls.iter().zip(&reference).fold(0.0f64, |e, (a, b)| e.max((a - b).abs())) / largest;
    println!("largest difference to the complex step, relative to the largest derivative: {error:.1e}");
    if error > 1e-12 {
        return Err("the gradient differs from the complex step".into());
    }
    Ok(())
}
