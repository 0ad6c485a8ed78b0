//! Motions that are too long to be stored: the same numbers in less memory.

mod common;

use common::assert_says;
use hamiltonian_adjoint::{Error, Grid, Inputs, LongSolver, Settings, Solver, System, scenes::CartPendulum, simulate};

fn cart(steps: usize, dt: f64) -> (System, Inputs) {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 3.0 * (i as f64 * dt).sin());
    (system, inputs)
}

/// Asserts that the gradient within so many bytes is that of the stored motion to the last bit; returns the steps computed per step.
fn assert_same(system: &System, inputs: &Inputs, settings: Settings, bytes: usize) -> f64 {
    let mut stored = Solver::new(system, settings);
    stored.simulate(inputs).expect("motion");
    let factorisations = stored.report().factorisations;
    let gradient = stored.gradient().expect("gradient").clone();
    let mut long = LongSolver::new(system, settings, bytes);
    for _ in 0..2 {
        assert!(long.gradient(inputs).expect("gradient") == &gradient, "{bytes} bytes");
    }
    assert_eq!(long.inputs().grid, stored.inputs().grid);
    assert_eq!(long.report().warnings, stored.report().warnings);
    long.report().factorisations as f64 / factorisations as f64
}

#[test]
fn the_gradient_from_checkpoints_is_the_stored_one_at_every_budget() {
    let (system, inputs) = cart(3000, 0.002);
    let mut work = Vec::new();
    for bytes in [10_000_000, 500_000, 250_000, 190_000, 180_000] {
        work.push(assert_same(&system, &inputs, Settings::default(), bytes));
    }
    println!("work of the forward sweep, in simulations: {work:.2?}");
    // Two levels of checkpoints at most cost two more simulations.
    assert!(work[0] == 1.0 && work[1] <= 2.0 && work.iter().all(|work| *work <= 3.0), "{work:?}");
}

#[test]
fn restarts_and_halved_steps_are_the_same_from_checkpoints() {
    let (system, mut inputs) = cart(600, 0.01);
    let settings = Settings { drift_bound: 1e-7, rebase_every: 7, ..Settings::default() };
    assert_same(&system, &inputs, settings, 160_000);
    // Far too long for one iteration matrix.
    inputs.grid.steps[50] = 1.0;
    inputs.grid.steps[400] = 1.0;
    let settings = Settings { max_iterations: 4, ..settings };
    assert!(!simulate(&system, &inputs, settings).expect("motion").inserted.is_empty());
    assert_same(&system, &inputs, settings, 160_000);
}

#[test]
fn every_node_is_shown_once_and_in_order() {
    let (system, inputs) = cart(500, 0.01);
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    let mut next = 0;
    LongSolver::new(&system, Settings::default(), 120_000)
        .simulate(&inputs, |state| {
            assert_eq!((state.node, state.time, state.q), (next, motion.times[next], motion.q.column(next).as_slice()));
            next += 1;
        })
        .expect("motion");
    assert_eq!(next, 501);
}

#[test]
fn too_little_memory_is_an_error_and_a_failed_run_leaves_nothing_behind() {
    let (system, mut inputs) = cart(3000, 0.002);
    let error = LongSolver::new(&system, Settings::default(), 50_000).gradient(&inputs).expect_err("too little").clone();
    let Error::Memory { given: 50_000, needed } = error else { panic!("{error:?}") };
    assert_says(&error, &["50000 bytes", &needed.to_string()]);
    assert!(LongSolver::new(&system, Settings::default(), needed).gradient(&inputs).is_ok());

    let mut long = LongSolver::new(&system, Settings { max_iterations: 1, max_halvings: 0, ..Settings::default() }, 500_000);
    inputs.controls[(0, 2000)] = 1e7;
    assert!(matches!(long.gradient(&inputs), Err(Error::Newton { .. })));
    inputs.controls.fill(0.0);
    let still = Settings { max_iterations: 1, max_halvings: 0, ..Settings::default() };
    inputs.grid.steps.truncate(100);
    inputs.controls = nalgebra::DMatrix::zeros(1, 101);
    let expected = hamiltonian_adjoint::gradient(&system, &inputs, still).map(|gradient| gradient.controls);
    assert_eq!(long.gradient(&inputs).map(|gradient| gradient.controls.clone()), expected);
}
