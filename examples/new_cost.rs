//! A cost of your own on the swing-up: effort and energy along the motion, angle and speed at its end.
//!
//!   J = ∫ ½ r u² dt + Σ_links ∫ ½ w (E − E_top)² dt + Σ_links [½ (φ − π/2)² + ½ s φ̇²] at t_f
//!
//! `cargo run --release --example new_cost`

use std::error::Error;
use std::f64::consts::FRAC_PI_2;

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::scenes::{CartPendulum, CartScene};
use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum};
use nalgebra::SVector;

/// h = ½ r u² on no coordinates and one control, b = [r].
struct Effort;

impl Cost<0, 0, 1, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, b: &SVector<S, 1>) -> S {
        b[0] * at.u[0] * at.u[0] * 0.5
    }
}

/// h = ½ w (E − E_top)²: deviation of a link's energy from that of the upright link at rest, b = [w, E_top, m, J, g].
struct EnergyError;

impl Cost<3, 0, 0, 5> for EnergyError {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, b: &SVector<S, 5>) -> S {
        let (q, v) = (at.q, at.v);
        let [w, top, m, inertia, g] = [b[0], b[1], b[2], b[3], b[4]];
        let kinetic = (m * (v[0] * v[0] + v[1] * v[1]) + inertia * v[2] * v[2]) * 0.5;
        let error = kinetic + m * g * q[1] - top;
        w * error * error * 0.5
    }
}

/// S = ½ (φ − π/2)² + ½ s φ̇², b = [s].
struct Upright;

impl Cost<1, 0, 0, 1> for Upright {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        ((at.q[0] - FRAC_PI_2).powi(2) + b[0] * at.v[0].powi(2)) * 0.5
    }
}

/// The paper's mechanism with the costs above.
fn swing_up(p: CartPendulum) -> Scene {
    let CartScene { mut scene, force, links, .. } = p.mechanism();
    for (j, link) in (1..).zip(links) {
        let [x, y, angle] = link.coordinates;
        let height = (f64::from(j) - 0.5) * p.link_length;
        let b = [1e-2, p.link_mass * p.gravity * height, p.link_mass, p.link_inertia, p.gravity].map(Into::into);
        // `Sum` states how the values at the nodes are added: here by the trapezoidal rule for ∫ h dt, or only that of the last node.
        scene.cost(&format!("energy of link {j}"), EnergyError, Sum::Trapezoidal, [x, y, angle], [], [], b);
        scene.cost(&format!("end of link {j}"), Upright, Sum::Terminal, [angle], [], [], [0.1.into()]);
    }
    scene.cost("effort", Effort, Sum::Trapezoidal, [], [], [force], [1e-3.into()]);
    scene
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = swing_up(CartPendulum::default()).compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    inputs.controls.fill(10.0);
    let settings = Settings::default();
    let mut solver = Solver::new(&system, settings);
    solver.simulate(&inputs)?;
    let gradient = solver.gradient()?.clone();
    println!("J = {:.10} at u = 10 N", gradient.value);

    let nodes: Vec<Input> = (0..=100).step_by(20).map(|node| Input::Control { channel: 0, node }).collect();
    for (input, reference) in nodes.iter().zip(complex_step(&system, &inputs, settings, &nodes)?) {
        let ours = input.in_gradient(&gradient);
        println!("dJ/d({}) = {ours:+.10e}, by complex step {reference:+.10e}", input.name(&system));
        assert!((ours - reference).abs() <= 1e-11 * gradient.controls.amax(), "the derivatives differ");
    }

    // One step of steepest descent, which reduces the linear model by 10 %: the cost must fall.
    inputs.controls -= &gradient.controls * (0.1 * gradient.value / gradient.controls.norm_squared());
    solver.simulate(&inputs)?;
    println!("J = {:.10} after one step of steepest descent", solver.cost()?);
    assert!(solver.cost()? < gradient.value, "the cost has not fallen");
    Ok(())
}
