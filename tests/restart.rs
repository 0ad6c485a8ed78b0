//! Restarts inside a motion: the constraints are satisfied again, σ begins anew, and the gradient stays exact.

mod common;

use common::bench::{Bench, Part, lively};
use common::{assert_gradient_is_exact_with, assert_order, assert_says, largest};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::planar::{Body, Harmonic};
use hamiltonian_adjoint::{
    Constraint, Error, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum, System, check, scenes::CartPendulum, simulate,
};
use nalgebra::SVector;

fn plain() -> Settings {
    Settings::default()
}

/// At every node.
fn projected() -> Settings {
    Settings { drift_bound: 0.0, ..plain() }
}

fn rebased() -> Settings {
    Settings { rebase_every: 3, ..plain() }
}

fn both() -> Settings {
    Settings { drift_bound: 1e-6, rebase_every: 4, ..plain() }
}

fn four_bar() -> System {
    let mut bench = Bench::new();
    bench.four_bar();
    bench.compile(Sum::Trapezoidal)
}

/// A rod on a rod whose angle is prescribed.
fn driven() -> System {
    let mut bench = Bench::new();
    let (crank, rod) = (bench.rod([0.0, 0.0], [0.5, 0.0]), bench.rod([0.5, 0.0], [1.0, 0.3]));
    bench.hinge(Part::GROUND, crank, [0.0, 0.0]);
    bench.hinge(crank, rod, [0.5, 0.0]);
    let constants = [0.0, 0.4, 3.0, 0.0].map(|x| bench.bound(x).into());
    let sigma = bench.scene.driven_angle("prescribed", Body::GROUND, crank.body, Harmonic, constants);
    bench.multipliers.extend(sigma);
    bench.drive(crank, rod);
    bench.compile(Sum::Rectangle)
}

#[test]
fn the_gradient_through_restarts_agrees_with_complex_step() {
    for (name, system) in [("four-bar", four_bar()), ("driven", driven())] {
        let inputs = lively(&system, 14, 0.02);
        for (how, settings) in [("projected", projected()), ("rebased", rebased()), ("both", both())] {
            let mut solver = Solver::new(&system, settings);
            solver.simulate(&inputs).expect("motion");
            let restarts = solver.report().restarts;
            println!("{name}, {how}: {restarts} restarts");
            assert!(restarts >= 4 && restarts == solver.trajectory().restarted.len());
            assert_gradient_is_exact_with(&format!("{name}, {how}"), &system, &inputs, settings);
        }
    }
}

#[test]
fn a_projected_motion_satisfies_its_constraints_at_every_node() {
    for (name, system) in [("four-bar", four_bar()), ("driven", driven())] {
        let inputs = lively(&system, 200, 0.01);
        let norms = |settings| {
            let mut solver = Solver::new(&system, settings);
            let motion = solver.simulate(&inputs).expect("motion").clone();
            [motion.phi(&system, &inputs), motion.phi_dot(&system, &inputs)].map(|x| largest(x.expect("motion").as_slice()))
        };
        let (paper, projected, bounded) = (norms(plain()), norms(projected()), norms(both()));
        println!("{name}: Φ and dΦ/dt: plain {paper:?}, projected {projected:?}, bound of 1e-6 {bounded:?}");
        assert!(paper[0] > 1e-5 && projected[0] <= 1e-14 && bounded[0] <= 1e-6);
        assert!(projected[1] <= 1e-12 && bounded[1] <= 1e-12);
    }
}

#[test]
fn motions_with_restarts_are_of_order_two() {
    let system = four_bar();
    for (how, settings) in [("projected", projected()), ("rebased", rebased())] {
        let end = |steps: usize| {
            let mut inputs = lively(&system, steps, 1.0);
            inputs.grid = Grid::uniform(steps, 0.8 / steps as f64);
            inputs.controls.fill(0.3);
            let mut solver = Solver::new(&system, settings);
            solver.simulate(&inputs).expect("motion").q.column(steps).into_owned()
        };
        let exact = end(6400);
        let errors = [50, 100, 200, 400].map(|steps| (end(steps) - &exact).amax());
        assert_order(how, &errors, 2.0, 0.03);
    }
}

#[test]
fn multipliers_that_begin_anew_do_not_grow() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(4000, 0.01));
    let sigma = |settings| {
        let mut solver = Solver::new(&system, settings);
        let motion = solver.simulate(&inputs).expect("motion");
        (largest(motion.sigma.as_slice()), motion.q.columns(3900, 100).into_owned())
    };
    let ((plain, q), (rebased, same)) = (sigma(plain()), sigma(Settings { rebase_every: 10, ..plain() }));
    println!("σ up to {plain:.1}, rebased every 10 steps {rebased:.2}, q differs by {:.1e}", (&q - &same).amax());
    // Hanging at rest, the rail carries the weight for 40 s.
    assert!(plain > 400.0 && rebased < 0.01 * plain && (q - same).amax() <= 1e-9);
}

/// The paper's cart with one link, pushed at random.
fn shaken(steps: usize, dt: f64, force: f64) -> (System, Inputs) {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
    let mut random = check::Random::new(1);
    inputs.controls.iter_mut().for_each(|u| *u = random.uniform(-force, force));
    (system, inputs)
}

#[test]
fn the_middle_of_the_multipliers_does_not_wander_away_under_forces_that_change_at_random() {
    let (system, inputs) = shaken(20_000, 0.002, 50.0);
    for every in [2, 5] {
        let mut solver = Solver::new(&system, Settings { rebase_every: every, ..plain() });
        let sigma = &solver.simulate(&inputs).expect("motion").sigma;
        let [early, late] = [0, 18_000].map(|from| largest(sigma.columns(from, 2000).clone_owned().as_slice()));
        println!("rebased every {every} steps: σ up to {early:.2} early, {late:.2} late");
        assert!(late <= 1.5 * early, "every {every}: {early} {late}");
    }
}

#[test]
fn a_motion_does_not_depend_on_the_one_before() {
    let (system, inputs) = shaken(200, 0.01, 50.0);
    let mut wild = inputs.clone();
    wild.controls *= 100.0;
    let mut solver = Solver::new(&system, rebased());
    solver.simulate(&wild).expect("motion");
    let again = solver.simulate(&inputs).expect("motion");
    assert_eq!(again, &simulate(&system, &inputs, rebased()).expect("motion"));
}

/// Φ = x⁴ + y⁴ − 1.
struct Oval;
impl Constraint<2, 1> for Oval {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        SVector::from([q[0].powi(4) + q[1].powi(4) - 1.0])
    }
}

#[test]
fn a_projection_that_does_not_converge_is_an_error() {
    let mut scene = Scene::new();
    let body = scene.body("body", 1.0, 0.1, [1.0, 0.0, 0.0]);
    scene.constraint("oval", Oval, [body.coordinates[0], body.coordinates[1]], []);
    let system = scene.compile().expect("scene");
    for dt in [0.3, 0.5] {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, dt));
        inputs.start.rate_mut()[1] = 3.0;
        assert!(simulate(&system, &inputs, plain()).is_ok());
        let error = simulate(&system, &inputs, projected()).expect_err("far away").error;
        assert!(matches!(error, Error::Newton { step: 1, residual: 1e-2.., .. }), "{error:?}");
        assert_says(&error, &["step 1", "the projection onto Φ = 0"]);
    }
}

#[test]
fn the_papers_system_knows_no_restarts() {
    let system = four_bar();
    let inputs = lively(&system, 10, 0.02);
    let mut solver = Solver::new(&system, rebased());
    let motion = solver.simulate(&inputs).expect("motion");
    let error = PaperSystem::new(&system, &inputs, motion).err().expect("restarts");
    assert!(matches!(error, Error::Restarted { node: 3, .. }), "{error:?}");
    assert_says(&error, &["node 3", "rebase_every"]);
}
