//! Dependent constraints whose positions drift apart: what follows from the others is left out, and chosen anew on the way.

use crate::common::bench::number;
use crate::common::{assert_says, largest, largest_difference, relative_error};
use crate::scenes::pantograph::{Pantograph, pantographs};
use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::planar::{Body, Motion};
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Error, Grid, Hyper, Inputs, LiftedSolver, LongSolver, Multiplier, Real, Scalar, Scene,
    Scheme, Settings, Solver, Start, Sum, System, Trajectory, Warning, simulate,
};
use nalgebra::SVector;

/// What a cost of an arm is made of.
#[derive(Clone, Copy)]
enum Measure {
    Angle,
    Acceleration,
}

impl Cost<1, 0, 1> for Measure {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, _b: &SVector<S, 0>) -> S {
        match self {
            Measure::Angle => at.q[0].sin() + at.v[0] * at.v[0] * 0.1 + at.u[0] * at.u[0] * 0.01,
            Measure::Acceleration => at.v_dot[0] * at.v_dot[0] * 1e-2,
        }
    }
}

/// One pantograph, and its scene.
struct Model {
    scene: Scene,
    pantograph: Pantograph,
}

impl Model {
    fn new(across: bool, stiffness: f64) -> Self {
        let (scene, mut all) = pantographs(1, across, stiffness);
        Model { scene, pantograph: all.remove(0) }
    }

    fn compile(self, measure: Measure) -> System {
        self.compile_with(measure, Sum::Integral)
    }

    fn compile_with(mut self, measure: Measure, sum: Sum) -> System {
        let torque = self.scene.control_named("torque").expect("a control");
        for (name, arm) in ["upper", "lower"].into_iter().zip(self.pantograph.arms) {
            self.scene.cost(name, measure, sum, [arm.coordinates[2]], [], [torque], []);
        }
        self.scene.compile().expect("scene")
    }
}

/// A spring so soft that the rhombus passes flat positions.
const FLAT: f64 = 4.0;

/// At rest, with a torque that changes its sign.
fn inputs(system: &System, grid: Grid, torque: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = torque * (3.0 * t).cos());
    inputs
}

/// The angles of the arms at the end.
fn arms(system: &System, motion: &Trajectory) -> [f64; 2] {
    assert!(system.coordinate_name(2).contains("upper arm"), "{}", system.coordinate_name(2));
    [2, 5].map(|i| motion.q[(i, motion.computed - 1)])
}

/// The pantographs without and with the bar across: how far their arms are apart at the end, how often equations were chosen, and whether it says so.
fn compare(grid: &Grid, settings: Settings, stiffness: f64) -> (f64, usize) {
    let [free, again] = [false, true].map(|across| {
        let system = Model::new(across, stiffness).compile(Measure::Angle);
        let given = inputs(&system, grid.clone(), 4.0);
        let mut solver = Solver::new(&system, settings);
        let motion = solver.simulate(&given).expect("motion").clone();
        let warnings = solver.report().warnings.clone();
        let gradient = solver.gradient().expect("gradient").clone();
        let mut long = LongSolver::new(&system, settings, 400_000);
        let by_parts = long.gradient(&given).expect("gradient");
        assert_eq!((by_parts.value, &by_parts.controls), (gradient.value, &gradient.controls));
        assert_eq!(long.report().warnings, warnings);
        (arms(&system, &motion), motion.compliance.len(), warnings, gradient)
    });
    let choices = again.1 - 1;
    assert!(free.1 == 0 && !again.2.iter().any(|warning| matches!(warning, Warning::Braked { .. })), "{:?}", again.2);
    let left_out = again.2.iter().filter(|warning| matches!(warning, Warning::LeftOut { .. })).count();
    assert_eq!(left_out, 1);
    let error = largest_difference(&free.0, &again.0);
    let of_gradient = relative_error(again.3.controls.as_slice(), free.3.controls.as_slice());
    println!("{} steps: arms off by {error:.1e}, gradient by {of_gradient:.1e}, {choices} choices", grid.steps.len());
    (error.max(of_gradient), choices)
}

#[test]
fn a_pantograph_with_a_bar_too_many_moves_as_without_it() {
    let settings = Settings::default();
    let esdirk = Settings { scheme: Scheme::ESDIRK4, ..settings };
    let rebased = Settings { rebase_every: 4, ..settings };
    let projected = Settings { drift_bound: 0.0, ..settings };
    for (steps, settings, most) in [
        (50, settings, 3e-5),
        (200, settings, 2e-6),
        (3200, settings, 1e-8),
        (50, esdirk, 1e-8),
        (800, esdirk, 1e-11),
        (200, rebased, 2e-6),
        (200, projected, 3e-8),
        (800, projected, 2e-9),
    ] {
        let (error, choices) = compare(&Grid::uniform(steps, 0.25 / steps as f64), settings, 4.0);
        assert!(error < most && choices > 0, "{error:e}, {choices}");
    }
    let (error, choices) = compare(&Grid::composed(20, 0.0125, Composition::Suzuki4), settings, 4.0);
    assert!(error < 2e-5 && choices > 0, "{error:e}, {choices}");
}

#[test]
fn what_is_left_out_is_chosen_anew_as_the_mechanism_turns() {
    // A stiff spring keeps the rhombus open while it turns more than once.
    for (stiffness, most) in [(40.0, [2e-3, 3e-4]), (FLAT, [5e-2, 5e-2])] {
        let grids = [500, 1000].map(|steps| Grid::uniform(steps, 3.0 / steps as f64));
        let errors = grids.map(|grid| compare(&grid, Settings::default(), stiffness).0);
        assert!(errors.iter().zip(most).all(|(error, most)| *error < most), "{errors:?}");
    }
}

/// Pantographs that move alike, and have their equations chosen at the same nodes: the work is that of one, so many times.
#[test]
fn mechanisms_side_by_side_are_looked_at_together() {
    let [one, many] = [1, 12].map(|count| {
        let system = pantographs(count, true, 40.0).0.compile().expect("scene");
        let given = inputs(&system, Grid::uniform(200, 0.005), 4.0);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&given).expect("motion");
        // What the start takes is known the second time.
        let choices = solver.simulate(&given).expect("motion").compliance.len();
        let report = solver.report();
        let evaluations = report.sine_evaluations + report.element_evaluations;
        println!("{count}: {choices} choices, {} factorisations, {evaluations} evaluations", report.factorisations);
        (choices, report.factorisations, evaluations / count)
    });
    assert!(one.0 > 10 && many.0 == one.0);
    assert!(many.1 as f64 <= 1.1 * one.1 as f64 && many.2 as f64 <= 1.1 * one.2 as f64);
}

#[test]
fn the_gradient_is_exact_through_choices() {
    let system = Model::new(true, 40.0).compile(Measure::Angle);
    let esdirk = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    let projected = Settings { drift_bound: 1e-4, ..Settings::default() };
    for (what, grid, settings) in [
        ("trapezoidal rule", Grid::uniform(60, 0.02), Settings::default()),
        ("ESDIRK4", Grid::uniform(60, 0.02), esdirk),
        ("projected", Grid::uniform(60, 0.02), projected),
        ("composed", Grid::composed(12, 0.1, Composition::Suzuki4), Settings::default()),
    ] {
        let p_star = nalgebra::DVector::from_fn(system.n(), |i, _| 0.1 * number(i + 3));
        let start = Start::Momentum { q: system.initial_coordinates(), p_star };
        let given = Inputs { start, ..inputs(&system, grid, 4.0) };
        let mut solver = Solver::new(&system, settings);
        let choices = solver.simulate(&given).expect("motion").compliance.len() - 1;
        let gradient = solver.gradient().expect("gradient").clone();
        let kinds: [fn(&Input) -> bool; 3] =
            [|x| matches!(x, Input::Control { .. }), |x| matches!(x, Input::Rate(_)), |x| matches!(x, Input::Step(_))];
        let errors = kinds.map(|is_kind| {
            let all: Vec<Input> = Input::all(&given).into_iter().filter(is_kind).collect();
            let adjoint: Vec<f64> = all.iter().map(|input| input.in_gradient(&gradient)).collect();
            relative_error(&adjoint, &complex_step(&system, &given, settings, &all).expect("a complex step"))
        });
        println!("{what}: {choices} choices, adjoint against complex step: controls, p*0, steps {errors:?}");
        assert!(choices > 0 && errors.iter().all(|error| *error <= 1e-9), "{what}: {errors:?}");
        product_of_hessian(&system, &mut solver, &given, settings);
    }
}

#[test]
fn costs_at_early_nodes_know_the_choices_before_them() {
    let mut most = 0;
    for node in (4..60).step_by(3) {
        let system = Model::new(true, 12.0).compile_with(Measure::Angle, Sum::Node(node));
        let given = inputs(&system, Grid::uniform(100, 0.02), 4.0);
        let mut solver = Solver::new(&system, Settings::default());
        let choices = &solver.simulate(&given).expect("motion").compliance;
        most = most.max(choices.iter().filter(|part| part.from > node).count());
        let gradient = solver.gradient().expect("gradient").controls.clone();
        // Second derivatives want the adjoint variables of all nodes, those behind the cost included.
        solver.hessian_product(&given.no_change()).expect("a product");
        let again = &solver.gradient().expect("gradient").controls;
        let difference = largest_difference(gradient.as_slice(), again.as_slice()) / largest(gradient.as_slice());
        assert!(difference <= 1e-12, "node {node}: {difference:e}");
    }
    assert!(most > 0, "no choice behind a cost");
}

/// Asserts that dᵀ H d for controls is what hyper-dual numbers say.
fn product_of_hessian(system: &System, solver: &mut Solver, given: &Inputs, settings: Settings) {
    let mut direction = given.no_change();
    direction.controls.iter_mut().enumerate().for_each(|(i, d)| *d = number(i + 11));
    let ours = solver.hessian_product(&direction).expect("a product").controls.dot(&direction.controls);
    let mut lifted = LiftedSolver::<Hyper>::new(system, given, settings).expect("motion");
    let mut inputs = given.lift::<Hyper>();
    for (u, d) in inputs.controls.iter_mut().zip(&direction.controls) {
        u.add_to_part(1, *d);
        u.add_to_part(2, *d);
    }
    lifted.simulate(&inputs).expect("the same motion");
    let reference = lifted.cost().expect("a cost").part(3);
    println!("  dᵀ H d {ours:.6e}, by hyper-dual numbers {reference:.6e}");
    assert!((ours - reference).abs() <= 1e-7 * reference.abs());
}

#[test]
fn costs_on_accelerations_feel_no_brake() {
    let [free, again] = [false, true].map(|across| {
        let system = Model::new(across, 4.0).compile(Measure::Acceleration);
        let given = inputs(&system, Grid::uniform(200, 0.00125), 0.0);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&given).expect("motion");
        let cost = solver.cost().expect("a cost");
        let gradient = solver.gradient().expect("gradient").controls.clone();
        let all: Vec<Input> =
            Input::all(&given).into_iter().filter(|input| matches!(input, Input::Control { node: 90.., .. })).collect();
        let adjoint: Vec<f64> = all.iter().map(|input| input.in_gradient(solver.gradient().expect("gradient"))).collect();
        let reference = complex_step(&system, &given, Settings::default(), &all).expect("a complex step");
        assert!(relative_error(&adjoint, &reference) <= 1e-9);
        (cost, gradient)
    });
    let errors = [(again.0 / free.0 - 1.0).abs(), relative_error(again.1.as_slice(), free.1.as_slice())];
    println!("∫ v̇² dt and its gradient: {errors:?}");
    assert!(errors.iter().all(|error| *error <= 1e-4), "{errors:?}");
}

#[test]
fn steps_by_tolerance_choose_as_well() {
    let [free, again] = [false, true].map(|across| {
        let system = Model::new(across, 40.0).compile(Measure::Angle);
        let mut solver = Solver::new(&system, Settings::default());
        let given = solver.adapt(&inputs(&system, Grid::uniform(40, 0.05), 4.0), 1e-5).expect("a grid");
        let motion = solver.simulate(&given).expect("motion").clone();
        (arms(&system, &motion), given.grid.steps.len(), motion.compliance.len())
    });
    let error = largest_difference(&free.0, &again.0);
    println!("by tolerance: {} and {} steps, {} choices, arms off by {error:.1e}", free.1, again.1, again.2 - 1);
    assert!(error < 1e-2 && again.2 > 1 && again.1 < 2 * free.1);
}

/// A reaction.
struct Reaction;
impl Cost<0, 1, 0> for Reaction {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, _b: &SVector<S, 0>) -> S {
        at.lambda[0] * at.lambda[0] * 1e-2
    }
}

#[test]
fn costs_on_reactions_of_what_is_left_out_and_of_what_shares_with_it_are_refused() {
    let gradient = |across: bool, choose: fn(&Pantograph) -> Multiplier| {
        let mut model = Model::new(across, 40.0);
        let multiplier = choose(&model.pantograph);
        model.scene.cost("reaction", Reaction, Sum::Integral, [], [multiplier], [], []);
        let system = model.compile(Measure::Angle);
        let given = inputs(&system, Grid::uniform(200, 0.00125), 4.0);
        hamiltonian_adjoint::gradient(&system, &given, Settings::default())
    };
    let [free, again] = [false, true].map(|across| gradient(across, |of| of.foot[0]).expect("a gradient").controls);
    let error = relative_error(again.as_slice(), free.as_slice());
    println!("reaction of the foot: gradient off by {error:.1e}");
    assert!(error <= 1e-4);
    let shared: [fn(&Pantograph) -> Multiplier; 2] = [|of| of.stylus[0], |of| of.stylus[1]];
    for choose in shared {
        let error = gradient(true, choose).expect_err("a share that is not determined");
        assert!(matches!(error, Error::UndeterminedReaction { .. }), "{error:?}");
        println!("{error}");
    }
}

#[test]
fn a_motion_with_choices_goes_through_json() {
    let system = Model::new(true, 4.0).compile(Measure::Angle);
    let given = inputs(&system, Grid::uniform(50, 0.005), 0.0);
    let motion = simulate(&system, &given, Settings::default()).expect("motion");
    let from: Vec<usize> = motion.compliance.iter().map(|part| part.from).collect();
    assert!(from[0] == 0 && motion.restarted == from[1..]);
    #[cfg(feature = "files")]
    assert_eq!(Trajectory::from_json(&system, &motion.to_json(&system).expect("JSON")).expect("JSON"), motion);
    // Nor does what refused inputs leave behind know a node too many.
    #[cfg(feature = "files")]
    {
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&given).expect("motion");
        let mut bad = given.clone();
        bad.controls[(0, 3)] = f64::NAN;
        solver.simulate(&bad).expect_err("a number that is none");
        Trajectory::from_json(&system, &solver.trajectory().to_json(&system).expect("JSON")).expect("JSON");
    }
    // What is left out drifts as the others do.
    assert!(largest(motion.phi(&system, &given).expect("motion").as_slice()) <= 1e-4);
}

/// φ₀ + 2 t² + b t⁴.
struct Parting;
impl Motion<1> for Parting {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 1>) -> S {
        t * t * 2.0 + b[0] * t.powi(4) + 1.0
    }
}

#[test]
fn constraints_that_begin_to_contradict_each_other_are_refused_though_one_is_left_out() {
    let driven = |parting: f64| {
        let mut model = Model::new(true, 4.0);
        let arm = model.pantograph.arms[0];
        for (name, b) in [("drive", 0.0), ("another drive", parting)] {
            model.scene.driven_angle(name, Body::GROUND, arm, Parting, [b.into()]);
        }
        let system = model.compile(Measure::Angle);
        simulate(&system, &inputs(&system, Grid::uniform(100, 0.005), 0.0), Settings::default())
    };
    let motion = driven(0.0).expect("motion");
    assert!(motion.compliance.len() > 1);
    let stopped = driven(2e-3).expect_err("a contradiction");
    assert_says(&stopped.error, &["contradict", "`drive`", "`another drive`"]);
    assert!(matches!(stopped.error, Error::ContradictoryConstraints { time, .. } if time < 0.3), "{:?}", stopped.error);
    assert!(stopped.trajectory.compliance.len() > 1);
}
