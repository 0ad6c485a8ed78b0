//! Optimisation of motions with located events.

use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, interior_point, lbfgs, silent};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Cost, CostPoint, Error, Grid, Inputs, Scalar, Scene, Settings};
use nalgebra::SVector;

/// q − b.
struct Beyond;

impl Cost<1, 0, 0, 1> for Beyond {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] - b[0]
    }
}

#[test]
fn a_cart_is_pushed_until_it_arrives() -> Result<(), Error> {
    // min ∫ (u²/2 + 1) dt until x = 1: u = a (T − t), x(T) = a T³/(3 m), so J = 3 m²/(2 T³) + T and T⁴ = 9 m²/2.
    let mut scene = Scene::new();
    let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    scene.effort("effort", force, 0.5);
    scene.time("time", 1.0);
    let arrives = scene.event("arrives", Beyond, [cart.coordinates[0]], [], [], [1.0.into()]);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.05));
    inputs.controls.fill(1.0);
    inputs.events = vec![arrives.at(40)];
    let variables = Variables::new(&system, &inputs, vec![Free::control(force).within(-0.5, 10.0)])?;
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
    let start = problem.start();
    let exact = 18f64.powf(0.25);
    for is_newton in [true, false] {
        let options = Options::default();
        let outcome = match is_newton {
            true => interior_point(&mut problem, &start, &options, &mut silent)?,
            false => lbfgs(&mut problem, &start, &options, &mut silent)?,
        };
        println!("{:?} after {} simulations: {}", outcome.reason, outcome.evaluations, outcome.value);
        assert!(outcome.reason.is_converged(), "{:?}", outcome.reason);
        let least = 6.0 / exact.powi(3) + exact;
        assert!((outcome.value - least).abs() < 2e-3 * least, "{} for {least}", outcome.value);
    }
    Ok(())
}
