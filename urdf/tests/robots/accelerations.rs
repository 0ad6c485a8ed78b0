//! Accelerations against those of Pinocchio, which `reference/accelerations.py` has computed:
//!
//! `python3 urdf/reference/accelerations.py urdf/robots urdf/reference/values --states 4`

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{
    Coordinate, Grid, Inputs, ListCost, ListPoint, Mechanics, Scalar, Scene, Settings, Sum, System, gradient,
};
use serde_json::Value;
use urdf::{Base, Damping, Options, Robot};

use crate::state::{Compared, Failure};
use crate::text;

#[test]
fn accelerations_are_those_of_pinocchio() -> Result<(), Failure> {
    let values = [
        include_str!("../../reference/values/000-arm-fixed.json"),
        include_str!("../../reference/values/000-arm-floating.json"),
        include_str!("../../reference/values/001-linkage-fixed.json"),
        include_str!("../../reference/values/001-linkage-floating.json"),
        include_str!("../../reference/values/002-loose-fixed.json"),
        include_str!("../../reference/values/002-loose-floating.json"),
    ];
    for values in values {
        let reference: Value = serde_json::from_str(values)?;
        let file = reference["file"].as_str().ok_or("no file")?;
        let robot = Robot::from_text(text(file.trim_end_matches(".urdf")))?;
        let base = if reference["floating"] == true { Base::Floating } else { Base::Fixed };
        let compared = Compared::new(&robot, &Options { base, ..Options::default() }, &reference)?.ok_or("nothing moves")?;
        let states = reference["states"].as_array().ok_or("no states")?;
        assert_eq!(states.len(), 4);
        for state in states {
            let (difference, _) = compared.difference(state)?;
            assert!(difference < 1e-11, "{file}, {base:?} base: {difference:e}");
        }
    }
    Ok(())
}

/// ½ |q|² + ½ |v|².
struct State;

impl ListCost for State {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        at.q.iter().chain(at.v).map(|x| *x * *x * 0.5).sum()
    }
}

/// The linkage with drives, at the state q, v = (0.3, −0.5, 0.2).
fn driven(damping: Damping) -> Result<(System, Inputs), Failure> {
    let mut scene = Scene::new();
    scene.spatial().gravity([0.0, 0.0, -9.81]);
    let added = Robot::from_text(text("linkage"))?.add_to(&mut scene, &Options { damping, ..Options::default() })?;
    added.drive(&mut scene);
    let q: Vec<Coordinate> = added.drivable().map(|(_, coordinate)| coordinate).collect();
    scene.list_cost("state", State, Sum::Terminal, &q, &[], &[], &[]);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.01));
    inputs.start.rate_mut().copy_from_slice(&[0.3, -0.5, 0.2]);
    inputs.controls.column_iter_mut().enumerate().for_each(|(i, mut u)| u.fill(2.0 - 0.3 * i as f64));
    Ok((system, inputs))
}

#[test]
fn damping_is_a_force_against_the_velocities() -> Result<(), Failure> {
    let ((damped, inputs), (free, mut other)) = (driven(Damping::File)?, driven(Damping::None)?);
    let own = Mechanics::at_start(&damped, &inputs)?.accelerations()?.0;
    // The belt turns −2.5 times as fast as the elbow.
    let damping = [0.7, 0.4 + 0.01 * 2.5 * 2.5, 0.0];
    for (i, (damping, v)) in damping.iter().zip([0.3, -0.5, 0.2]).enumerate() {
        other.controls[(i, 0)] -= damping * v;
    }
    let expected = Mechanics::at_start(&free, &other)?.accelerations()?.0;
    assert!((&own - &expected).amax() < 1e-12 * expected.amax(), "{own} {expected}");
    Ok(())
}

#[test]
fn gradients_are_exact_with_damping_and_torques() -> Result<(), Failure> {
    let (system, inputs) = driven(Damping::File)?;
    let all = Input::all(&inputs);
    let exact = gradient(&system, &inputs, Settings::default())?;
    let reference = complex_step(&system, &inputs, Settings::default(), &all)?;
    let largest = reference.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    for (input, reference) in all.into_iter().zip(reference) {
        let difference = (input.in_gradient(&exact) - reference).abs();
        assert!(difference < 1e-12 * largest, "{}: {difference:e}", input.name(&system));
    }
    Ok(())
}
