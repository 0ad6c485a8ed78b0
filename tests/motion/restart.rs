//! Restarts inside a motion: the constraints are satisfied again, σ begins anew, and the gradient stays exact.

use crate::common::bench::{Bench, Part, lively};
use crate::common::{assert_gradient_is_exact_with, assert_order, assert_says, largest};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::planar::{Body, Harmonic};
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Cx, Error, Grid, Inputs, KineticEnergy, LiftedSolver, Scalar, Scene, Scheme, Settings,
    Solver, Start, Sum, System, check, scenes::CartPendulum, simulate,
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

/// Restarted at every node, and projected at one where the drift is at the bound: where the inputs are moved, mostly at none or at another.
#[test]
fn differences_between_motions_that_are_projected_elsewhere_say_nothing() {
    let system = four_bar();
    let inputs = lively(&system, 40, 0.02);
    let rebased = Settings { rebase_every: 1, ..plain() };
    let motion = simulate(&system, &inputs, rebased).expect("motion");
    let drift = largest(motion.phi(&system, &inputs).expect("motion").as_slice());
    let settings = Settings { drift_bound: drift * (1.0 - 1e-9), ..rebased };
    check::gradient(&system, &inputs, settings).run().expect("motion").assert_passed();
    check::hessian(&system, &inputs, settings).run().expect("motion").assert_passed();
}

/// A pendulum that falls by some 20° in its first step: corrections of its positions hardly halve.
#[test]
fn a_projection_that_converges_slowly_converges() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("pin", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    let system = scene.compile().expect("scene");
    for k in 0..5 {
        let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.32 + 0.002 * f64::from(k)));
        let mut solver = Solver::new(&system, projected());
        let motion = solver.simulate(&inputs).unwrap_or_else(|error| panic!("{k}: {error}"));
        let phi = largest(motion.phi(&system, &inputs).expect("motion").as_slice());
        assert!(phi <= 1e-13, "{k}: {phi}");
    }
}

/// A crank that turns by some 20° in a step, close to where coupler and rocker stretch: the corrections of derivatives hardly halve either.
/// Returns the output as well that is the last angle of the rocker. The masses are in µg, and the first design variable is one of them.
fn stretching(rate: f64, grid: Grid) -> (System, Inputs, usize) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let density = scene.design("mass of a metre of the crank", 1e9);
    let rods = [("crank", 0.2, [0.0, 0.1, 1.6]), ("coupler", 0.6, [0.3, 0.4, 0.6]), ("rocker", 0.5, [0.7, 0.3, 1.8])];
    let [crank, coupler, rocker] = rods.map(|(name, length, place)| {
        let l = scene.design(name, length);
        let mass = if name == "crank" { l * density } else { l * 1e9 };
        (scene.body(name, mass, mass * l * l / 12.0, place), l * 0.5)
    });
    scene.revolute("A", Body::GROUND.at(0.0, 0.0), crank.0.at(-crank.1, 0.0));
    scene.revolute("B", crank.0.at(crank.1, 0.0), coupler.0.at(-coupler.1, 0.0));
    scene.revolute("C", coupler.0.at(coupler.1, 0.0), rocker.0.at(rocker.1, 0.0));
    scene.revolute("D", Body::GROUND.at(0.8, 0.0), rocker.0.at(-rocker.1, 0.0));
    let end = scene.end_state(rocker.0.coordinates[2]).position.index();
    let system = scene.compile().expect("scene");
    let angle = crank.0.coordinates[2];
    let mut inputs = Inputs::at_rest(&system, grid);
    inputs.start = Start::assembled(&system).hold(&[angle]);
    inputs.start.set_rate(angle, rate);
    (system, inputs, end)
}

fn bounded() -> Settings {
    Settings { scheme: Scheme::ESDIRK3, drift_bound: 1e-6, ..plain() }
}

#[test]
fn derivatives_through_projections_that_converge_slowly_are_exact() {
    let (system, inputs, end) = stretching(7.0, Grid::uniform(8, 0.04));
    let mut solver = Solver::new(&system, bounded());
    let mut at = |length: f64| {
        let mut inputs = inputs.clone();
        inputs.design[1] = length;
        solver.simulate(&inputs).expect("motion");
        let mut along = inputs.no_change();
        along.design[1] = 1.0;
        let change = solver.push_forward(&along).expect("change")[end];
        [solver.outputs().expect("outputs")[end], solver.jacobian().expect("gradients")[end].design[1], change]
    };
    let step = 1e-5;
    let expected = (at(0.2 + step)[0] - at(0.2 - step)[0]) / (2.0 * step);
    let [_, adjoint, tangent] = at(0.2);
    println!("{adjoint} by the adjoint, {tangent} by the tangent, {expected} by differences");
    assert!((adjoint - tangent).abs() < 1e-10 && (adjoint - expected).abs() < 1e-5);
}

#[test]
fn all_derivatives_through_projections_that_converge_slowly_agree() {
    // The second motion is halved, and its corrections shrink by a third only.
    for (rate, steps, dt) in [(7.0, 8, 0.04), (17.0, 2, 0.1025)] {
        let (system, inputs, end) = stretching(rate, Grid::uniform(steps, dt));
        let mut solver = Solver::new(&system, bounded());
        solver.simulate(&inputs).expect("motion");
        let adjoint = solver.jacobian().expect("gradients").swap_remove(end).design;
        let mut lifted = LiftedSolver::new(&system, &inputs, bounded()).expect("motion");
        let errors = [0, 1].map(|which| {
            let (mut along, mut perturbed) = (inputs.no_change(), inputs.lift::<Cx>());
            along.design[which] = 1.0;
            perturbed.design[which] = Cx::new(inputs.design[which], 1e-30);
            lifted.simulate(&perturbed).expect("a complex step");
            let complex = lifted.outputs().expect("outputs")[end].0.im / 1e-30;
            [adjoint[which], solver.push_forward(&along).expect("change")[end]].map(|ours| ours / complex - 1.0)
        });
        println!("{rate} rad/s: relative errors {errors:?} of adjoint and tangent, by a mass and a length");
        assert!(errors.as_flattened().iter().all(|error| error.abs() < 1e-9));
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

    // Nor on its design variables, which are lengths in Φ.
    let system = four_bar();
    let inputs = lively(&system, 14, 0.02);
    let mut other = inputs.clone();
    other.design *= 1.01;
    // A start that the other lengths do not allow is put right after a step.
    let mut solver = Solver::new(&system, Settings { position_tolerance: 1.0, velocity_tolerance: 1.0, ..projected() });
    let before = solver.simulate(&inputs).expect("motion").clone();
    assert!(solver.simulate(&other).expect("motion") != &before);
    let phi = solver.trajectory().phi(&system, &other).expect("motion");
    assert!(phi.column(0).amax() > 1e-3 && phi.columns(1, 13).amax() < 1e-13, "{phi}");
    assert_eq!(solver.simulate(&inputs).expect("motion"), &before);
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
        assert!(matches!(error, Error::Projection { step: 1, correction: 1e-2.., .. }), "{error:?}");
        assert_says(&error, &["step 1", "projected onto Φ = 0", "drift_bound"]);
    }
}

#[test]
fn the_papers_system_knows_no_restarts() {
    let system = four_bar();
    let inputs = lively(&system, 10, 0.02);
    let mut solver = Solver::new(&system, rebased());
    let motion = solver.simulate(&inputs).expect("motion");
    let error = PaperSystem::new(&system, &inputs, motion).expect_err("restarts");
    assert!(matches!(error, Error::Restarted { node: 3, .. }), "{error:?}");
    assert_says(&error, &["node 3", "rebase_every"]);
}

#[test]
fn a_check_of_the_gradient_knows_that_restarts_begin_with_the_multipliers_before() {
    for (name, system) in [("four-bar", four_bar()), ("driven", driven())] {
        let inputs = lively(&system, 14, 0.02);
        // Which nodes reach a bound that is not zero may change with the inputs, and J jumps there.
        for settings in [projected(), rebased()] {
            let report = check::gradient(&system, &inputs, settings).run().expect("motion");
            println!("{name}: {:?}", report.identity);
            report.assert_passed();
        }
    }
}

/// ½ |v + Ω × q|², seen from a frame that turns at Ω = b.
struct Turning;
impl KineticEnergy<2, 1> for Turning {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        let (x, y) = (v[0] - b[0] * q[1], v[1] + b[0] * q[0]);
        (x * x + y * y) * 0.5
    }
}

/// x² + y² = 1.
struct Circle;
impl Constraint<2, 1> for Circle {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0] * q[0] + q[1] * q[1] - 1.0])
    }
}

/// A bead on a circle, at (1, 0).
fn bead(rate: f64) -> (System, Inputs) {
    let mut scene = Scene::new();
    let q = scene.coordinates("bead", ["x", "y"]);
    scene.place(q[0], 1.0);
    let rate = scene.design("Ω", rate);
    scene.kinetic_energy("turning", Turning, q, [rate.into()]);
    scene.constraint("circle", Circle, q, []);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    (system, inputs)
}

#[test]
fn a_bound_of_zero_projects_every_node_also_where_nothing_has_drifted() {
    let (system, inputs) = bead(0.0);
    let mut solver = Solver::new(&system, projected());
    assert_eq!(solver.simulate(&inputs).expect("at rest").restarted.len(), 10);
}

#[test]
fn a_kinetic_energy_that_is_not_quadratic_cannot_be_projected_with() {
    let (system, mut inputs) = bead(0.5);
    inputs.start.rate_mut()[1] = 1.0;
    let mut solver = Solver::new(&system, projected());
    let error = solver.simulate(&inputs).expect_err("a term linear in v").clone();
    assert!(matches!(&error, Error::LinearEnergy { coordinate, step: 1, .. } if coordinate == "bead.y"), "{error:?}");
    assert_says(&error, &["step 1", "linear in the velocities", "`bead.y`", "drift_bound"]);
    simulate(&system, &inputs, rebased()).expect("nothing is projected");
}

/// q² + ṗ* v/m + (u² + m σ_x σ_y)/m².
struct Heavy;
impl Cost<1, 2, 1, 1> for Heavy {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 2, 1>, b: &SVector<S, 1>) -> S {
        let reaction = at.sigma[0] * at.sigma[1] * b[0];
        at.q[0] * at.q[0] + at.p_star_dot[0] * at.v[0] / b[0] + (at.u[0] * at.u[0] + reaction) / (b[0] * b[0])
    }
}

/// Two rods of some 1e9 kg, the first driven.
fn heavy() -> (System, Inputs) {
    const MASS: f64 = 1e9;
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let mass = scene.design("mass", MASS);
    let first = scene.body("first", mass, 0.1 * MASS, [0.5, 0.0, 0.0]);
    let second = scene.body("second", mass * 2.0, 0.1 * MASS, [1.5, 0.0, 0.0]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), first.at(-0.5, 0.0));
    let hinge = scene.revolute("hinge", first.at(0.5, 0.0), second.at(-0.5, 0.0));
    let motion = [0.0, 0.3, 3.0, 0.0].map(Into::into);
    scene.driven_angle("drive", Body::GROUND, first, Harmonic, motion);
    let torque = scene.control("torque");
    scene.torque_actuator("motor", first, second, torque);
    scene.cost("heavy", Heavy, Sum::Rectangle, [second.coordinates[2]], hinge, [torque], [mass.into()]);
    let system = scene.compile().expect("scene");
    let grid = Grid::new(0.0, vec![0.03, -0.01, 0.05, 0.001, 0.03, 0.03]);
    let mut inputs = Inputs::at_rest(&system, grid);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = MASS * (i as f64).sin());
    for (i, v) in [(1, 0.45), (2, 0.9), (4, 0.9)] {
        inputs.start.rate_mut()[i] = v;
    }
    (system, inputs)
}

#[test]
fn the_gradient_through_projections_is_exact_in_all_units() {
    let (system, inputs) = heavy();
    let settings = Settings { drift_bound: 0.0, rebase_every: 2, ..plain() };
    assert_gradient_is_exact_with("heavy", &system, &inputs, settings);
}
