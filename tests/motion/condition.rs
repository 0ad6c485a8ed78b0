//! Where digits are lost, the report says so: pivots by the unknown's name, the growth of the adjoint, drift by the constraint's name.

use hamiltonian_adjoint::planar::{Body, Harmonic};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Grid, Inputs, KineticEnergy, LongSolver, Param, Report, Scalar, Scene, Settings, Solver, System,
    Warning,
};
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

/// A chain of two rods, the second of another mass.
fn chain(mass: f64) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let upper = scene.body("upper", 1.0, 0.1, [0.5, 0.0, 0.0]);
    let lower = scene.body("lower", mass, 0.1 * mass, [1.5, 0.0, 0.0]);
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-0.5, 0.0));
    scene.revolute("elbow", upper.at(0.5, 0.0), lower.at(-0.5, 0.0));
    scene.compile().expect("scene")
}

fn warnings(system: &System, inputs: &Inputs) -> (f64, f64, Vec<Warning>) {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs).unwrap_or_else(|error| panic!("{error}"));
    solver.gradient().unwrap_or_else(|error| panic!("{error}"));
    let warnings = [solver.report().warnings.clone(), solver.adjoint_report().warnings.clone()].concat();
    warnings.iter().for_each(|warning| println!("{warning}"));
    (solver.report().worst_pivot, solver.adjoint_report().adjoint_growth, warnings)
}

#[test]
fn lost_digits_are_told_with_the_unknown_and_the_step() {
    for (mass, expected) in [(1.0, false), (1e4, false), (1e10, true)] {
        let system = chain(mass);
        let (pivot, _, warnings) = warnings(&system, &Inputs::at_rest(&system, Grid::uniform(20, 0.01)));
        println!("mass {mass:e}: worst pivot {pivot:.1e}");
        assert_eq!(pivot < Warning::LOST_DIGITS, expected);
        match (expected, warnings.as_slice()) {
            (false, []) => (),
            (true, [Warning::LostDigits { unknown, pivot: told, .. }]) => {
                assert!(unknown.contains("shoulder") || unknown.contains("elbow"), "{unknown}");
                assert!(*told < 1e-8 && *told >= pivot);
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_chaotic_motion_warns_of_the_growth_of_its_gradient() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let growth = |steps: usize| {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.01));
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = if i < 40 { 60.0 } else { 0.0 });
        let (_, growth, warnings) = warnings(&system, &inputs);
        println!("{steps} steps: growth {growth:.1e}");
        (growth, warnings.iter().any(|warning| matches!(warning, Warning::AdjointGrowth { .. })))
    };
    let (short, long) = (growth(100), growth(3000));
    assert!(short.0 < Warning::GROWTH && !short.1, "{short:?}");
    assert!(long.0 > Warning::GROWTH && long.1, "{long:?}");
}

#[test]
fn a_motion_that_its_steps_do_not_resolve_is_told_by_its_fastest_angle() {
    let system = chain(1.0);
    let told = |speed: f64| {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.02));
        // Both rods turn about the shoulder.
        let v = inputs.start.rate_mut();
        (v[1], v[2], v[4], v[5]) = (0.5 * speed, speed, 1.5 * speed, speed);
        let (_, _, warnings) = warnings(&system, &inputs);
        warnings.into_iter().find(|warning| matches!(warning, Warning::Unresolved { .. }))
    };
    assert_eq!(told(10.0), None);
    let Some(Warning::Unresolved { coordinate, turn, .. }) = told(100.0) else { panic!("no warning") };
    assert!(coordinate.ends_with("φ") && turn > 1.9, "{coordinate}: {turn}");
}

/// The warnings of drift.
fn drift(report: &Report) -> Option<&Warning> {
    report.warnings.iter().find(|warning| matches!(warning, Warning::Drift { .. }))
}

/// The paper's cart in units of so many metres, pushed back and forth.
fn pushed(metre: f64, steps: usize, dt: f64) -> (System, Inputs) {
    let si = CartPendulum::default();
    let cart = CartPendulum {
        cart_inertia: si.cart_inertia * metre * metre,
        link_inertia: si.link_inertia * metre * metre,
        link_length: si.link_length * metre,
        hinge_friction: si.hinge_friction * metre * metre,
        gravity: si.gravity * metre,
        ..si
    };
    let system = cart.scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = 5.0 * metre * (2.2 * t).sin());
    (system, inputs)
}

#[test]
fn positions_that_have_drifted_are_told_by_constraint_and_time() {
    let (system, inputs) = pushed(1.0, 170, 0.05);
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("motion");
    let phi = motion.phi(&system, &inputs).expect("motion");
    // The cart is hinged in its centre, links half a metre from theirs.
    let lengths = [f64::INFINITY, f64::INFINITY, 0.5, 0.5, 1.0, 1.0, 1.0, 1.0];
    let share = |node: usize| (0..8).map(|j| phi[(j, node)].abs() / lengths[j]).fold(0.0, f64::max);
    let nodes = [128, 170];
    let first = nodes.into_iter().find(|&node| share(node) > Warning::DRIFT).expect("this drifts");
    let expected = nodes.map(share).into_iter().fold(0.0, f64::max);
    let told = drift(solver.report()).expect("a warning");
    println!("{told}");
    let Warning::Drift { equation, violation, share: told, step, time } = told else { unreachable!() };
    assert_eq!((*step, *told), (first, expected));
    assert!(
        (time - 0.05 * first as f64).abs() < 1e-9
            && equation.contains("hinge")
            && nodes.iter().any(|&i| { phi.column(i).iter().any(|phi| phi.abs() == *violation) })
    );
}

#[test]
fn what_is_told_of_drift_does_not_depend_on_units_and_not_on_memory() {
    let told = |metre: f64| {
        let (system, inputs) = pushed(metre, 170, 0.05);
        let mut stored = Solver::new(&system, Settings::default());
        stored.simulate(&inputs).expect("motion");
        let mut long = LongSolver::new(&system, Settings::default(), 80_000);
        long.simulate(&inputs, |_| ()).expect("motion");
        assert_eq!(long.report().warnings, stored.report().warnings);
        long.gradient(&inputs).expect("gradient");
        assert_eq!(drift(long.report()), drift(stored.report()));
        let Some(Warning::Drift { share, step, .. }) = drift(stored.report()) else { panic!("no warning") };
        (*share, *step)
    };
    let (si, micro) = (told(1.0), told(1e-6));
    println!("share and first step: {si:?}, in units of 1e6 m {micro:?}");
    assert!((si.0 / micro.0 - 1.0).abs() < 1e-6 && si.1 == micro.1);
}

#[test]
fn no_drift_is_told_of_the_papers_example_nor_where_positions_are_projected_or_may_be_wrong() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    inputs.controls.fill(10.0);
    let (pushed, shaken) = pushed(1.0, 400, 0.05);
    let of = |system: &System, inputs: &Inputs, settings: Settings| {
        let mut solver = Solver::new(system, settings);
        solver.simulate(inputs).expect("motion");
        drift(solver.report()).cloned()
    };
    assert_eq!(of(&system, &inputs, Settings::default()), None);
    assert!(of(&pushed, &shaken, Settings::default()).is_some());
    assert_eq!(of(&pushed, &shaken, Settings { drift_bound: 1e-4, ..Settings::default() }), None);
    assert_eq!(of(&pushed, &shaken, Settings { position_tolerance: f64::INFINITY, ..Settings::default() }), None);
}

/// A particle of 1 kg.
struct Particle;

impl KineticEnergy<2> for Particle {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 2>, v: &SVector<S, 2>, _: &SVector<S, 0>) -> S {
        (v[0] * v[0] + v[1] * v[1]) * 0.5
    }
}

/// Φ = x⁴ + y⁴ − 1; the trapezoidal rule keeps a circle.
struct Oval;

impl Constraint<2, 1> for Oval {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        SVector::from([q[0].powi(4) + q[1].powi(4) - 1.0])
    }
}

/// Φ = x − t² (1 − t).
struct Shaker;

impl Constraint<2, 1> for Shaker {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] - t * t * (-t + 1.0)])
    }
}

/// Φ = x − sin t.
struct Swing;

impl Constraint<2, 1> for Swing {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] - t.sin()])
    }
}

/// Φ = x − sin t − 2 exp(−t/10): what reaches far at first.
struct Settling;

impl Constraint<2, 1> for Settling {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] - t.sin() - (-t * 0.1).exp() * 2.0])
    }
}

/// Φ = x − ln(1 − 3 t), of which dΦ/dt goes on behind the pole.
struct Pole;

impl Constraint<2, 1> for Pole {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] - (-t * 3.0 + 1.0).ln()])
    }
}

/// The warning of drift for a particle that starts at the origin with a speed along x.
fn drift_along_x(constraint: impl Constraint<2, 1>, speed: f64, grid: Grid) -> Option<Warning> {
    let mut scene = Scene::new();
    let q = scene.coordinates("particle", ["x", "y"]);
    scene.kinetic_energy("particle", Particle, q, []);
    scene.constraint("slot", constraint, q, []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, grid);
    inputs.start.rate_mut()[0] = speed;
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("motion");
    println!("{:?}", solver.report().warnings);
    drift(solver.report()).cloned()
}

#[test]
fn a_drift_that_becomes_less_is_told_as_it_was() {
    // By quadrature of the cosine in steps of 0.8 |Φ| = 0.8²/12 |sin t| at most: 0.05 at node 128, less than 0.02 at the last.
    let told = drift_along_x(Swing, 1.0, Grid::uniform(130, 0.8));
    assert!(matches!(told, Some(Warning::Drift { share: 0.04..0.06, step: 128, .. })), "{told:?}");
}

#[test]
fn a_position_that_has_no_value_is_told_as_drift() {
    let told = drift_along_x(Pole, -3.0, Grid::uniform(1, 1.0));
    assert!(matches!(told, Some(Warning::Drift { violation: f64::INFINITY, share: f64::INFINITY, .. })), "{told:?}");
}

#[test]
fn drift_from_constraints_of_ones_own_does_not_depend_on_memory() {
    let mut scene = Scene::new();
    let q = scene.coordinates("particle", ["x", "y"]);
    scene.kinetic_energy("particle", Particle, q, []);
    scene.constraint("slot", Settling, q, []);
    scene.place(q[0], 2.0);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(2000, 0.8));
    inputs.start.rate_mut()[0] = 0.8;
    for settings in [Settings::default(), Settings { drift_bound: 3e-3, ..Settings::default() }] {
        let mut stored = Solver::new(&system, settings);
        let motion = stored.simulate(&inputs).expect("motion").clone();
        let mut long = LongSolver::new(&system, settings, 90_000);
        let mut is_same = true;
        long.simulate(&inputs, |state| is_same &= *state.q == *motion.q.column(state.node).as_slice()).expect("motion");
        assert!(is_same);
        assert_eq!(long.report().warnings, stored.report().warnings);
        assert_eq!(drift(stored.report()).is_some(), settings.drift_bound > 1.0);
        assert!(long.gradient(&inputs).expect("gradient") == stored.gradient().expect("gradient"));
        assert_eq!(drift(long.report()), drift(stored.report()));
    }
}

#[test]
fn drift_from_constraints_of_ones_own_is_relative_to_their_terms() {
    let told = |constrain: &dyn Fn(&mut Scene, [Coordinate; 2]), (q, v): ([f64; 2], [f64; 2]), dt: f64| {
        let mut scene = Scene::new();
        let coordinates = scene.coordinates("particle", ["x", "y"]);
        scene.kinetic_energy("particle", Particle, coordinates, []);
        constrain(&mut scene, coordinates);
        coordinates.into_iter().zip(q).for_each(|(coordinate, q)| scene.place(coordinate, q));
        let system = scene.compile().expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform((1.0 / dt).round() as usize, dt));
        inputs.start.rate_mut().copy_from_slice(&v);
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&inputs).expect("motion").clone();
        let phi = motion.phi(&system, solver.inputs()).expect("motion");
        let last = motion.q.column(motion.q.ncols() - 1).transpose();
        println!("Δt {dt} s: |Φ| {:.1e} in all, {:.1e} at the end, {last}", phi.amax(), phi[phi.len() - 1].abs());
        drift(solver.report()).cloned()
    };
    let oval = |scene: &mut Scene, q| _ = scene.constraint("oval", Oval, q, []);
    let shaker = |scene: &mut Scene, q| _ = scene.constraint("shaker", Shaker, q, []);
    let around = ([1.0, 0.0], [0.0, 3.0]);
    assert_eq!(told(&oval, around, 0.01), None);
    assert!(matches!(told(&oval, around, 0.2), Some(Warning::Drift { equation, .. }) if equation.contains("oval")));
    // At the end it is back at x = 0, where any violation is large beside x.
    assert_eq!(told(&shaker, ([0.0, 0.0], [0.0, 1.0]), 0.01), None);
}

#[test]
fn drift_of_an_angle_is_relative_to_a_radian() {
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    let constants = [-0.01, 0.01, 3.0, FRAC_PI_2].map(Param::from);
    scene.driven_angle("drive", Body::GROUND, rod, Harmonic, constants);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.4));
    let mut solver = Solver::new(&system, Settings::default());
    let phi = solver.simulate(&inputs).expect("motion").phi(&system, &inputs).expect("motion");
    // A tenth of how far it turns.
    println!("{:.1e}", phi[(2, 3)]);
    assert!(phi[(2, 3)].abs() > 1e-3 && drift(solver.report()).is_none(), "{:?}", solver.report());
}
