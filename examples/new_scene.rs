//! A mechanism of your own, with a loop: a slider-crank with a spring and a motor.
//!
//! The crank turns about the origin, the rod joins it to a slider on the x axis, a spring pulls the slider to the wall, and the
//! control is the motor torque on the crank. The cost consists of the final error of the slider position and the effort.
//!
//! `cargo run --release --example new_scene`

use std::error::Error;

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Animation, Cost, CostPoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum};
use nalgebra::SVector;

/// S = ½ (x − x_end)², b = [x_end].
struct Position;

impl Cost<1, 0, 0, 1> for Position {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        (at.q[0] - b[0]).powi(2) * 0.5
    }
}

/// h = ½ r u², b = [r].
struct Effort;

impl Cost<0, 0, 1, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, b: &SVector<S, 1>) -> S {
        b[0] * at.u[0] * at.u[0] * 0.5
    }
}

fn slider_crank() -> Scene {
    let (r, l) = (0.1, 0.3);
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);

    // The centres of the bodies are placed so that every joint is closed: the crank is at 60°, the rod ends on the x axis.
    let crank_angle = 60f64.to_radians();
    let (x, y) = (r * crank_angle.cos(), r * crank_angle.sin());
    let rod_angle = -(y / l).asin();
    let slider_x = x + l * rod_angle.cos();
    let crank = scene.body("crank", 0.5, 5e-4, [0.5 * x, 0.5 * y, crank_angle]);
    let rod = scene.body("rod", 0.3, 2.3e-3, [0.5 * (x + slider_x), 0.5 * y, rod_angle]);
    let slider = scene.body("slider", 1.0, 1e-3, [slider_x, 0.0, 0.0]);

    // Points are given in the frames of their bodies.
    let origin = Body::GROUND.at(0.0, 0.0);
    scene.revolute("main bearing", origin, crank.at(-0.5 * r, 0.0));
    scene.revolute("crank pin", crank.at(0.5 * r, 0.0), rod.at(-0.5 * l, 0.0));
    scene.revolute("slider pin", rod.at(0.5 * l, 0.0), slider.at(0.0, 0.0));
    scene.prismatic("guide", origin, 0.0, slider.at(0.0, 0.0), 0.0);

    scene.spring_damper("return spring", Body::GROUND.at(0.6, 0.0), slider.at(0.0, 0.0), 40.0, 0.2, 1.0);
    scene.joint_friction("bearing friction", Body::GROUND, crank, 0.01);
    let torque = scene.control("motor torque");
    scene.torque_actuator("motor", Body::GROUND, crank, torque);

    let [x, ..] = slider.coordinates;
    scene.cost("position", Position, Sum::Terminal, [x], [], [], [0.25.into()]);
    scene.cost("effort", Effort, Sum::Rectangle, [], [], [torque], [1e-3.into()]);
    scene
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = slider_crank().compile()?;
    let steps = 200;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.0025));
    inputs.controls.fill(1.0);
    let settings = Settings::default();
    let mut solver = Solver::new(&system, settings);

    solver.simulate(&inputs)?;
    let motion = solver.trajectory();
    println!("  t, s    crank, °   slider, m   |Φ|, m");
    let phi = motion.phi(&system, solver.inputs())?;
    for i in (0..=steps).step_by(25) {
        let (crank, slider) = (motion.q[(2, i)].to_degrees(), motion.q[(6, i)]);
        println!("{:7.4}   {crank:8.2}   {slider:9.5}   {:.1e}", motion.times[i], phi.column(i).amax());
    }

    let page = std::env::temp_dir().join("slider-crank.html");
    Animation::new(&system, solver.inputs(), motion)?.title("Slider-crank").write_html(&page)?;
    println!("animation: {}", page.display());

    let gradient = solver.gradient()?;
    println!("J = {:.12}", gradient.value);
    let nodes = [0, 50, 100, 150, 200];
    let with = nodes.map(|node| Input::Control { channel: 0, node });
    let reference = complex_step(&system, &inputs, settings, &with)?;
    for (input, reference) in with.iter().zip(reference) {
        let ours = input.in_gradient(gradient);
        println!("dJ/d({}) = {ours:+.8e}, by complex step {reference:+.8e}", input.name(&system));
        if (ours - reference).abs() > 1e-11 * gradient.controls.amax() {
            return Err("the gradient differs from the complex step".into());
        }
    }
    Ok(())
}
