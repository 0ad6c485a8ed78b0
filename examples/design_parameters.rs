//! Design variables: mass, length and stiffness of a pendulum with a spring, improved by gradient steps.
//!
//! A bob on a massless rod, pulled by a spring to a wall, is let go at 45°. After one second it shall rest at a given point.
//! The start q₀ depends on the length too, so the total derivative is dJ/db + dJ/dq₀ · dq₀/db; one sweep gives both parts.
//!
//! `cargo run --release --example design_parameters`

use std::error::Error;
use std::f64::consts::FRAC_1_SQRT_2;

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Cost, CostPoint, Cx, Grid, Inputs, LiftedSolver, Real, Scalar, Scene, Settings, Solver, Sum, System,
};
use nalgebra::{DVector, Vector2, Vector3};

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
    let bob = scene.body("bob", mass, 0.01, [0.0; 3]);
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), length);
    scene.spring_damper("spring", Body::GROUND.at(-1.0, -1.0), bob.at(0.0, 0.0), stiffness, 0.5, 4.0);
    let [x, y, _] = bob.coordinates;
    scene.cost("at rest", AtRest, Sum::Terminal, [x, y], [], [], [(-0.1).into(), (-0.8).into()]);
    scene
}

/// Sets the design, and the start at 45° that goes with its length; on any numbers, so that the complex step sees it too.
fn set_design<R: Real>(inputs: &mut Inputs<R>, design: [R; 3]) {
    inputs.design.copy_from_slice(&design);
    let side = design[1] * FRAC_1_SQRT_2;
    *inputs.start.q_mut() = DVector::from_row_slice(&[side, -side, R::zero()]);
}

/// J and its total derivative with respect to the design.
fn value_and_gradient(solver: &mut Solver, inputs: &Inputs) -> Result<(f64, Vector3<f64>), Box<dyn Error>> {
    solver.simulate(inputs)?;
    let gradient = solver.gradient()?;
    let mut total = gradient.design.fixed_rows::<3>(0).into_owned();
    // dq₀/d(length) = (1/√2, −1/√2, 0)
    total[1] += (gradient.start.q()[0] - gradient.start.q()[1]) * FRAC_1_SQRT_2;
    Ok((gradient.value, total))
}

fn by_complex_step(system: &System, inputs: &Inputs, design: [f64; 3], p: usize) -> Result<f64, Box<dyn Error>> {
    let mut perturbed = inputs.lift::<Cx>();
    let mut b = design.map(Cx::from);
    b[p] += Cx::new(0.0, 1e-30);
    set_design(&mut perturbed, b);
    let mut solver = LiftedSolver::new(system, inputs, Settings::default())?;
    solver.simulate(&perturbed)?;
    Ok(solver.cost()?.0.im / 1e-30)
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = pendulum().compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(200, 0.005));
    let mut solver = Solver::new(&system, Settings::default());
    let mut design = FIRST;
    set_design(&mut inputs, design);
    let (mut cost, mut gradient) = value_and_gradient(&mut solver, &inputs)?;
    for p in 0..3 {
        let reference = by_complex_step(&system, &inputs, design, p)?;
        println!("dJ/d({}) = {:+.12e}, by complex step {reference:+.12e}", NAMES[p], gradient[p]);
        assert!((gradient[p] - reference).abs() <= 1e-11 * gradient.amax(), "the derivatives differ");
    }

    // Steepest descent in the logarithms of the design (d/d(ln b) = b d/db), the step halved until the cost falls.
    let first = cost;
    for iteration in 0..=12 {
        println!("{iteration:2}  J = {cost:.8}  {:.4} kg, {:.4} m, {:.4} N/m", design[0], design[1], design[2]);
        let mut step = 4.0;
        while step > 1e-6 {
            let next = std::array::from_fn(|p| design[p] * (-step * design[p] * gradient[p]).exp());
            set_design(&mut inputs, next);
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
