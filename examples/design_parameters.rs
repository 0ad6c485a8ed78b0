//! Design variables: mass, length and stiffness of a pendulum with a spring, improved by steepest descent.
//!
//! A bob on a massless rod, pulled to a wall by a spring, is released at 45°. After one second it is to rest at a given point.
//! The start is assembled from a guess and depends on the length; the gradient includes this dependence.
//!
//! `cargo run --release --example design_parameters`

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Start, Sum};
use nalgebra::{DVector, Vector2};
use std::error::Error;

const NAMES: [&str; 3] = ["mass", "length", "stiffness"];
const FIRST: [f64; 3] = [2.0, 1.0, 15.0];

/// S = ½ |r − r_end|² + ½ |0.3 s · ṙ|², b = r_end.
struct AtRest;

impl Cost<2, 0, 0, 2> for AtRest {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, b: &Vector2<S>) -> S {
        let (miss, speed) = (at.q - b, at.v * S::from(0.3));
        (miss.dot(&miss) + speed.dot(&speed)) * 0.5
    }
}

fn pendulum() -> Scene {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [mass, length, stiffness] = std::array::from_fn(|p| scene.design(NAMES[p], FIRST[p]));
    let bob = scene.body("bob", mass, 0.01, [1.0, -1.0, 0.0]); // the assembly moves it closer
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), length);
    scene.spring_damper("spring", Body::GROUND.at(-1.0, -1.0), bob.at(0.0, 0.0), stiffness, 0.5, 4.0);
    let [x, y, _] = bob.coordinates;
    scene.cost("at rest", AtRest, Sum::Terminal, [x, y], [], [], [(-0.1).into(), (-0.8).into()]);
    scene
}

/// J and its derivatives with respect to the design.
fn value_and_gradient(solver: &mut Solver, inputs: &Inputs) -> Result<(f64, DVector<f64>), Box<dyn Error>> {
    solver.simulate(inputs)?;
    let gradient = solver.gradient()?;
    Ok((gradient.value, gradient.design.clone()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = pendulum().compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(200, 0.005));
    inputs.start = Start::assembled(&system);
    let mut solver = Solver::new(&system, Settings::default());
    let mut design = FIRST;
    let (mut cost, mut gradient) = value_and_gradient(&mut solver, &inputs)?;
    let all: Vec<Input> = (0..3).map(Input::Design).collect();
    for (p, reference) in complex_step(&system, &inputs, Settings::default(), &all)?.into_iter().enumerate() {
        println!("dJ/d({}) = {:+.12e}, by complex step {reference:+.12e}", NAMES[p], gradient[p]);
        assert!((gradient[p] - reference).abs() <= 1e-11 * gradient.amax(), "the derivatives differ");
    }

    // Steepest descent in the logarithms of the design (d/d(ln b) = b d/db); the step is halved until the cost decreases.
    let first = cost;
    for iteration in 0..=12 {
        println!("{iteration:2}  J = {cost:.8}  {:.4} kg, {:.4} m, {:.4} N/m", design[0], design[1], design[2]);
        let mut step = 4.0;
        while step > 1e-6 {
            let next: [f64; 3] = std::array::from_fn(|p| design[p] * (-step * design[p] * gradient[p]).exp());
            inputs.design.copy_from_slice(&next);
            let (value, slope) = value_and_gradient(&mut solver, &inputs)?;
            if value < cost {
                (design, cost, gradient) = (next, value, slope);
                break;
            }
            step *= 0.5;
        }
    }
    assert!(cost < 0.1 * first, "the design did not improve");
    Ok(())
}
