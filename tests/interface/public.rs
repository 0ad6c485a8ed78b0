//! Every public function that takes an index, a size, a handle or somebody's matrix, given one that does not fit: an error that names
//! it, an answer, or a panic that its documentation tells of.

use std::panic::{AssertUnwindSafe, catch_unwind};

use hamiltonian_adjoint::check::{self, Input, Part};
use hamiltonian_adjoint::optimize::{MotionProblem, MultipleShooting, Trials};
use hamiltonian_adjoint::paper_system::{Equation, PaperSystem, Variable};
use hamiltonian_adjoint::planar::{Body, Frame};
use hamiltonian_adjoint::scenes::{CartPendulum, CartScene};
use hamiltonian_adjoint::{
    Compliance, Composition, Control, Coordinate, Cx, Design, Error, Grid, Inputs, KineticEnergy, LiftedSolver, LongSolver,
    Mechanics, Param, Scalar, Scene, Settings, Solver, Start, System, Trajectory, gradient, gradients, simulate,
};
use nalgebra::{DMatrix, DVector, SVector};

const FAR: [usize; 4] = [21, 1_000_000, isize::MAX as usize, usize::MAX];

fn cart() -> (System, Inputs) {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    inputs.controls.fill(1.0);
    (system, inputs)
}

fn motion(system: &System, inputs: &Inputs) -> Trajectory {
    simulate(system, inputs, Settings::default()).expect("motion")
}

/// Asserts that a function panics and that the lines above its signature in the source say so.
fn assert_panics_as_documented<T>(source: &str, signature: &str, call: impl FnOnce() -> T) {
    assert!(catch_unwind(AssertUnwindSafe(call)).is_err(), "`{signature}` does not panic");
    let (before, _) = source.split_once(signature).expect(signature);
    // The last line is the signature's own indentation.
    let mut documentation = before.lines().rev().skip(1).take_while(|line| line.trim().starts_with("///"));
    assert!(documentation.any(|line| line.contains("# Panics")), "`{signature}` does not say that it panics");
}

#[test]
fn indices_out_of_range_panic_where_the_documentation_says_so() {
    let (system, inputs) = cart();
    let names = include_str!("../../src/system/compiled.rs");
    let paper_source = include_str!("../../src/paper_system.rs");
    let input_source = include_str!("../../src/check/derivative.rs");
    let motion = motion(&system, &inputs);
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let gradient = gradient(&system, &inputs, Settings::default()).expect("gradient");
    for i in FAR {
        assert_panics_as_documented(names, "pub fn coordinate_name(", || system.coordinate_name(i).len());
        assert_panics_as_documented(names, "pub fn equation_name(", || system.equation_name(i).len());
        assert_panics_as_documented(names, "pub fn control_name(", || system.control_name(i).len());
        assert_panics_as_documented(names, "pub fn design_name(", || system.design_name(i).len());
        assert_panics_as_documented(paper_source, "pub fn y(", || paper.y(i));
        assert_panics_as_documented(paper_source, "pub fn f(", || paper.f(i));
        assert_panics_as_documented(paper_source, "pub fn f_y(", || paper.f_y(i));
        assert_panics_as_documented(paper_source, "pub fn f_y_previous(", || paper.f_y_previous(i));
        assert_panics_as_documented(paper_source, "pub fn f_u(", || paper.f_u(i));
        assert_panics_as_documented(paper_source, "pub fn f_b(", || paper.f_b(i));
        for input in no_inputs(i) {
            assert_panics_as_documented(input_source, "pub fn of<", || *input.of(&mut inputs.clone()));
            assert_panics_as_documented(input_source, "pub fn in_gradient(", || input.in_gradient(&gradient));
        }
    }
    assert_eq!(paper.f_y_previous(0).matrix.amax(), 0.0);
    let mut tangent = paper.f_y(1);
    tangent.matrix = DMatrix::zeros(3, 3);
    assert_panics_as_documented(paper_source, "pub fn block(", || tangent.block(Equation::F5, Variable::Q).sum());
}

#[test]
fn what_cannot_be_held_in_memory_panics_where_no_error_can_be_returned() {
    let (system, _) = cart();
    let (grid, composition) = (include_str!("../../src/motion/grid.rs"), include_str!("../../src/motion/composition.rs"));
    let beyond_addresses = usize::try_from(1u64 << 52).unwrap_or(usize::MAX);
    for steps in [usize::MAX, usize::MAX / 8, usize::MAX / 8 + 1, beyond_addresses] {
        assert_panics_as_documented(grid, "pub fn uniform(", || Grid::uniform(steps, 0.1));
        for kind in Composition::ALL {
            // 2⁶¹ macro steps have a number of stages that does not fit into a word: a shorter grid would be a wrong one.
            assert_panics_as_documented(composition, "pub fn composed(", || Grid::composed(steps, 0.1, kind));
        }
    }
    assert_eq!(Inputs::at_rest(&system, Grid::uniform(0, 0.1)).controls.shape(), (1, 1));
    for [first, last] in [[3, 2], [0, 21], [30, 30]] {
        assert_panics_as_documented(grid, "pub fn part(", || Grid::uniform(20, 0.1).part(first, last));
    }
}

/// Inputs that the cart with 20 steps does not have.
fn no_inputs(i: usize) -> Vec<Input> {
    vec![
        Input::Control { channel: i, node: 0 },
        Input::Control { channel: 0, node: i },
        Input::Design(i),
        Input::Coordinate(i),
        Input::Rate(i),
        Input::Step(i),
        Input::Step(0),
    ]
}

#[test]
fn inputs_that_a_motion_does_not_have_are_named_and_refused() {
    let (system, inputs) = cart();
    for input in FAR.into_iter().flat_map(no_inputs) {
        assert!(!input.name(&system).is_empty());
        let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
        let by_its_numbers = |found: Result<Vec<f64>, Error>| match found {
            Err(Error::NoSuchInput { input: name }) => digits(&name) == digits(&format!("{input:?}")),
            _ => false,
        };
        let settings = Settings::default();
        assert!(by_its_numbers(check::complex_step(&system, &inputs, settings, &[input])), "{input:?}");
        assert!(by_its_numbers(check::tangent(&system, &inputs, settings, &[input])), "{input:?}");
        assert!(by_its_numbers(check::central_differences(&system, &inputs, settings, &[input], 1e-6)), "{input:?}");
    }
    assert!(Input::Coordinate(6).name(&system).contains("another system"));
    assert_eq!(Input::Coordinate(5).name(&system), "the initial value of `link 1.φ`");
}

/// A trajectory that somebody has changed.
type Change = (&'static str, fn(&mut Trajectory));

const CHANGES: [Change; 18] = [
    ("computed", |motion| motion.computed = 1000),
    ("computed", |motion| motion.computed = usize::MAX),
    ("times", |motion| motion.times.truncate(3)),
    ("q, rows", |motion| motion.q = DMatrix::zeros(5, 21)),
    ("q, columns", |motion| motion.q = DMatrix::zeros(6, 20)),
    ("v, rows", |motion| motion.v = DMatrix::zeros(0, 21)),
    ("v, columns", |motion| motion.v = DMatrix::zeros(6, 1)),
    ("p*", |motion| motion.p_star = DMatrix::zeros(6, 0)),
    ("p*, rows", |motion| motion.p_star = DMatrix::zeros(7, 21)),
    ("ṗ*", |motion| motion.p_star_dot = DMatrix::zeros(3, 3)),
    ("σ", |motion| motion.sigma = DMatrix::zeros(1, 21)),
    ("σ, columns", |motion| motion.sigma = DMatrix::zeros(4, 2)),
    ("u", |motion| motion.u = DMatrix::zeros(1, 21)),
    ("stages, rows", |motion| motion.stages.q = DMatrix::zeros(6, 0)),
    ("stages, columns", |motion| motion.stages.u = DMatrix::zeros(0, 1)),
    ("compliance", |motion| motion.compliance.push(Compliance { from: 0, equations: vec![(usize::MAX, 1e-6)] })),
    ("restarted", |motion| motion.restarted.push(usize::MAX)),
    ("restarted", |motion| motion.restarted.push(21)),
];

#[test]
fn trajectories_that_do_not_fit_are_refused() {
    let (system, inputs) = cart();
    for (what, change) in CHANGES {
        let mut motion = motion(&system, &inputs);
        change(&mut motion);
        let errors = [
            motion.cost(&system, &inputs).err(),
            motion.phi(&system, &inputs).err(),
            motion.phi_dot(&system, &inputs).err(),
            PaperSystem::new(&system, &inputs, &motion).err(),
        ];
        for error in errors {
            let is_typed = matches!(error, Some(Error::Size { .. } | Error::Incomplete { .. }));
            assert!(is_typed, "{what}: {error:?}");
        }
    }
    // Nodes that were never inserted say nothing of sizes, and break nothing.
    for inserted in [vec![0], vec![20], vec![usize::MAX], vec![3, 2, 1], (0..21).collect()] {
        let motion = Trajectory { inserted, ..motion(&system, &inputs) };
        let _ = (motion.cost(&system, &inputs), motion.phi(&system, &inputs), motion.phi_dot(&system, &inputs));
        if let Ok(paper) = PaperSystem::new(&system, &inputs, &motion) {
            let _ = (paper.f(20), paper.gradient());
        }
    }
}

/// Inputs that do not fit, or are no numbers.
fn bad_inputs(inputs: &Inputs) -> Vec<Inputs> {
    let changes: [fn(&mut Inputs); 12] = [
        |inputs| inputs.grid.steps.truncate(5),
        |inputs| inputs.grid.steps.clear(),
        |inputs| inputs.grid.steps[3] = f64::NAN,
        |inputs| inputs.grid.start = f64::INFINITY,
        |inputs| inputs.controls = DMatrix::zeros(0, 0),
        |inputs| inputs.controls = DMatrix::zeros(2, 21),
        |inputs| inputs.controls = DMatrix::zeros(21, 1),
        |inputs| inputs.controls[(0, 20)] = f64::NAN,
        |inputs| inputs.design = DVector::zeros(3),
        |inputs| inputs.start = Start::Velocity { q: DVector::zeros(0), v: DVector::zeros(0) },
        |inputs| inputs.start = Start::Momentum { q: inputs.start.q().clone(), p_star: DVector::zeros(5) },
        |inputs| inputs.start.rate_mut()[2] = f64::NAN,
    ];
    let changed = |change: fn(&mut Inputs)| {
        let mut inputs = inputs.clone();
        change(&mut inputs);
        inputs
    };
    changes.map(changed).into()
}

#[test]
fn inputs_that_do_not_fit_are_refused_by_everything_that_takes_them() {
    let (system, inputs) = cart();
    let (motion, settings, some) = (motion(&system, &inputs), Settings::default(), [Input::Coordinate(0)]);
    let mut lifted = LiftedSolver::<Cx>::new(&system, &inputs, settings).expect("motion");
    for bad in bad_inputs(&inputs) {
        let mut solver = Solver::new(&system, settings);
        assert!(solver.simulate(&bad).is_err());
        assert!(solver.gradient().is_err() && solver.cost().is_err());
        assert!(gradients(&system, std::slice::from_ref(&bad), settings)[0].is_err());
        assert!(LiftedSolver::<Cx>::new(&system, &bad, settings).is_err());
        assert!(LongSolver::new(&system, settings, 1 << 20).gradient(&bad).is_err());
        assert!(LongSolver::new(&system, settings, 1 << 20).simulate(&bad, |_| ()).is_err());
        assert!(check::complex_step(&system, &bad, settings, &some).is_err());
        assert!(check::tangent(&system, &bad, settings, &some).is_err());
        assert!(check::central_differences(&system, &bad, settings, &some, 1e-6).is_err());
        assert!(check::gradient(&system, &bad, settings).run().is_err());
        assert!(check::direct_differentiation(&system, &bad, settings, &bad.no_change()).is_err());
        assert_eq!(bad.no_change().controls, bad.controls.map(|_| 0.0));
        let sizes = (bad.grid.steps.len(), bad.controls.shape(), bad.design.len(), bad.start.rate().len());
        if sizes != (20, (1, 21), 0, 6) {
            assert!(lifted.simulate(&bad.lift()).is_err() && lifted.cost().is_err());
            assert!(check::direct_differentiation(&system, &inputs, settings, &bad).is_err());
            let fits = motion.cost(&system, &bad).is_ok() && motion.phi(&system, &bad).is_ok();
            assert_eq!(fits, PaperSystem::new(&system, &bad, &motion).is_ok());
        } else {
            assert!(matches!(lifted.simulate(&bad.lift()), Err(Error::NotFinite { .. })) && lifted.cost().is_err());
        }
    }
    lifted.simulate(&inputs.lift()).expect("the motion itself");
}

#[test]
fn solvers_without_a_motion_say_so() {
    let (system, inputs) = cart();
    let mut solver = Solver::new(&system, Settings::default());
    let none = |error: Option<Error>| assert!(matches!(error, Some(Error::Incomplete { computed: 0, .. })), "{error:?}");
    none(solver.cost().err());
    none(solver.gradient().err());
    assert!(solver.adjoint_variables().is_none());
    assert_eq!((solver.trajectory().computed, solver.inputs().grid.nodes()), (0, 1));
    for bytes in [0, 1, usize::MAX] {
        let result = LongSolver::new(&system, Settings::default(), bytes).gradient(&inputs).map(|gradient| gradient.value);
        assert_eq!(result.is_ok(), bytes == usize::MAX, "{result:?}");
    }
    let nothing = Inputs::at_rest(&system, Grid::uniform(0, 0.1));
    assert!(gradient(&system, &nothing, Settings::default()).is_ok());
    assert!(LongSolver::new(&system, Settings::default(), 1 << 20).gradient(&nothing).is_ok());
    let paper = motion(&system, &nothing);
    assert!(PaperSystem::new(&system, &nothing, &paper).expect("a start").gradient().is_ok());
}

/// ½ v².
struct Unit;

impl KineticEnergy<1> for Unit {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

/// 10⁷ nodes of 2,000 coordinates would take 640 GB.
#[test]
fn a_motion_that_no_memory_can_hold_is_refused_before_it_is_allocated() {
    // Where the system promises memory that it does not have, nothing can be known.
    if std::fs::read_to_string("/proc/sys/vm/overcommit_memory").is_ok_and(|mode| mode.trim() == "1") {
        return;
    }
    let mut scene = Scene::new();
    for i in 0..2000 {
        let [q] = scene.coordinates(&format!("mass {i}"), ["x"]);
        scene.kinetic_energy(&format!("T {i}"), Unit, [q], []);
    }
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(10_000_000, 1e-3));
    let error = simulate(&system, &inputs, Settings::default()).expect_err("too much").error;
    let Error::OutOfMemory { what: "the motion", bytes } = error else { panic!("{error}") };
    // As many as a number of 32 bits can tell.
    assert!(bytes as u64 > 600_000_000_000.min(usize::MAX as u64 - 1), "{bytes}");
    let words = Error::OutOfMemory { what: "the motion", bytes }.to_string();
    assert!(words.contains("fewer steps") && words.contains("LongSolver"), "{words}");
}

#[test]
fn ready_scenes_of_absurd_sizes_are_refused() {
    let usual = CartPendulum::default();
    let far = usize::MAX;
    let cases = [
        CartPendulum { links: 0, ..usual },
        CartPendulum { links: far, ..usual },
        CartPendulum { links: 1_000_000_000, ..usual },
        CartPendulum { friction_joint: far, ..usual },
        CartPendulum { friction_joint: 3, ..usual },
        CartPendulum { links: far, friction_joint: far, ..usual },
        CartPendulum { cart_mass: f64::NAN, ..usual },
        CartPendulum { link_mass: -1.0, ..usual },
        CartPendulum { link_inertia: f64::INFINITY, ..usual },
        CartPendulum { link_length: f64::NAN, ..usual },
        CartPendulum { gravity: f64::NAN, ..usual },
        CartPendulum { hinge_friction: f64::NAN, ..usual },
        CartPendulum { target_angle: f64::INFINITY, ..usual },
    ];
    for case in cases {
        let error = case.scene().compile().expect_err("absurd");
        assert!(matches!(error, Error::Parameter { .. } | Error::NotFinite { .. }), "{error:?}");
    }
    // Where the bodies are is an input of the run.
    if let Ok(system) = (CartPendulum { start_angle: f64::NAN, ..usual }).scene().compile() {
        let inputs = Inputs::at_rest(&system, Grid::uniform(2, 0.1));
        assert!(matches!(simulate(&system, &inputs, Settings::default()).expect_err("NaN").error, Error::NotFinite { .. }));
    }
}

/// What belongs to another scene.
struct Foreign {
    body: Body,
    coordinate: Coordinate,
    control: Control,
    design: Design,
}

fn foreign() -> Foreign {
    let mut other = Scene::new();
    // With larger numbers than the scene has that they are given to.
    (0..40).for_each(|i| _ = other.coordinates(&format!("c {i}"), ["x"]));
    (0..40).for_each(|i| _ = other.control(&format!("u {i}")));
    (0..40).for_each(|i| _ = other.design(&format!("b {i}"), 1.0));
    let body = other.body("far", 1.0, 0.1, [0.0; 3]);
    Foreign { body, coordinate: body.coordinates[2], control: other.control("u"), design: other.design("b", 1.0) }
}

#[test]
fn handles_of_another_scene_are_refused_by_every_method_that_takes_one() {
    type Add = fn(&mut Scene, Body, &Foreign);
    let ground: fn() -> Frame = || Body::GROUND;
    let adders: [(&str, Add); 24] = [
        ("body", |scene, _, far| _ = scene.body("b", far.design, 1.0, [0.0; 3])),
        ("body", |scene, _, far| _ = scene.body("b", 1.0, -far.design, [0.0; 3])),
        ("gravity", |scene, _, far| scene.gravity(far.design * 2.0, 0.0)),
        ("place", |scene, _, far| scene.place(far.coordinate, 0.0)),
        ("revolute", |scene, rod, far| _ = scene.revolute("j", rod.at(0.0, 0.0), far.body.at(0.0, 0.0))),
        ("revolute", |scene, rod, far| _ = scene.revolute("j", rod.at(far.design, 0.0), Body::GROUND.at(0.0, 0.0))),
        ("prismatic", |scene, rod, far| _ = scene.prismatic("j", rod.at(0.0, 0.0), 0.0, far.body.at(0.0, 0.0), 0.0)),
        ("prismatic", |scene, rod, far| {
            _ = scene.prismatic("j", Body::GROUND.at(0.0, 0.0), far.design, rod.at(0.0, 0.0), 0.0)
        }),
        ("weld", |scene, rod, far| _ = scene.weld("j", far.body.at(0.0, 0.0), rod.at(0.0, 0.0), 0.0)),
        ("weld", |scene, rod, far| _ = scene.weld("j", Body::GROUND.at(0.0, 0.0), rod.at(0.0, 0.0), far.design)),
        ("distance", |scene, rod, far| _ = scene.distance("j", far.body.at(0.0, 0.0), rod.at(1.0, 0.0), 1.0)),
        ("distance", |scene, rod, far| _ = scene.distance("j", Body::GROUND.at(2.0, 0.0), rod.at(0.0, 0.0), far.design)),
        ("spring", |scene, rod, far| scene.spring_damper("s", far.body.at(0.0, 0.0), rod.at(1.0, 0.0), 1.0, 1.0, 1.0)),
        ("spring", |scene, rod, far| {
            scene.spring_damper("s", Body::GROUND.at(0.0, 0.0), rod.at(1.0, 0.0), far.design, 1.0, 1.0)
        }),
        ("torsion", |scene, rod, far| scene.torsional_spring_damper("s", far.body, rod, 1.0, 1.0, 1.0)),
        ("torsion", |scene, rod, far| scene.torsional_spring_damper("s", Body::GROUND, rod, 1.0, far.design, 1.0)),
        ("friction", |scene, rod, far| scene.joint_friction("f", rod, far.body, 1.0)),
        ("sliding", |scene, rod, far| scene.sliding_friction("f", rod.at(0.0, 0.0), 0.0, far.body.at(0.0, 0.0), 1.0)),
        ("actuator", |scene, rod, far| scene.actuator("a", Body::GROUND.at(0.0, 0.0), 0.0, rod.at(0.0, 0.0), far.control)),
        ("torque", |scene, rod, far| scene.torque_actuator("a", Body::GROUND, rod, far.control)),
        ("torque", |scene, rod, far| {
            let own = scene.control("own");
            scene.torque_actuator("a", far.body, rod, own);
        }),
        ("energy", |scene, _, far| scene.kinetic_energy("T", Unit, [far.coordinate], [])),
        ("cost", |scene, _, far| {
            let [target] = [Param::from(1.0)];
            let sum = hamiltonian_adjoint::Sum::Terminal;
            scene.cost("c", hamiltonian_adjoint::scenes::AngleError, sum, [far.coordinate], [], [], [target]);
        }),
        ("cost", |scene, rod, far| {
            let sum = hamiltonian_adjoint::Sum::Terminal;
            let [_, _, angle] = rod.coordinates;
            scene.cost("c", hamiltonian_adjoint::scenes::AngleError, sum, [angle], [], [], [far.design.into()]);
        }),
    ];
    assert_eq!(ground().coordinates(), None);
    for (what, add) in adders {
        let mut scene = Scene::new();
        let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
        add(&mut scene, rod, &foreign());
        let error = scene.compile().map(|_| ()).expect_err(what);
        assert!(matches!(error, Error::Foreign { .. }), "{what}: {error:?}");
    }
    // The same scene after it was taken away is another one.
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    let _ = std::mem::take(&mut scene);
    scene.place(rod.coordinates[0], 1.0);
    assert!(matches!(scene.compile(), Err(Error::Foreign { .. })));
}

#[test]
fn values_that_are_no_numbers_are_refused_when_compiled_or_simulated() {
    type Add = fn(&mut Scene, Body);
    let adders: [Add; 12] = [
        |scene, rod| scene.place(rod.coordinates[0], f64::NAN),
        |scene, _| _ = scene.design("b", f64::NAN),
        |scene, rod| {
            let far = scene.design("b", f64::INFINITY);
            scene.joint_friction("f", Body::GROUND, rod, far);
        },
        |scene, _| _ = scene.body("b", 1.0, 1.0, [f64::NAN; 3]),
        |scene, rod| _ = scene.revolute("j", rod.at(f64::NAN, 0.0), Body::GROUND.at(0.0, 0.0)),
        |scene, rod| _ = scene.weld("j", rod.at(0.0, 0.0), Body::GROUND.at(0.0, f64::INFINITY), 0.0),
        |scene, rod| _ = scene.prismatic("j", rod.at(0.0, 0.0), f64::NAN, Body::GROUND.at(0.0, 0.0), 0.0),
        |scene, rod| _ = scene.distance("j", rod.at(0.0, 0.0), Body::GROUND.at(0.0, 0.0), f64::NAN),
        |scene, rod| scene.spring_damper("s", rod.at(0.0, 0.0), Body::GROUND.at(0.0, 0.0), f64::NAN, 1.0, 1.0),
        |scene, rod| scene.torsional_spring_damper("s", rod, Body::GROUND, 1.0, f64::NAN, 1.0),
        |scene, rod| scene.sliding_friction("f", rod.at(0.0, 0.0), f64::NAN, Body::GROUND.at(0.0, 0.0), 1.0),
        |scene, _| scene.gravity(f64::NAN, 0.0),
    ];
    for (k, add) in adders.into_iter().enumerate() {
        let mut scene = Scene::new();
        let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
        add(&mut scene, rod);
        let run = |system: System| simulate(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.1)), Settings::default());
        let error = scene.compile().and_then(|system| run(system).map(|_| ()).map_err(Error::from)).expect_err("no number");
        assert!(matches!(error, Error::NotFinite { .. } | Error::Parameter { .. }), "{k}: {error:?}");
    }
}

#[test]
fn bits_and_counts_have_no_end_that_panics() {
    let rank_above_rows = Error::DependentConstraints { rank: 3, rows: 2, equations: Vec::new(), time: f64::NAN };
    assert!(rank_above_rows.to_string().contains("rank 3"));
}

/// x y.
struct Product;

impl check::Function for Product {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![x.iter().fold(S::one(), |product, &x| product * x)]
    }
}

#[test]
fn checks_of_nothing_or_of_the_wrong_shape_do_not_pass() {
    let (system, inputs) = cart();
    let report = check::gradient(&system, &inputs, Settings::default()).directions(0, 1).run().expect("runs");
    assert_eq!(report.directions.len(), 1);
    for values in [vec![], vec![1.0; 3], vec![f64::NAN; 21], vec![0.0; 1000]] {
        let own = check::gradient(&system, &inputs, Settings::default()).own("mine", Part::Controls, values).run();
        assert!(!own.expect("runs").passed());
    }
    let motion = motion(&system, &inputs);
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let (equation, variable) = (Equation::F5, Variable::V);
    for nodes in [vec![], vec![0], vec![21], vec![usize::MAX]] {
        let report = check::step(&paper).nodes(nodes).f_y_previous(equation, variable, |at| -at.terms().phi_q).run();
        assert!(!report.passed() && !report.to_string().is_empty());
    }
    for shape in [(0, 0), (1, 1), (100, 2)] {
        let wrong = check::step(&paper).f_y_previous(equation, variable, |_| DMatrix::zeros(shape.0, shape.1)).run();
        assert!(!wrong.passed());
        let wrong = check::function(&Product, ["x", "y"], ["xy"]).jacobian(|_| DMatrix::zeros(shape.0, shape.1)).run();
        assert!(!wrong.passed());
    }
    let gradient = |x: &[f64]| [[x[1], x[0]]];
    assert!(check::function(&Product, ["x", "y"], ["xy"]).jacobian(gradient).run().passed());
    for sizes in [&[][..], &[1.0], &[1.0; 3], &[f64::NAN; 2]] {
        assert!(!check::function(&Product, ["x", "y"], ["xy"]).jacobian(|_| [[0.0, 0.0]]).magnitudes(sizes).run().passed());
        if sizes.len() != 2 {
            assert!(!check::function(&Product, ["x", "y"], ["xy"]).jacobian(|_| [[0.0, 0.0]]).at(sizes).run().passed());
        }
    }
    // More or fewer outputs than names.
    for_outputs::<0>();
    for_outputs::<2>();
    assert!(!check::function(&Product, ["x", "y"], ["xy"]).jacobian(gradient).random_points(0, 1).run().passed());
}

fn for_outputs<const O: usize>() {
    let names = [""; O];
    let report = check::function(&Product, ["x", "y"], names).jacobian(|_| [[0.0, 0.0]; O]).run();
    assert!(!report.passed());
}

/// The targets of the links of a page: `[text](target)` and `[label]: target`.
fn links(text: &str) -> Vec<&str> {
    let inline = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    let definitions = text.lines().filter_map(|line| line.strip_prefix('[')?.split_once("]: ")).map(|(_, target)| target);
    inline.chain(definitions).filter(|target| !target.is_empty()).collect()
}

#[test]
fn every_link_of_the_documents_leads_to_a_file_or_a_guide() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &std::path::Path| std::fs::read_to_string(path).expect("a text");
    let guides = read(&root.join("src/guide.rs"));
    let pages = std::fs::read_dir(root.join("docs")).expect("documents").map(|entry| entry.expect("a document").path());
    let pages = pages.filter(|path| path.extension().is_some_and(|kind| kind == "md"));
    for page in pages.chain(["README.md", "CONTRIBUTING.md"].map(|name| root.join(name))) {
        for link in links(&read(&page)) {
            if let Some(guide) = link.strip_prefix("https://docs.rs/hamiltonian-adjoint/latest/hamiltonian_adjoint/guide/") {
                let module = guide.strip_suffix("/index.html");
                let exists = module.is_none_or(|module| guides.contains(&format!("pub mod {module} {{}}")));
                assert!(exists, "{}: there is no guide {guide}", page.display());
            } else if !link.contains("://") {
                let target = page.parent().expect("a folder").join(link);
                assert!(target.exists(), "{}: there is no {link}", page.display());
            }
        }
    }
}

/// On docs.rs a link from guide to guide leads to a module: labels, which `guide_links.md` defines there, lead to both.
#[test]
fn guides_link_to_each_other_by_labels() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let labels = std::fs::read_to_string(root.join("src/guide_links.md")).expect("labels");
    for page in std::fs::read_dir(root.join("docs")).expect("documents").map(|entry| entry.expect("a document").path()) {
        if page.extension().is_none_or(|kind| kind != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&page).expect("a text");
        assert!(!text.contains(".md)"), "{} links to a file that docs.rs does not have", page.display());
        for line in text.lines().filter(|line| line.starts_with('[') && line.contains("]: ")) {
            let label = line.split_once(": ").expect("a definition").0;
            assert!(labels.contains(&format!("{label}: ")), "{}: {label} is not defined for docs.rs", page.display());
        }
    }
}

/// Whatever has state can be printed, and a compiled system can be copied.
#[test]
fn public_types_are_debug_and_systems_are_clone() {
    fn debug<T: std::fmt::Debug>() {}
    debug::<Scene>();
    debug::<Solver>();
    debug::<LongSolver>();
    debug::<LiftedSolver<Cx>>();
    debug::<MotionProblem>();
    debug::<MultipleShooting>();
    debug::<PaperSystem>();
    debug::<CartScene>();
    #[cfg(feature = "files")]
    {
        debug::<check::Pipe>();
        debug::<hamiltonian_adjoint::SceneFile>();
    }

    let system = CartPendulum::with_links(1).scene().compile().expect("a scene");
    let copy = system.clone();
    drop(system);
    let inputs = Inputs::at_rest(&copy, Grid::uniform(5, 0.01));
    let solver = Solver::new(&copy, Settings::default());
    println!("{:?} {solver:?}", CartPendulum::with_links(1).scene());
    assert!(format!("{solver:?}").starts_with("Solver { system: System { n: 6, m: 4, k: 1, .. }"));
    assert!(gradient(&copy, &inputs, Settings::default()).is_ok());
}

/// A system with its solver.
struct Machine {
    system: System,
    solver: Solver,
}

fn machine() -> Machine {
    let (system, _) = cart();
    let solver = Solver::new(&system, Settings::default());
    Machine { system, solver }
}

#[test]
fn solvers_and_problems_own_their_system_and_may_move_to_another_thread() {
    fn shared<T: Clone + Send + Sync + 'static>() {}
    fn owned<T: Send + 'static>() {}
    shared::<System>();
    owned::<Solver>();
    owned::<LongSolver>();
    owned::<LiftedSolver<Cx>>();
    owned::<Mechanics>();
    owned::<MotionProblem>();
    owned::<Trials>();
    owned::<MultipleShooting>();

    let Machine { system, mut solver } = machine();
    let inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.01));
    let expected = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    drop(system);
    let elsewhere = std::thread::spawn(move || {
        solver.simulate(&inputs).expect("a motion");
        solver.gradient().expect("a gradient").clone()
    });
    assert_eq!(elsewhere.join().expect("no panic"), expected);
}
