//! A thousand links: the gradient is as exact as for three.

use crate::common::bench::number;
use crate::common::relative_error;
use hamiltonian_adjoint::check::{Input, complex_step, tangent};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Cx, Grid, Inputs, LiftedSolver, Settings, Start, System, gradient, simulate};
use nalgebra::DVector;

const LINKS: usize = 1000;
const STEPS: usize = 20;

/// The chain in motion: momenta of a motion that began at rest, and a control that pulls on.
fn in_motion(system: &System) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(STEPS, 0.002));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 20.0 + 10.0 * number(i));
    let motion = simulate(system, &inputs, Settings::default()).expect("a motion");
    let p_star = motion.p_star.column(STEPS).into_owned();
    Inputs { start: Start::Momentum { q: system.initial_coordinates(), p_star }, ..inputs }
}

/// dJ along a direction in all controls, in p*₀ and in all step lengths, by one complex step.
fn along(system: &System, inputs: &Inputs, (u, p_star, steps): (&[f64], &DVector<f64>, &[f64])) -> f64 {
    const H: f64 = 1e-30;
    let mut perturbed = inputs.lift::<Cx>();
    let change = |x: &mut Cx, by: f64| *x += Cx::new(0.0, H * by);
    perturbed.controls.iter_mut().zip(u).for_each(|(x, &by)| change(x, by));
    perturbed.start.rate_mut().iter_mut().zip(p_star).for_each(|(x, &by)| change(x, by));
    perturbed.grid.steps.iter_mut().zip(steps).for_each(|(x, &by)| change(x, by));
    let mut solver = LiftedSolver::new(system, inputs, Settings::default()).expect("a motion");
    solver.simulate(&perturbed).expect("a motion");
    solver.cost().expect("a cost").0.im / H
}

#[test]
fn the_gradient_of_a_thousand_links_agrees_with_complex_step_and_tangents() {
    let system = CartPendulum::with_links(LINKS).scene().compile().expect("a scene");
    let inputs = in_motion(&system);
    let gradient = gradient(&system, &inputs, Settings::default()).expect("a gradient");

    let controls = [0, 7, 18, STEPS].map(|node| Input::Control { channel: 0, node });
    let ours = controls.map(|input| input.in_gradient(&gradient));
    let by_complex_step = complex_step(&system, &inputs, Settings::default(), &controls).expect("a motion");
    let by_tangents = tangent(&system, &inputs, Settings::default(), &controls[..2]).expect("a motion");
    let errors = [relative_error(&ours, &by_complex_step), relative_error(&ours[..2], &by_tangents)];
    println!("dJ/du at four nodes {ours:.6?}: relative errors {errors:?}");
    assert!(errors.iter().all(|&error| error <= 1e-11), "{errors:?}");

    let u: Vec<f64> = (0..=STEPS).map(number).collect();
    let (p_star, dt) = (DVector::from_fn(system.n(), |i, _| 1e-3 * number(i + 5)), [1e-3; STEPS]);
    let directions = [
        (&u[..], &(&p_star * 0.0), &[0.0; STEPS][..]),
        (&[0.0; STEPS + 1], &p_star, &[0.0; STEPS]),
        (&[0.0; STEPS + 1], &(&p_star * 0.0), &dt),
    ];
    for (what, direction) in ["all controls", "all momenta", "all step lengths"].into_iter().zip(directions) {
        let (u, p_star, steps) = direction;
        let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
        let ours = dot(gradient.controls.as_slice(), u)
            + dot(gradient.start.rate().as_slice(), p_star.as_slice())
            + dot(&gradient.steps, steps);
        let error = relative_error(&[ours], &[along(&system, &inputs, direction)]);
        println!("along {what}: {ours:.6e}, relative error {error:.1e}");
        assert!(error <= 1e-11, "{what}: {error:.1e}");
    }
}
