//! Scenes as files: every kind of part comes back as it was, and files of strangers are read or refused.
use crate::common::assert_says;
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::planar::{Body, Constant, ConstantSpeed, Harmonic};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{
    Cost, CostPoint, Grid, Inputs, KineticEnergy, Mechanics, Param, ParameterFormula, Scalar, Scene, SceneFile, Settings,
    Solver, Start, Sum, System, Trajectory, simulate,
};
use nalgebra::SVector;
use proptest::prelude::*;
use serde_json::Value;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// All kinds of parts, in mechanisms that stand side by side; parameters of all forms.
pub fn everything() -> Scene {
    let mut scene = Scene::new();
    let l = scene.design("length of \"it\"", 0.5);
    let m = scene.design("m", 1.5);
    scene.gravity(0.1, -(m * 6.54));
    let ground = |x: f64, y: f64| Body::GROUND.at(x, y);
    let inertia = m * l.powi(2) / 12.0 + (l - 0.4).sqrt().atan2(m) * 0.1 + (-l).exp() * 1e-3;
    let rod = scene.body("rod <1>", m, inertia, [0.25, 0.0, 0.0]);
    scene.revolute("pivot", ground(0.0, 0.0), rod.at(l * -0.5, 0.0));
    let motor = scene.control("motor");
    scene.torque_actuator("drive", Body::GROUND, rod, motor);
    scene.joint_friction("friction", Body::GROUND, rod, 0.1);
    scene.torsional_spring_damper("coil", Body::GROUND, rod, 2.0, 0.1, 0.05);
    scene.coulomb_friction("dry", Body::GROUND, rod, 0.1, 0.5);
    let bob = scene.particle("bob", l + 0.1, [0.9, -0.1]);
    scene.spring_damper("spring", rod.at(0.25, 0.0), bob.point(), 90.0, l * 0.5, 0.3);
    let rope = (0.9f64 * 0.9 + 0.1 * 0.1).sqrt();
    scene.distance("rope", ground(0.0, 0.0), bob.point(), rope);
    scene.applied_force("push", bob.point(), 0.3, Harmonic, [0.0.into(), 1.0.into(), 5.0.into(), 0.2.into()]);

    let cart = scene.body("cart", 1.0, 0.1, [2.0, 0.0, 0.0]);
    scene.prismatic("rail", ground(2.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    scene.sliding_friction("rail friction", ground(2.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.4);
    scene.coulomb_sliding("rail dry", ground(2.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.2, 0.3);
    let push = scene.control("push on the cart");
    scene.actuator("engine", ground(2.0, 0.0), 0.0, cart.at(0.0, 0.0), push);
    let block = scene.body("block", 0.3, 0.01, [2.1, 0.2, 0.0]);
    scene.weld("glue", cart.at(0.1, 0.2), block.at(0.0, 0.0), 0.0);
    scene.applied_torque("twist", block, Constant, [0.2.into()]);
    let ball = scene.body("ball", 0.5, 0.02, [2.0, 1.0, 0.0]);
    scene.contact("floor", ground(0.0, 0.9), 1.5, ball.at(0.0, -0.1), [500.0.into(), 0.1.into(), 0.2.into(), 0.1.into()]);
    let rough = |width: f64| [500.0, 0.1, 0.2, 0.1, width].map(Param::from);
    scene.circle_contact("round floor", ground(0.0, 0.8), 1.5, ball.at(0.0, 0.0), l * 0.4, rough(0.01));
    scene.circle_pair_contact("worn hinge", ground(2.0, 1.0), -(l * 0.5), ball.at(0.0, 0.0), 0.245, rough(0.0));
    scene.end_stop("stop of the rod", Body::GROUND, rod, [(-0.1).into(), l * 1.0], [50.0.into(), 0.1.into(), 0.02.into()]);
    let track = [1.9, 2.1].map(Param::from);
    scene.sliding_end_stop(
        "stop of the cart",
        ground(0.0, 0.0),
        0.0,
        cart.at(0.0, 0.0),
        track,
        [90.0, 0.1, 0.0].map(Into::into),
    );
    let soft = [30.0, 40.0, 0.5].map(Into::into);
    scene.bushing("mount", cart.at(0.0, 0.9), ball.at(0.0, 0.0), soft, [0.1, 0.2, 0.01].map(Into::into));
    let cylinder = scene.control("cylinder");
    scene.two_point_actuator("cylinder", cart.at(0.3, 0.1), ball.at(0.1, 0.0), cylinder);

    let [first, second] = [("first wheel", 4.0), ("second wheel", 4.5)].map(|(name, x)| {
        let wheel = scene.body(name, 1.0, 0.1, [x, 0.0, 0.3]);
        scene.revolute(&format!("axle of {name}"), ground(x, 0.0), wheel.at(0.0, 0.0));
        wheel
    });
    scene.gear("teeth", first, 0.2, second, 0.3);
    let rack = scene.body("rack", 1.0, 0.1, [4.5, 0.3, 0.0]);
    scene.prismatic("slide", ground(4.5, 0.3), 0.0, rack.at(0.0, 0.0), 0.0);
    scene.place(rack.coordinates[0], 4.6);
    scene.rack("rack and pinion", rack, 0.0, second, -0.3);

    let crank = scene.body("crank", 1.0, 0.1, [6.0, 0.0, 0.2]);
    scene.revolute("crank axle", ground(6.0, 0.0), crank.at(0.0, 0.0));
    scene.driven_angle("turning", Body::GROUND, crank, ConstantSpeed, [0.2.into(), m * 1.0]);
    let piston = scene.body("piston", 1.0, 0.1, [7.0, 0.0, 0.0]);
    scene.prismatic("bore", ground(7.0, 0.0), 0.0, piston.at(0.0, 0.0), 0.0);
    let swing = |x: f64| [x.into(), 0.1.into(), 3.0.into(), 0.0.into()];
    scene.driven_slider("stroke", (ground(7.0, 0.0), 0.0), piston.at(0.0, 0.0), Harmonic, swing(0.0));
    let arm = scene.body("arm", 1.0, 0.1, [8.0, 0.0, 0.0]);
    scene.revolute("arm axle", ground(8.0, 0.0), arm.at(0.0, 0.0));
    scene.driven_distance("jack", ground(8.0, -1.0), arm.at(0.5, 0.0), Harmonic, swing(1.25f64.sqrt()));
    scene.effort("effort of the motor", motor, m * 0.1 + 0.3);
    scene.time("hurry", l.powi(2) / 3.0);
    scene.end_state(cart.coordinates[0]);
    scene.reading("seen at 3", bob.coordinates[1], 3, -0.1, 7.0);
    scene.reading_time("seen at 3", 3, 0.03);
    scene.reading_deviation("seen at 3", 0.5);
    scene
}

fn motion(system: &System) -> Trajectory {
    let mut inputs = Inputs { start: Start::assembled(system), ..Inputs::at_rest(system, Grid::uniform(8, 0.01)) };
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (i as f64).sin());
    simulate(system, &inputs, Settings::default()).expect("a motion")
}

#[test]
fn every_part_comes_back_as_it_was() {
    let scene = everything();
    let json = scene.to_json().expect("a file");
    let file: Value = serde_json::from_str(&json).expect("JSON");
    let kinds: BTreeSet<&str> = file["parts"].as_array().expect("parts").iter().filter_map(|p| p["kind"].as_str()).collect();
    assert_eq!(
        kinds.len(),
        26 + 6 + 6,
        "26 kinds of parts, and controls, design variables, gravity, bodies, particles, values; effort, time, end states, readings, their times and deviations: {kinds:?}"
    );
    let read = SceneFile::from_json(&json).expect("a scene").complete().expect("whole");
    assert_eq!(read.to_json().expect("a file"), json, "written again it is the same");
    let (was, is) = (scene.compile().expect("a system"), read.compile().expect("a system"));
    assert_eq!((was.n(), was.m(), was.k(), was.designs()), (is.n(), is.m(), is.k(), is.designs()));
    let (was, is) = (motion(&was), motion(&is));
    for (was, is) in [(&was.q, &is.q), (&was.v, &is.v), (&was.p_star, &is.p_star), (&was.sigma, &is.sigma)] {
        let error = (was - is).amax();
        assert!(error <= 1e-13 * was.amax(), "{error}");
    }
}

#[test]
fn motions_come_back_to_the_last_bit() {
    let system = everything().compile().expect("a system");
    let motion = motion(&system);
    let json = motion.to_json(&system).expect("a file");
    assert_eq!(Trajectory::from_json(&system, &json).expect("the motion"), motion);
    let read = |json: &str| Trajectory::from_json(&system, json).expect_err("a wrong file");
    assert_says(&read(&json.replacen("trapezoidal", "magic", 1)), &["`scheme`", "`magic"]);
    assert_says(&read(&json.replacen("\"inserted\":[", "\"inserted\":[99", 1)), &["inserted"]);
    assert_says(&read(&json[..200]), &["line 1", "column", "EOF"]);
}

#[test]
fn motions_that_stopped_where_steps_were_halved_come_back() {
    let system = everything().compile().expect("a system");
    let whole = motion(&system);
    for computed in [0, 1, 2] {
        let stopped = Trajectory { computed, inserted: vec![1, 2], restarted: vec![1, 3], ..whole.clone() };
        let read = Trajectory::from_json(&system, &stopped.to_json(&system).expect("a file")).expect("the motion");
        assert_eq!((read.computed, &read.times[..]), (computed, &whole.times[..computed]));
        let kept = if computed == 2 { vec![1] } else { vec![] };
        assert_eq!((&read.inserted, &read.restarted), (&kept, &kept));
    }
}

#[test]
fn lists_of_nodes_and_equations_that_no_motion_has_are_refused() {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.cost("aim", AngleError, Sum::Trapezoidal, [cart.links[0].coordinates[2]], [], [], [0.3.into()]);
    let system = cart.scene.compile().expect("a system");
    let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.02));
    let motion = simulate(&system, &inputs, Settings::default()).expect("a motion");
    let json = motion.to_json(&system).expect("a file");
    let read = |name: &str, list: &str| {
        let json = json.replacen(&format!("\"{name}\":[]"), &format!("\"{name}\":{list}"), 1);
        Trajectory::from_json(&system, &json)
    };
    let refused = |name: &str, list: &str, words: &[&str]| {
        let error = read(name, list).expect_err(list);
        assert_says(&error, &[&[&format!("`{name}`")[..]], words].concat());
    };
    for name in ["inserted", "restarted"] {
        refused(name, "[0]", &["node 0", "the first one"]);
        refused(name, "[1,1]", &["node 1 follows node 1", "ascend"]);
        refused(name, "[2,1]", &["node 1 follows node 2"]);
        refused(name, "[2,5]", &["node 5", "beyond the last one"]);
        assert!(read(name, "[1,3]").is_ok());
    }
    refused("compliance", "[[1,[]],[0,[]]]", &["node 0 follows node 1"]);
    refused("compliance", "[[0,[]],[0,[]]]", &["node 0 follows node 0"]);
    refused("compliance", "[[5,[]]]", &["node 5", "beyond"]);
    refused("compliance", "[[0,[[0,-1.0]]]]", &["equation 0", "-1", "not be negative"]);
    refused("compliance", "[[0,[[1,1e-3],[0,1.0],[1,2.0]]]]", &["equation 1", "twice"]);
    refused("compliance", "[[0,[[99,1.0]]]]", &["equation 99", "beyond"]);
    assert!(read("compliance", "[[0,[[1,1e-3],[0,0.0]]],[2,[]]]").is_ok());
    // A motion may have stopped within a given step: it can be looked at, and has no cost.
    for (inserted, is_possible) in [(vec![1, 3], true), (vec![4], false), (vec![1, 1], false), (vec![0], false)] {
        let other = Trajectory { inserted, ..motion.clone() };
        let errors = [other.cost(&system, &inputs).err(), PaperSystem::new(&system, &inputs, &other).err()];
        for error in errors {
            assert_eq!(error.is_none(), is_possible, "{:?}: {error:?}", other.inserted);
            error.iter().for_each(|error| assert_says(error, &["`inserted`", "between the first and the last node"]));
        }
        assert!(other.phi(&system, &inputs).is_ok());
    }
    assert!(read("inserted", "[4]").is_ok());
}

/// Formulas that branch on a value, so that they have no graph.
struct Branch;
impl KineticEnergy<1, 0> for Branch {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        if v[0].re() > 1.0 { v[0] } else { v[0] * v[0] }
    }
}
impl Cost<1, 0, 0, 0> for Branch {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        if at.q[0].re() > 0.5 { at.q[0] } else { at.q[0] * at.q[0] }
    }
}

#[test]
fn what_a_file_cannot_hold_is_named() {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.cost("aim", Branch, Sum::Terminal, [cart.links[0].coordinates[2]], [], [], []);
    let [flow] = cart.scene.coordinates("tank", ["flow"]);
    cart.scene.kinetic_energy("water", Branch, [flow], []);
    let file = SceneFile::from_json(&cart.scene.to_json().expect("a file")).expect("a scene");
    assert_eq!(file.left_out, ["aim", "water"]);
    assert!(file.scene.coordinate_named("tank.flow").is_some());
    assert!(file.scene.frame_named("link 1").is_some() && file.scene.control_named("force on the cart").is_some());
    let Err(error) = file.complete() else { panic!("it is not whole") };
    assert_says(&error, &["left_out", "`aim`", "branches on a value"]);
    let mut bad = Scene::new();
    bad.body("rod", f64::INFINITY, 0.1, [0.0; 3]);
    assert_says(&bad.to_json().expect_err("no number"), &["rod"]);
    let mut bad = Scene::new();
    let length = bad.design("length", 1.0);
    bad.body("rod", length * 1e308 * 1e10, 0.1, [0.0; 3]);
    assert_says(&bad.to_json().expect_err("no number"), &["rod"]);
}

#[test]
fn what_is_written_can_be_read_and_the_rest_is_named() {
    let mut scene = Scene::new();
    let (l, odd) = (scene.design("l", 1.0), scene.design("it's `l`", 1.0));
    let bodies = [("odd", odd * 2.0), ("infinite", (l + f64::INFINITY) * 2.0)];
    for (name, mass) in bodies {
        let body = scene.body(name, mass, 0.1, [0.0; 3]);
        scene.place(body.coordinates[0], 0.5);
        scene.revolute(&format!("hinge of {name}"), Body::GROUND.at(0.0, 0.0), body.at(0.0, 0.0));
    }
    let whole = scene.body("whole (((", (l + 1.0) * 2.0, 0.1, [0.0; 3]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), whole.at(0.0, 0.0));
    let file = SceneFile::from_json(&scene.to_json().expect("a file")).expect("a scene");
    let names = bodies.iter().flat_map(|(name, _)| [name.to_string(), format!("{name}.x"), format!("hinge of {name}")]);
    assert_eq!(file.left_out, names.collect::<Vec<_>>());
    let system = file.scene.compile().expect("a system");
    assert_eq!((system.n(), system.m()), (3, 2), "the whole body and its hinge");
}

/// A formula of x = [l, m].
struct Formula<F>(F);

impl<F: Fn(f64) -> f64 + Send + Sync + 'static> ParameterFormula<2> for Formula<F> {
    fn value<S: Scalar>(&self, x: &SVector<S, 2>) -> S {
        let steps = (0..30).map(|k| S::from((self.0)(f64::from(k))));
        steps.fold(x[0] * x[1], |all, step| {
            (all * step * 0.7 / 3.0 + all / 0.3 + x[1].powf(1.5) - x[0].hypot(all)).tanh() + 1.5
        })
    }
}

/// Sums and chains of thousands of terms, formulas within formulas, and shared parts that would be as long as 2³⁰ if they were written wherever they stand.
#[test]
fn long_expressions_are_written_and_read_to_the_last_bit() {
    let build = |which: usize| {
        let mut scene = Scene::new();
        let (l, m) = (scene.design("l; of $1", 0.9), scene.design("m", 1.1));
        let mass = match which {
            0 => (0..8000).fold(l * 1.0, |sum, k| sum + (l * f64::from(k)).sin().powi(2)),
            1 => (0..8000).fold(m * 1.0, |product, k| product * (l / (1.3 + f64::from(k)) + 1.0) / 1.0001),
            2 => (0..70).fold(l * 1.0, |deep, _| (deep + 1.0).sin()),
            3 => (0..30).fold(l * m, |half, _| (half * half + half / 3.0).sqrt() * 1.1),
            4 => scene.parameter("formula", Formula(|k: f64| (k + 1.0).ln() + 0.1), [l.into(), m.into()]),
            _ => (0..3000).fold(l * 1.0, |nested, k| (m - nested / (nested + f64::from(k) + 2.0)) * -0.3) * -0.7 + 2.0,
        };
        let body = scene.body("body", mass, mass * 0.1, [0.3, 0.0, 0.1]);
        scene.spring_damper("spring", Body::GROUND.at(0.0, 1.0), body.at(0.2, 0.0), 3.0, 0.5, 0.1);
        scene.end_state(body.coordinates[0]);
        scene
    };
    for which in 0..6 {
        let json = build(which).to_json().expect("a file");
        let file = SceneFile::from_json(&json).expect("a scene").complete().expect("all of it");
        // Sums and products may be written the other way round, which changes no bit of their values.
        let [first, second] = [build(which), file].map(|scene| {
            let system = scene.compile().expect("a system");
            let mut solver = Solver::new(&system, Settings::default());
            solver.simulate(&Inputs::at_rest(&system, Grid::uniform(3, 0.1))).expect("a motion");
            solver.jacobian().expect("a Jacobian")
        });
        assert_eq!(first, second, "{which}");
    }
}

#[test]
fn what_is_wrong_in_a_scene_is_named_with_its_place() {
    let json = everything().to_json().expect("a file");
    let read = |json: &str| SceneFile::from_json(json).expect_err("a wrong file");
    let change = |from: &str, to: &str| {
        assert!(json.contains(from), "{from}");
        read(&json.replacen(from, to, 1))
    };
    assert_says(&read(&json[..300]), &["line", "column"]);
    assert_says(&change("\"version\": 2", "\"version\": 7"), &["version 7", "expected", "version 2"]);
    assert_says(&change("\"version\": 2", "\"version\": 2, \"version\": 1"), &["line", "`version` occurs twice here"]);
    let twice = "\"at\": [0.0, 0.0], \"body\": \"bob\", \"body\": \"bob\"";
    assert_says(&change("\"body\": \"bob\"", twice), &["line", "column", "occurs twice here"]);
    assert_says(&change("\"kind\": \"weld\"", "\"kind\": \"wold\""), &["`glue`", "this kind does not exist", "weld"]);
    assert_says(&change("\"body\": \"bob\"", "\"body\": \"bib\""), &["no body `bib`"]);
    assert_says(
        &change("\"force\": \"push on the cart\"", "\"force\": \"pull\""),
        &["actuator `engine`", "no control `pull`"],
    );
    assert_says(&change("\"motion\": \"harmonic\"", "\"motion\": \"square\""), &["`square`", "constant speed"]);
    assert_says(&change("\"stiffness\": 90.0", "\"stiffness\": \"90 *\""), &["`spring`", "character 5", "ends too early"]);
    assert_says(&change("\"stiffness\": 90.0", "\"stiffness\": \"90 * k\""), &["no design variable is called `k`"]);
    assert_says(&change("\"stiffness\": 90.0", "\"stiffness\": \"wurzel(2)\""), &["unknown function `wurzel`", "sqrt"]);
    assert_says(&change("\"stiffness\": 90.0", "\"stiffness\": \"2 ^ m\""), &["exponent must be a number"]);
    assert_says(&change("\"stiffness\": 90.0", "\"stiffness\": \"90; $2\""), &["character 5", "no part `$2` precedes it"]);
    assert_says(&change("\"stiffness\": 90.0", "\"stiffness\": \"90;\""), &["ends too early"]);
    assert_says(&change("\"stiffness\": 90.0", "\"stifness\": 90.0"), &["`spring`", "`stiffness` is missing"]);
    assert_says(
        &change("\"damping\": 0.3", "\"damping\": 0.3, \"colour\": 1"),
        &["`spring`", "the field `colour` does not exist"],
    );
    assert_says(&change("\"control\": \"motor\"", "\"control\": \"mtor\""), &["effort", "no control `mtor`"]);
    assert_says(
        &change("\"coordinate\": \"bob.y\"", "\"coordinate\": \"bob.z\""),
        &["`seen at 3`", "no coordinate `bob.z`"],
    );
    for node in ["-1", "1.5", "1e300", "\"3\""] {
        assert_says(&change("\"node\": 3", &format!("\"node\": {node}")), &["`seen at 3`", "`node` must be"]);
    }
    let deep = format!("\"stiffness\": \"{}1{}\"", "(".repeat(10_000), ")".repeat(10_000));
    assert_says(&change("\"stiffness\": 90.0", &deep), &["nested parentheses"]);
}

#[test]
fn formulas_say_what_they_say() {
    let value = |text: &str| {
        let file = format!(
            r#"{{"format": "hamiltonian-adjoint scene", "version": 1, "left_out": [], "parts": [
            {{"kind": "design variable", "name": "m", "value": 3.0}}, {{"kind": "design variable", "name": "a b", "value": 2.0}},
            {{"kind": "body", "name": "rod", "mass": "{text}", "inertia": 1, "place": [0, 0, 0]}}]}}"#
        );
        let scene =
            SceneFile::from_json(&file).and_then(SceneFile::complete).unwrap_or_else(|error| panic!("{text}: {error}"));
        let system = scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.1));
        Mechanics::at_start(&system, &inputs).expect("a state").mass()[(0, 0)]
    };
    let cases = [
        ("1 + m * 2 ^ 3 / 4 - -1", 8.0),
        ("-m ^ 2 + 10", 1.0),
        ("2 - 1 - 0.5", 0.5),
        ("16 / 4 / 2", 2.0),
        ("(m + `a b`) * .5e1 / 2.5E+0", 10.0),
        ("sqrt(m * m * 4) + atan2(0, m) + max(m, `a b`) + min(1, m)", 10.0),
        ("m ^ -1 * 3 + `a b` ^ 0.5 * sqrt(2)", 3.0),
        (" exp ( ln( m ) ) ", 3.0),
        // Zeros have signs, which decide where an angle jumps.
        ("5 + atan2(-0, -m)", 5.0 - PI),
        ("5 + atan2(0 * -m, -m)", 5.0 - PI),
        ("5 + atan2(m * -0.0 + -0.0, -m)", 5.0 - PI),
        ("5 + atan2(0 / -m, -m)", 5.0 - PI),
        ("5 + atan2(-0 * m + 0, -m)", 5.0 + PI),
        ("5 + atan2(m - m, -m)", 5.0 + PI),
        ("5 + atan2(-(m - 3) * m, -m)", 5.0 - PI),
        ("5 + atan2(0 - (m - 3), -m)", 5.0 + PI),
    ];
    for (text, expected) in cases {
        assert!((value(text) - expected).abs() < 1e-14, "{text}: {}", value(text));
    }
}

#[test]
fn files_keep_the_signs_of_zeros_in_parameters() {
    let mut scene = Scene::new();
    let m = scene.design("m", 3.0);
    let zeros = [Param::from(-0.0) + m * -0.0, m * 0.0 - m * 0.0 * m, -(m - 3.0) * m, (m - 3.0) / -m, Param::from(-0.0) / m];
    for (k, zero) in zeros.into_iter().enumerate() {
        scene.particle(&format!("p{k}"), zero.atan2(-m) + 5.0, [0.0; 2]);
    }
    let masses = |scene: Scene| {
        let system = scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.1));
        Mechanics::at_start(&system, &inputs).expect("a state").mass().diagonal()
    };
    let copy = SceneFile::from_json(&scene.to_json().expect("a file")).and_then(SceneFile::complete).expect("a scene");
    let (masses, copied) = (masses(scene), masses(copy));
    let expected = [-PI, PI, -PI, -PI, -PI].map(|angle| angle + 5.0);
    for (k, expected) in expected.into_iter().enumerate() {
        assert!((masses[2 * k] - expected).abs() < 1e-14 && masses[2 * k] == copied[2 * k], "{k}: {masses} {copied}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Files that were cut, doubled or changed somewhere: an answer or an error, and never a panic.
    #[test]
    fn broken_scenes_are_refused_or_read(at in 0.0..1.0f64, len in 0..40usize, with in "[ -~\\n]{0,6}") {
        let text = everything().to_json().expect("a file");
        let from = (at * text.len() as f64) as usize;
        let to = (from + len).min(text.len());
        let broken = format!("{}{with}{}", text.get(..from).unwrap_or(""), text.get(to..).unwrap_or(""));
        if let Ok(file) = SceneFile::from_json(&broken) {
            let _ = file.scene.to_json();
            let _ = file.scene.compile();
        }
    }

    #[test]
    fn formulas_of_strangers_are_refused_or_read(text in "[m0-9+*/^()., \\-a-z`]{0,40}") {
        let file = format!(
            r#"{{"format": "hamiltonian-adjoint scene", "version": 1, "left_out": [], "parts": [
            {{"kind": "design variable", "name": "m", "value": 3.0}},
            {{"kind": "gravity", "name": "gravity", "x": {}, "y": 0}}]}}"#, Value::String(text)
        );
        if let Ok(file) = SceneFile::from_json(&file) {
            let _ = file.scene.to_json();
        }
    }
}
