//! Chains that are cut into pieces.

use hamiltonian_adjoint::spatial::Body;
use hamiltonian_adjoint::{Error, Grid, Inputs, Mechanics, Scene, Settings, Solver, Start, System};

use crate::common::{assert_gradient_is_exact_with, assert_order, assert_says, largest_difference};
use crate::hinges::chain;

/// The numbers of the angles of the joints.
fn angles(system: &System) -> Vec<usize> {
    (0..system.n()).filter(|i| system.coordinate_name(*i).starts_with("hinge")).collect()
}

fn inputs(system: &System, steps: usize, dt: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, dt));
    inputs.controls.iter_mut().enumerate().for_each(|(k, u)| *u = 0.02 * (0.3 * k as f64).sin());
    inputs
}

/// A start with other angles and rates, from which the coordinates of the cuts follow.
fn moving(system: &System) -> Start {
    let mut start = Start::assembled(system);
    let all = angles(system);
    for (k, &i) in all.iter().enumerate() {
        start.q_mut()[i] += 0.05 * (k as f64).cos();
        start.rate_mut()[i] = 0.4 * (1.0 + k as f64).sin();
    }
    let held: Vec<_> = all.iter().map(|i| system.coordinate(*i)).collect();
    start.hold(&held)
}

/// The angles after 0.04 s.
fn end(system: &System, steps: usize) -> Result<Vec<f64>, Error> {
    let mut inputs = inputs(system, steps, 0.04 / steps as f64);
    inputs.controls.fill(0.02);
    inputs.start = moving(system);
    let mut solver = Solver::new(system, Settings::default());
    let motion = solver.simulate(&inputs)?;
    Ok(angles(system).into_iter().map(|i| motion.q[(i, steps)]).collect())
}

#[test]
fn a_cut_chain_moves_like_the_whole() -> Result<(), Error> {
    let [cut, whole] = [chain(9, 3, true).compile()?, chain(9, 0, true).compile()?];
    assert_eq!([cut.n(), cut.m(), whole.n(), whole.m()], [9 + 2 * 7, 2 * 7, 9, 0]);
    let accelerations = |system: &System| -> Result<Vec<f64>, Error> {
        let inputs = Inputs { start: moving(system), ..inputs(system, 1, 0.01) };
        let all = Mechanics::at_start(system, &inputs)?.accelerations()?.0;
        Ok(angles(system).into_iter().map(|i| all[i]).collect())
    };
    let (own, other) = (accelerations(&cut)?, accelerations(&whole)?);
    assert!(largest_difference(&own, &other) < 1e-10, "{own:?} {other:?}");
    let errors: Vec<f64> = [10, 20, 40, 80]
        .into_iter()
        .map(|steps| Ok(largest_difference(&end(&cut, steps)?, &end(&whole, steps)?)))
        .collect::<Result<_, Error>>()?;
    assert_order("cut and whole chain", &errors, 2.0, 0.1);
    Ok(())
}

#[test]
fn gradients_of_a_cut_chain_are_exact() -> Result<(), Error> {
    let system = chain(8, 3, true).compile()?;
    let at_rest = inputs(&system, 10, 0.01);
    assert_gradient_is_exact_with("cut chain at rest", &system, &at_rest, Settings::default());
    let moving = Inputs { start: moving(&system), ..at_rest };
    assert_gradient_is_exact_with("moving cut chain", &system, &moving, Settings::default());
    Ok(())
}

#[test]
fn a_start_that_does_not_fit_a_cut_says_what_to_do() -> Result<(), Error> {
    let system = chain(6, 3, true).compile()?;
    let mut inputs = inputs(&system, 1, 0.01);
    inputs.start.q_mut()[0] += 0.1;
    let mut solver = Solver::new(&system, Settings::default());
    let error = solver.simulate(&inputs).expect_err("the pieces do not meet");
    assert_says(&error, &["cut 2", "Start::assembled"]);
    Ok(())
}

#[test]
fn the_ground_is_not_cut() {
    let mut scene = Scene::new();
    scene.spatial().cut("cut", Body::GROUND);
    assert_says(&scene.compile().expect_err("nothing to cut"), &["cut", "ground"]);
}
