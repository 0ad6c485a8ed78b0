//! Parameters that are expressions of design variables: exact derivatives on every way to a gradient, and nothing where nothing is bound.

use crate::common::{assert_gradient_is_exact_with, assert_says, largest_difference};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Composition, Design, Error, Grid, Inputs, LongSolver, Param, ParameterFormula, Scalar, Scene, Scheme, Settings, Solver,
    Sum, System, check, gradient, simulate,
};
use nalgebra::SVector;

/// x₀ tanh(x₁) + max(x₀, x₁).
struct Mixed;

impl ParameterFormula<2> for Mixed {
    fn value<S: Scalar>(&self, x: &SVector<S, 2>) -> S {
        x[0] * x[1].tanh() + x[0].max(x[1])
    }
}

/// Two rods on a spring: masses, inertias, a stiffness, a damping, gravity and a cost, all by expressions of three design variables.
fn rods() -> (Scene, [Design; 3]) {
    let mut scene = Scene::new();
    let designs @ [m, l, a] = [("mass", 0.7), ("length", 0.9), ("more", 0.3)].map(|(name, value)| scene.design(name, value));
    scene.gravity(a * 0.1, -(9.0 + l * l));
    let mixed = scene.parameter("mixed", Mixed, [l.into(), a * 2.0]);
    let upper = scene.body("upper", m + 0.2, m * l * l / 12.0, [0.5, 0.0, 0.0]);
    let lower = scene.body("lower", (m * m + a).sqrt(), 0.1 / mixed, [1.0, -0.5, -1.5]);
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-0.5, 0.0));
    let elbow = scene.at_world(lower, 1.0, 0.0);
    scene.revolute("elbow", upper.at(0.5, 0.0), elbow);
    scene.torsional_spring_damper("spring", upper, lower, (l / a).powf(1.5), a.exp() * l.atan2(a), (l - a).atan2(m));
    let u = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, upper, u);
    let [.., angle] = lower.coordinates;
    scene.cost("angle", AngleError, Sum::Trapezoidal, [angle], [], [], [(m * 2.0 - l) + a.sin()]);
    scene.cost("end", AngleError, Sum::Terminal, [angle], [], [], [m.into()]);
    (scene, designs)
}

fn inputs(system: &System, steps: usize) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.02));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 2.0 * (0.3 * i as f64).sin());
    inputs
}

#[test]
fn their_derivatives_are_exact_on_every_way_to_a_gradient() {
    let plain = Settings::default();
    let ways = [
        ("trapezoidal rule", plain),
        ("ESDIRK4", Settings { scheme: Scheme::ESDIRK4, ..plain }),
        ("projected", Settings { drift_bound: 0.0, ..plain }),
        ("rebased", Settings { rebase_every: 3, ..plain }),
    ];
    for scene in [rods().0.compile(), rods().0.compile_without_programs()] {
        let system = scene.expect("a scene");
        for (what, settings) in ways {
            assert_gradient_is_exact_with(what, &system, &inputs(&system, 12), settings);
        }
        let mut composed = inputs(&system, 12);
        composed.grid = Grid::composed(4, 0.04, Composition::Suzuki4);
        composed.controls = nalgebra::DMatrix::from_element(1, composed.grid.nodes(), 0.7);
        assert_gradient_is_exact_with("composed", &system, &composed, Settings { drift_bound: 0.0, ..plain });
    }
}

#[test]
fn the_ways_agree_with_each_other() {
    let system = rods().0.compile().expect("a scene");
    let inputs = inputs(&system, 40);
    let settings = Settings::default();
    let ours = gradient(&system, &inputs, settings).expect("a gradient");
    let mut long = LongSolver::new(&system, settings, 40_000);
    assert_eq!(long.gradient(&inputs).expect("a gradient").design, ours.design);
    let motion = simulate(&system, &inputs, settings).expect("a motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("a paper system").gradient().expect("a gradient");
    assert!(largest_difference(paper.design.as_slice(), ours.design.as_slice()) < 1e-11 * ours.design.amax());
    let all: Vec<check::Input> = (0..3).map(check::Input::Design).collect();
    let tangents = check::tangent(&system, &inputs, settings, &all).expect("tangents");
    assert!(largest_difference(&tangents, ours.design.as_slice()) < 1e-12 * ours.design.amax());
    let value = motion.cost(&system, &inputs).expect("a cost");
    assert!((value - ours.value).abs() < 1e-14 * value);
}

#[test]
fn a_change_of_design_is_a_scene_with_these_numbers() {
    let system = rods().0.compile().expect("a scene");
    let mut solver = Solver::new(&system, Settings::default());
    let mut inputs = inputs(&system, 10);
    for (m, l) in [(0.7, 0.9), (0.5, 1.1), (0.7, 0.9)] {
        (inputs.design[0], inputs.design[1]) = (m, l);
        solver.simulate(&inputs).expect("a motion");
        let reused = solver.gradient().expect("a gradient").clone();
        assert_eq!(reused, gradient(&system, &inputs, Settings::default()).expect("a gradient"));
    }
}

#[test]
fn what_is_made_of_numbers_is_a_number() {
    let mut scene = Scene::new();
    let l = scene.design("length", 0.9);
    let two: Param = 2.0.into();
    assert_eq!((two * 3.0 - 1.0) / 2.0, Param::from(2.5));
    assert_eq!((two.powi(3) + two.sqrt().powf(2.0).recip().sin() * 0.0).ln(), Param::from(8f64.ln()));
    assert_eq!(l - l, Param::from(0.0), "nothing is left of the variable");
    assert_eq!(2.0 * l * 3.0, l * 6.0);
    assert!(!format!("{:?}", -(l * 6.0) / 2.0).contains("Expression"), "a multiple is none");
    assert_eq!(scene.parameter("mixed", Mixed, [2.0.into(), 1.0.into()]), Param::from(2.0 * 1f64.tanh() + 2.0));
}

/// A formula that panics.
struct Panics;

impl ParameterFormula<1> for Panics {
    fn value<S: Scalar>(&self, _x: &SVector<S, 1>) -> S {
        panic!("on purpose")
    }
}

/// A formula that branches.
struct Branch;

impl ParameterFormula<1> for Branch {
    fn value<S: Scalar>(&self, x: &SVector<S, 1>) -> S {
        if x[0].re() > 0.0 { x[0] } else { x[0] * x[0] }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let body = |scene: &mut Scene, mass: Param| {
        scene.body("arm", mass, 1.0, [0.0; 3]);
    };
    let mut scene = Scene::new();
    let a = scene.design("a", 0.5);
    body(&mut scene, (a - 1.0) * 2.0 * a);
    assert_says(&scene.compile().expect_err("a negative mass"), &["mass", "arm", "-0.5"]);

    let (mut scene, mut other) = (Scene::new(), Scene::new());
    let (a, b) = (scene.design("a", 0.5), other.design("b", 0.5));
    body(&mut scene, a * b);
    assert!(matches!(scene.compile(), Err(Error::Foreign { .. })));
    body(&mut other, a + 1.0);
    assert!(matches!(other.compile(), Err(Error::Foreign { .. })), "its scene is gone");

    let mut scene = Scene::new();
    let a = scene.design("alpha", 0.5);
    body(&mut scene, (a - 1.0).ln() + 2.0);
    assert_says(&scene.compile().expect_err("the logarithm of a negative number"), &["`alpha`", "NaN"]);

    let mut scene = Scene::new();
    let a = scene.design("alpha", 0.5);
    let arm = scene.body("arm", 1.0, 1.0, [0.0; 3]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), arm.at(a * f64::NAN, 0.0));
    assert_says(&scene.compile().expect_err("no multiple"), &["`pivot`", "NaN"]);

    let mut scene = Scene::new();
    let a = scene.design("alpha", 0.5);
    body(&mut scene, a.sqrt() + 2.0);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.1));
    inputs.design[0] = -1.0;
    let stopped = simulate(&system, &inputs, Settings::default()).expect_err("no root");
    assert_says(&stopped.error, &["`alpha`", "NaN"]);

    let mut scene = Scene::new();
    let a = scene.design("alpha", 0.5);
    let mass = scene.parameter("branching", Branch, [a.into()]);
    body(&mut scene, mass);
    assert_says(&scene.compile().expect_err("a branch"), &["branching", "branches on a value"]);

    for bound in [true, false] {
        let mut scene = Scene::new();
        let of: Param = if bound { scene.design("alpha", 0.5).into() } else { 0.5.into() };
        let mass = scene.parameter("panicking", Panics, [of]);
        body(&mut scene, mass);
        assert_says(&scene.compile().expect_err("a panic"), &["panicking", "panics"]);
    }
}

/// 1 + √max(x, 0).
struct Cut;

impl ParameterFormula<1> for Cut {
    fn value<S: Scalar>(&self, x: &SVector<S, 1>) -> S {
        x[0].max(S::zero()).sqrt() + 1.0
    }
}

#[test]
fn products_are_there_where_slopes_of_what_is_cut_off_are_infinite() {
    let mut scene = Scene::new();
    let (a, b) = (scene.design("cut off", -0.3), scene.design("factor", 1.2));
    let mass = scene.parameter("mass", Cut, [a.into()]);
    let rod = scene.body("rod", mass * b, 0.1, [0.0; 3]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, rod.at(0.0, 0.0), force);
    scene.cost("end", AngleError, Sum::Terminal, [rod.coordinates[0]], [], [], [0.0.into()]);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.1));
    inputs.controls.fill(2.0);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let mut direction = inputs.no_change();
    direction.design.fill(1.0);
    let product = solver.hessian_product(&direction).expect("a product").design.clone();
    // x = u t²/2b, J = ½ x².
    let expected = 3.0 / 1.2f64.powi(4);
    assert!(product[0] == 0.0 && (product[1] - expected).abs() < 1e-13, "{product}");
}
