//! Bad inputs of a run, and runs that fail: each gives an error that names the culprit, and keeps what was computed.

use crate::common::assert_says;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy, LongSolver, Scalar,
    Scene, Settings, Solver, Start, Sum, System, scenes::CartPendulum, simulate,
};
use nalgebra::{DMatrix, DVector, SVector};

fn cart() -> (System, Inputs) {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    (system, inputs)
}

/// The error of the cart with inputs that were changed.
fn refused(change: impl FnOnce(&mut Inputs)) -> Error {
    let (system, mut inputs) = cart();
    change(&mut inputs);
    simulate(&system, &inputs, Settings::default()).expect_err("bad inputs").error
}

fn start_of(q: usize, v: usize) -> Start {
    Start::Velocity { q: DVector::zeros(q), v: DVector::zeros(v) }
}

#[test]
fn sizes_that_do_not_fit_are_refused() {
    let cases: [(Error, &'static str, usize, usize); 6] = [
        (refused(|inputs| inputs.start = start_of(5, 6)), "q0", 6, 5),
        (refused(|inputs| inputs.start = start_of(6, 7)), "v0", 6, 7),
        (refused(|inputs| inputs.start = Start::Momentum { q: DVector::zeros(6), p_star: DVector::zeros(0) }), "p*0", 6, 0),
        (refused(|inputs| inputs.controls = DMatrix::zeros(2, 11)), "controls: rows (channels)", 1, 2),
        (
            refused(|inputs| inputs.controls = DMatrix::zeros(1, 10)),
            "controls: columns (nodes, one more than steps)",
            11,
            10,
        ),
        (refused(|inputs| inputs.design = DVector::zeros(1)), "design variables", 0, 1),
    ];
    for (error, what, expected, found) in cases {
        assert_eq!(error, Error::Size { what, expected, found });
        assert_says(&error, &[what, &format!("expected {expected}"), &format!("found {found}")]);
    }
}

#[test]
fn inputs_that_are_not_finite_are_refused_by_name() {
    let cases = [
        (refused(|inputs| inputs.start.q_mut()[5] = f64::NAN), "q0 of `link 1.φ`"),
        (refused(|inputs| inputs.start.rate_mut()[0] = f64::INFINITY), "v0 of `cart.x`"),
        (refused(|inputs| inputs.controls[(0, 7)] = f64::NAN), "control `force on the cart` at node 7"),
        (refused(|inputs| inputs.grid.start = f64::NAN), "the start of the time grid"),
    ];
    for (error, name) in cases {
        assert!(matches!(&error, Error::NotFinite { what, .. } if what == name), "{error:?}");
        assert_says(&error, &[name, "must be finite"]);
    }
}

#[test]
fn steps_of_no_length_or_without_a_length_are_refused() {
    for (step, length) in [(1, 0.0), (4, f64::INFINITY)] {
        let error = refused(|inputs| inputs.grid.steps[step - 1] = length);
        assert_eq!(error, Error::TimeStep { step, length });
        assert_says(&error, &[&format!("step {step}"), "must be finite", "zero only after the first step"]);
    }
    assert!(matches!(refused(|inputs| inputs.grid.steps[9] = f64::NAN), Error::TimeStep { step: 10, .. }));
    let beyond = refused(|inputs| inputs.grid.steps.fill(1e308));
    assert_says(&beyond, &["the sum of the start time and the step lengths of the grid is inf"]);
}

/// A rod on a hinge, with its mass as a design variable.
fn rod(mass: f64) -> Result<System, Error> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let mass = scene.design("mass", mass);
    let rod = scene.body("rod", mass, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    scene.compile()
}

#[test]
fn design_variables_are_checked_before_every_run() {
    let system = rod(1.0).expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.01));
    inputs.design[0] = -2.0;
    let error = simulate(&system, &inputs, Settings::default()).expect_err("negative mass").error;
    assert_eq!(
        error,
        Error::Parameter { what: "the mass of `rod`".into(), value: -2.0, must_be: "finite and not negative" }
    );
    inputs.design[0] = f64::NAN;
    let error = simulate(&system, &inputs, Settings::default()).expect_err("no mass").error;
    assert_says(&error, &["design variable `mass` is NaN"]);
    assert!(rod(f64::NAN).is_err());
}

#[test]
fn a_design_variable_that_is_not_a_number_is_found_at_the_latest_before_a_run() {
    let mut scene = Scene::new();
    let arm = scene.design("arm", f64::NAN);
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(arm, 0.0));
    let error = match scene.compile() {
        Ok(system) => {
            simulate(&system, &Inputs::at_rest(&system, Grid::uniform(5, 0.01)), Settings::default()).unwrap_err().error
        }
        Err(error) => error,
    };
    assert_says(&error, &["design variable `arm` is NaN", "finite"]);
}

#[test]
fn initial_coordinates_off_the_constraints_are_refused() {
    let error = refused(|inputs| inputs.start.q_mut()[2] = 1e-3);
    let Error::InitialPosition { equation, violation, tolerance } = &error else { panic!("{error:?}") };
    assert_eq!(format!("{error:?}"), error.to_string(), "what a `main` that returns it prints");
    assert_eq!((equation.as_str(), *tolerance), ("`rail` (equation 1)", 1e-9));
    assert!((violation.abs() - 1e-3).abs() < 1e-15);
    assert_says(&error, &["`rail`", "1.000e-3", "correct q0"]);
}

#[test]
fn a_chain_that_is_stretched_too_far_at_first_is_no_contradiction_unless_it_is_too_short() {
    // Three bars of 1 m in a row, between points 2 m or 4 m apart.
    for (distance, words) in [(2.0, ["violate", "`end`", "correct q0"]), (4.0, ["contradict", "`end`", "remove or correct"])]
    {
        let mut scene = Scene::new();
        let bars = [0.5, 1.5, 2.5].map(|x| scene.body(&format!("bar at {x}"), 1.0, 0.1, [x, 0.0, 0.0]));
        scene.revolute("begin", Body::GROUND.at(0.0, 0.0), bars[0].at(-0.5, 0.0));
        scene.revolute("first", bars[0].at(0.5, 0.0), bars[1].at(-0.5, 0.0));
        scene.revolute("second", bars[1].at(0.5, 0.0), bars[2].at(-0.5, 0.0));
        scene.revolute("end", bars[2].at(0.5, 0.0), Body::GROUND.at(distance, 0.0));
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.01));
        let q = system.initial_coordinates();
        let p_star = DVector::zeros(q.len());
        for start in [inputs.start.clone(), Start::Momentum { q, p_star }] {
            inputs.start = start;
            assert_says(&simulate(&system, &inputs, Settings::default()).expect_err("off").error, &words);
        }
    }
}

#[test]
fn initial_velocities_off_the_constraints_are_refused() {
    let error = refused(|inputs| inputs.start.rate_mut()[3] = 0.5);
    let Error::InitialVelocity { equation, violation, .. } = &error else { panic!("{error:?}") };
    assert_eq!(equation, "`hinge 1` (equation 0)");
    assert!((violation.abs() - 0.5).abs() < 1e-15);
    assert_says(&error, &["`hinge 1`", "5.000e-1", "correct v0"]);
}

/// Drives a mass of 1 kg with v²: with the half step h there is no speed after a step unless 4 h (v₋ + h v₋²) ≤ 1.
struct Runaway;
impl KineticEnergy<1> for Runaway {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}
impl Force<1> for Runaway {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.v[0] * at.v[0]])
    }
}

/// Six steps that have a solution, and four that have none.
fn runaway() -> (System, Inputs) {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.force("drive", Runaway, q, [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    inputs.grid.steps[6..].fill(300.0);
    inputs.start.rate_mut()[0] = 1.0;
    (system, inputs)
}

#[test]
fn newton_that_does_not_converge_tells_where_and_keeps_what_was_computed() {
    let (system, mut inputs) = runaway();
    let settings = Settings { max_halvings: 0, ..Settings::default() };
    let stopped = simulate(&system, &inputs, settings).expect_err("a huge step");
    let Error::Newton { step, time, iterations, residual, equation, .. } = &stopped.error else {
        panic!("{:?}", stopped.error)
    };
    assert_eq!((*step, *iterations, equation.as_str()), (7, settings.max_iterations, "the momentum equation of `sled.x`"));
    assert!((time - 300.12).abs() < 1e-9 && *residual > 1e-3);
    assert_says(&stopped.error, &["step 7", "t = 300.12 s", "after iteration 25", "`sled.x`", "shorter steps"]);
    assert_eq!(stopped.trajectory.computed, 7);
    assert!(stopped.to_string().contains("7 nodes were computed"), "{stopped}");
    assert_eq!(format!("{stopped:?}"), stopped.to_string(), "without the motion");

    let mut solver = Solver::new(&system, settings);
    assert_eq!(solver.simulate(&inputs).err(), Some(stopped.error.clone()));
    assert_eq!(solver.trajectory().computed, 7);
    assert_eq!(solver.trajectory().q.columns(0, 7), stopped.trajectory.q.columns(0, 7));
    inputs.grid.steps.truncate(6);
    inputs.controls = DMatrix::zeros(0, 7);
    assert_eq!(solver.simulate(&inputs).expect("the part before").q, stopped.trajectory.q.columns(0, 7));
}

#[test]
fn too_few_iterations_are_reported_in_the_first_step_that_needs_more() {
    let (system, mut inputs) = cart();
    inputs.controls.fill(10.0);
    let settings = Settings { max_iterations: 1, max_halvings: 0, ..Settings::default() };
    let error = simulate(&system, &inputs, settings).expect_err("one iteration").error;
    assert!(matches!(error, Error::Newton { step: 1, iterations: 1, residual, .. } if residual > 0.0), "{error:?}");
    assert_says(&error, &["step 1", "after iteration 1", "max_iterations"]);
}

#[test]
fn a_gradient_without_a_complete_simulation_is_refused() {
    let (system, mut inputs) = runaway();
    let mut solver = Solver::new(&system, Settings { max_halvings: 0, ..Settings::default() });
    let error = solver.gradient().expect_err("nothing simulated").clone();
    assert!(matches!(error, Error::Incomplete { computed: 0, .. }), "{error:?}");
    assert_says(&error, &["no motion", "simulate"]);

    solver.simulate(&inputs).expect_err("a huge step");
    let error = solver.gradient().expect_err("half simulated").clone();
    assert_eq!(error, Error::Incomplete { expected: 11, computed: 7 });
    assert_says(&error, &["7 of the 11 nodes", "simulate to the end"]);

    inputs.grid.steps.fill(0.02);
    solver.simulate(&inputs).expect("motion");
    solver.gradient().expect("a gradient after a good motion");
    inputs.grid.steps[2] = f64::NAN;
    solver.simulate(&inputs).expect_err("a bad step");
    assert!(matches!(solver.gradient(), Err(Error::Incomplete { expected: 11, computed: 0 })));
}

#[test]
fn a_grid_without_steps_is_a_motion_of_one_node() {
    let (system, mut inputs) = cart();
    inputs.grid.steps.clear();
    inputs.controls = DMatrix::zeros(1, 1);
    let gradient = hamiltonian_adjoint::gradient(&system, &inputs, Settings::default()).expect("gradient");
    assert!((gradient.value - 0.5 * std::f64::consts::PI.powi(2)).abs() < 1e-15);
    assert!((gradient.start.q()[5] + std::f64::consts::PI).abs() < 1e-15);
}

#[test]
fn a_derivative_with_respect_to_something_that_is_not_there_is_refused() {
    use hamiltonian_adjoint::check::{Input, central_differences, complex_step};
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.01));
    for missing in [Input::Step(0), Input::Step(4), Input::Design(0), Input::Control { channel: 1, node: 0 }, Input::Rate(6)]
    {
        let by_complex_step = complex_step(&system, &inputs, Settings::default(), &[missing]);
        let by_differences = central_differences(&system, &inputs, Settings::default(), &[missing], 1e-6);
        for refused in [by_complex_step, by_differences] {
            assert!(matches!(refused, Err(Error::NoSuchInput { .. })), "{missing:?}: {refused:?}");
        }
    }
}

#[test]
fn the_cost_of_a_motion_that_failed_is_refused() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.01));
    let mut solver = Solver::new(&system, Settings { max_iterations: 1, ..Settings::default() });
    assert!(matches!(solver.cost(), Err(Error::Incomplete { .. })));
    let mut pushed = inputs.clone();
    pushed.controls.fill(1e5);
    assert!(solver.simulate(&pushed).is_err());
    assert!(matches!(solver.cost(), Err(Error::Incomplete { .. })));
}

/// h = b v with a weight near the largest number there is.
struct Heavy;
impl Cost<1, 0, 0, 1> for Heavy {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        b[0] * at.v[0]
    }
}

#[test]
fn a_gradient_that_overflows_is_an_error() {
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    // dJ/d(weight) = Σ v · 1e308 is beyond the numbers, though J is not.
    let weight = scene.design("weight", 1e-308);
    scene.cost("heavy", Heavy, Sum::Plain, [rod.coordinates[0]], [], [], [weight * 1e308]);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.1));
    inputs.start.rate_mut()[0] = 1.0;
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("motion");
    assert!(solver.cost().is_ok_and(|j| (j - 10.0).abs() < 1e-12));
    let error = solver.gradient().expect_err("a gradient beyond the numbers").clone();
    assert_says(&error, &["dJ/db", "`weight`", "inf"]);
}

#[test]
fn settings_that_no_comparison_would_heed_are_refused() {
    let (system, mut inputs) = cart();
    inputs.start.q_mut()[2] = 0.1;
    let default = Settings::default();
    let cases = [
        (Settings { tolerance: f64::NAN, ..default }, "`Settings::tolerance` is NaN"),
        (Settings { tolerance: f64::INFINITY, ..default }, "`Settings::tolerance` is inf; it must be finite"),
        (Settings { position_tolerance: f64::NAN, ..default }, "`Settings::position_tolerance` is NaN"),
        (Settings { velocity_tolerance: -1.0, ..default }, "`Settings::velocity_tolerance` is -1"),
        (Settings { drift_bound: f64::NAN, ..default }, "`Settings::drift_bound` is NaN"),
        (Settings { max_iterations: 0, ..default }, "`Settings::max_iterations` is 0; it must be 1 or more"),
    ];
    for (settings, words) in cases {
        let error = simulate(&system, &inputs, settings).expect_err("bad settings").error;
        assert!(matches!(error, Error::Parameter { .. }), "{error:?}");
        assert_says(&error, &[words]);
        assert_eq!(
            LongSolver::new(&system, settings, 1_000_000).gradient(&inputs).err().map(|e| e.to_string()),
            Some(error.to_string())
        );
    }
}

#[test]
fn any_number_of_halvings_may_be_allowed() {
    let (system, mut inputs) = runaway();
    inputs.grid.steps = vec![0.02, 0.02, 0.5, 0.15];
    inputs.controls = DMatrix::zeros(0, 5);
    let inserted = |max_halvings| {
        let settings = Settings { max_halvings, ..Settings::default() };
        simulate(&system, &inputs, settings).expect("motion").inserted
    };
    assert!(!inserted(10).is_empty());
    for most in [60, 1024, 1 << 31, usize::MAX] {
        assert_eq!(inserted(most), inserted(10), "{most}");
    }
}

/// h = √q, which has no real value behind q = 0.
struct Root;
impl Cost<1> for Root {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0].sqrt()
    }
}

#[test]
fn a_cost_that_is_no_number_is_an_error_whoever_asks_for_it() {
    use hamiltonian_adjoint::check::{self, Input};
    use hamiltonian_adjoint::paper_system::PaperSystem;
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.cost("root", Root, Sum::Plain, q, [], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
    inputs.start.q_mut()[0] = 0.15;
    inputs.start.rate_mut()[0] = -1.0;
    let settings = Settings::default();
    let mut solver = Solver::new(&system, settings);
    let motion = solver.simulate(&inputs).expect("motion").clone();
    let x = [Input::Coordinate(0)];
    let errors = [
        solver.cost().err(),
        motion.cost(&system, &inputs).err(),
        check::complex_step(&system, &inputs, settings, &x).err(),
        check::tangent(&system, &inputs, settings, &x).err(),
        check::central_differences(&system, &inputs, settings, &x, 1e-6).err(),
        check::direct_differentiation(&system, &inputs, settings, &inputs.no_change()).err(),
        PaperSystem::new(&system, &inputs, &motion).expect("complete").gradient().err(),
    ];
    for (who, error) in errors.into_iter().enumerate() {
        let Some(Error::Model { element, node: 2, .. }) = error else { panic!("{who}: {error:?}") };
        assert_eq!(element, "`root`");
    }
}

/// Q = 1/u or √u: at u = 0 the first is no number, and the second has no derivative.
struct Inverse(bool);
impl Force<1, 1> for Inverse {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([if self.0 { at.u[0].recip() } else { at.u[0].sqrt() }])
    }
}
impl Constraint<1, 1> for Root {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0].sqrt()])
    }
}

fn sled(add: impl FnOnce(&mut Scene, [Coordinate; 1])) -> Error {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.cost("square", Square, Sum::Terminal, q, [], [], []);
    add(&mut scene, q);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
    hamiltonian_adjoint::gradient(&system, &inputs, Settings::default()).expect_err("no number")
}

/// q² + q.
struct Square;
impl Cost<1> for Square {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0] * at.q[0] + at.q[0]
    }
}

#[test]
fn the_formula_that_is_no_number_at_the_start_is_named_and_not_another() {
    let by = |root| {
        sled(|scene, q| {
            let u = scene.control("u");
            scene.force("drive", Inverse(root), q, [u], []);
        })
    };
    assert!(matches!(by(true), Error::Model { element, node: 0, .. } if element == "`drive`"));
    let error = by(false);
    assert!(matches!(&error, Error::Model { element, arguments, .. } if element == "`drive`" && arguments == "`u` = 0.0"));
    assert_says(&error, &["`drive`", "not finite for `u` = 0.0", "node 4"]);
    let rate = sled(|scene, q| {
        scene.constraint("root", Root, q, []);
    });
    assert!(matches!(&rate, Error::Model { element, node: 0, .. } if element == "`root`"), "{rate:?}");
}

/// A force √q.
struct RootForce;
impl Force<1> for RootForce {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.q[0].sqrt()])
    }
}

#[test]
fn a_formula_that_a_motion_runs_out_of_is_named() {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.force("root", RootForce, q, [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    inputs.start.q_mut()[0] = 0.1;
    inputs.start.rate_mut()[0] = -1.0;
    let stopped = simulate(&system, &inputs, Settings::default()).expect_err("x < 0");
    println!("{}", stopped.error);
    assert!(matches!(&stopped.error, Error::Model { element, .. } if element == "`root`"), "{:?}", stopped.error);
    assert!(stopped.trajectory.computed > 8);
}

#[test]
fn a_direction_of_another_shape_is_refused_also_if_it_has_as_many_numbers() {
    use hamiltonian_adjoint::LiftedSolver;
    use hamiltonian_adjoint::check::direct_differentiation;
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Runaway, q, []);
    let _ = [scene.control("left"), scene.control("right")];
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(2, 0.1));
    let mut direction = inputs.no_change();
    direction.controls = DMatrix::zeros(3, 2);
    let error = direct_differentiation(&system, &inputs, Settings::default(), &direction).expect_err("3 × 2 for 2 × 3");
    assert!(matches!(error, Error::Size { expected: 2, found: 3, .. }), "{error:?}");
    let mut solver = LiftedSolver::<f64>::new(&system, &inputs, Settings::default()).expect("motion");
    let other = Inputs { controls: DMatrix::zeros(3, 2), ..inputs.clone() };
    assert!(matches!(solver.simulate(&other), Err(Error::Size { expected: 2, found: 3, .. })));

    let start = Start::Momentum { q: inputs.start.q().clone(), p_star: inputs.start.rate().clone() };
    let other = Inputs { start: start.clone(), ..inputs.clone() };
    let of_lifted = solver.simulate(&other).expect_err("momenta");
    let direction = Inputs { start, ..inputs.no_change() };
    let error = direct_differentiation(&system, &inputs, Settings::default(), &direction).expect_err("momenta");
    assert_eq!(error, of_lifted);
    assert_says(&error, &["augmented momenta", "velocities", "`Start`"]);
}

/// Q = 100 x, which drives away from the origin.
struct Unstable;
impl Force<1> for Unstable {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.q[0] * 100.0])
    }
}

#[test]
fn a_tangent_that_overflows_is_an_error_that_tells_its_node() {
    use hamiltonian_adjoint::LiftedSolver;
    use num_dual::Dual64;
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.force("drive", Unstable, q, [], []);
    let system = scene.compile().expect("scene");
    // It stays at the origin, and what begins beside it grows by 3 in a step, beyond 1e308 in 646 steps.
    let inputs = Inputs::at_rest(&system, Grid::uniform(800, 0.1));
    let mut perturbed = inputs.lift::<Dual64>();
    perturbed.start.q_mut()[0] = Dual64::new(0.0, 1.0);
    let mut solver = LiftedSolver::new(&system, &inputs, Settings::default()).expect("a motion");
    let error = solver.simulate(&perturbed).map(|_| ()).expect_err("a tangent beyond the range of numbers");
    let Error::Overflow { what, .. } = &error else { panic!("{error:?}") };
    let node: usize = what.rsplit(' ').next().and_then(|node| node.parse().ok()).expect("a node");
    assert!((630..=650).contains(&node), "{error}");
    assert_says(&error, &["dual part of the motion at node", "shorten a motion"]);
}

/// Hertz contact with the ground and weight: Q = 10⁴ max(−y, 0)^1.5 − 9.81.
struct Contact;
impl Force<1> for Contact {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([(-at.q[0]).max(S::zero()).powf(1.5) * 1e4 - 9.81])
    }
}

/// The same as an energy.
impl hamiltonian_adjoint::PotentialEnergy<1> for Contact {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> S {
        (-q[0]).max(S::zero()).powf(2.5) * 4e3 + q[0] * 9.81
    }
}

#[test]
fn a_hertz_contact_runs_from_above_and_from_the_ground_as_force_and_as_energy() {
    let run = |energy: bool, height: f64| {
        let mut scene = Scene::new();
        let y = scene.coordinates("ball", ["y"]);
        scene.kinetic_energy("mass", Runaway, y, []);
        if energy {
            scene.potential_energy("contact", Contact, y, []);
        } else {
            scene.force("contact", Contact, y, [], []);
        }
        scene.cost("square", Square, Sum::Terminal, y, [], [], []);
        let system = scene.compile().expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(400, 1e-3));
        inputs.start.q_mut()[0] = height;
        let gradient = hamiltonian_adjoint::gradient(&system, &inputs, Settings::default()).expect("a contact");
        let x = [hamiltonian_adjoint::check::Input::Coordinate(0)];
        let exact = hamiltonian_adjoint::check::complex_step(&system, &inputs, Settings::default(), &x).expect("a contact");
        assert!(
            (gradient.start.q()[0] - exact[0]).abs() <= 1e-11 * exact[0].abs().max(1.0),
            "{} {}",
            gradient.start.q()[0],
            exact[0]
        );
        gradient.value
    };
    for height in [0.05, 0.0] {
        let (force, energy) = (run(false, height), run(true, height));
        assert!((force - energy).abs() < 1e-9, "{force} {energy}");
    }
}

/// Q = −1/(1 − x): at x = 1 a wall that no step may cross.
struct Wall;
impl Force<1> for Wall {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([(-at.q[0] + 1.0).ln() * 0.1])
    }
}

#[test]
fn what_is_not_finite_inside_the_iteration_is_blamed_on_an_element_and_its_argument() {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.force("wall", Wall, q, [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    inputs.start.rate_mut()[0] = 20.0;
    let error = simulate(&system, &inputs, Settings::default()).expect_err("x > 1").error;
    let Error::Model { element, arguments, .. } = &error else { panic!("{error}") };
    assert!(element == "`wall`" && arguments.contains("`sled.x` = "), "{error}");
    assert!(!error.to_string().contains("shorter"), "{error}");
}
