//! Ready costs and outputs in scene files: the same J, outputs and gradient, to the last bit.
use crate::common::assert_says;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Cost, CostPoint, Gradient, Grid, Inputs, Scalar, Scene, SceneFile, Settings, Solver, Sum};
use nalgebra::SVector;

/// A cart that is pushed, and what it costs; the names of outputs in their order.
fn scene() -> (Scene, Vec<String>) {
    let mut scene = Scene::new();
    let (w, m) = (scene.design("w", 0.3), scene.design("m", 2.0));
    let force = scene.control("force");
    let cart = scene.body("cart", m, 0.1, [0.1, 0.0, 0.0]);
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    let [x, y, _] = cart.coordinates;
    scene.reading("seen first", x, 7, 0.4, 30.0);
    scene.effort("effort", force, w * 2.0 + m.sqrt() / 7.0);
    scene.end_state(x);
    scene.time("time", (w * m).exp());
    scene.reading("seen last", x, 3, -0.1, 0.7);
    scene.end_state(y);
    let ends = |of: &str| ["value", "rate"].map(|what| format!("{what} of cart.{of} at the end"));
    let names = [&["seen first".to_string()][..], &ends("x"), &["seen last".to_string()], &ends("y")].concat();
    (scene, names)
}

/// J, the outputs, and the gradients of all of them.
fn of(scene: Scene, names: &[String]) -> (Vec<f64>, Vec<Gradient>) {
    let system = scene.compile().expect("a system");
    assert_eq!(system.outputs(), names.len());
    (0..names.len()).for_each(|k| assert_eq!(system.output_name(k), names[k]));
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.05));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (i as f64).cos());
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let mut all = vec![solver.gradient().expect("a gradient").clone()];
    all.extend(solver.jacobian().expect("gradients"));
    let mut values = vec![solver.cost().expect("J")];
    values.extend(&solver.outputs().expect("outputs"));
    (values, all)
}

#[test]
fn ready_costs_and_outputs_come_back_to_the_last_bit() {
    let (was, names) = scene();
    let json = was.to_json().expect("a file");
    let file = SceneFile::from_json(&json).expect("a scene");
    assert!(file.left_out.is_empty(), "{:?}", file.left_out);
    assert_eq!(file.scene.to_json().expect("a file"), json);
    let (was, is) = (of(was, &names), of(file.scene, &names));
    assert!(was == is && was.0[0] > 0.1 && was.0[1] != 0.0, "{:?} {:?}", was.0, is.0);
}

#[test]
fn outputs_and_multipliers_are_found_by_name() {
    let (mut was, _) = scene();
    let [x, y] = ["cart.x", "cart.y"].map(|name| was.coordinate_named(name).expect("there"));
    let rod = was.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    was.revolute("axle", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    let is = SceneFile::from_json(&was.to_json().expect("a file")).expect("a scene").scene;
    let [is_x, is_y] = ["cart.x", "cart.y"].map(|name| is.coordinate_named(name).expect("there"));
    for (scene, x, y) in [(&was, x, y), (&is, is_x, is_y)] {
        assert_eq!(scene.output_named("seen last").map(|output| output.index()), Some(3));
        let state = scene.end_state_of(y).expect("both outputs");
        assert_eq!((state.position.index(), state.rate.index(), state.coordinate), (4, 5, y));
        assert_eq!(scene.end_state_of(x).map(|state| state.rate.index()), Some(2));
        let of = scene.multipliers_named("axle").expect("a joint");
        assert_eq!(of.iter().map(|multiplier| multiplier.index()).collect::<Vec<usize>>(), [0, 1]);
        assert!(scene.output_named("axle").is_none() && scene.multipliers_named("seen last").is_none());
    }
    // A coordinate of another scene, and one that nobody asked for.
    let angle = is.coordinate_named("rod.φ").expect("there");
    assert!(was.end_state_of(is_x).is_none() && is.end_state_of(angle).is_none());
}

/// A formula that branches on a value, so that it has no graph.
struct Branch;

impl Cost<1, 0, 0, 0> for Branch {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        if at.q[0].re() > 0.5 { at.q[0] } else { at.q[0] * at.q[0] }
    }
}

#[test]
fn costs_and_outputs_that_a_file_cannot_hold_are_named_once() {
    let (mut scene, _) = scene();
    let x = scene.coordinate_named("cart.x").expect("there");
    scene.cost("aim", Branch, Sum::Terminal, [x], [], [], []);
    let [own, seen] = [scene.output("own"), scene.reading("seen", x, 2, 0.0, 1.0)];
    scene.term(own, "own", Branch, Sum::Terminal, [x], [], [], []);
    scene.term(seen, "more", Branch, Sum::Terminal, [x], [], [], []);
    // One that has the name of the ready output that it adds to.
    scene.term(seen, "seen", Branch, Sum::Terminal, [x], [], [], []);
    let file = SceneFile::from_json(&scene.to_json().expect("a file")).expect("a scene");
    assert_eq!(file.left_out, ["aim", "own", "more", "seen"]);
    let Err(error) = file.complete() else { panic!("it is not whole") };
    assert_says(&error, &["`aim`"]);
}

#[test]
fn what_is_asked_of_bodies_that_are_left_out_is_left_out() {
    let mut scene = Scene::new();
    let (l, force) = (scene.design("l", 1.0), scene.control("force"));
    let whole = scene.body("whole", 1.0, 0.1, [0.0; 3]);
    let body = scene.body("infinite", (l + f64::INFINITY) * 2.0, 0.1, [0.0; 3]);
    for of in [body, whole] {
        scene.end_state(of.coordinates[0]);
        scene.reading(&format!("seen {:?}", of.coordinates[1].index()), of.coordinates[1], 1, 0.0, 1.0);
    }
    scene.effort("effort", force, (l + f64::INFINITY) * 2.0);
    let file = SceneFile::from_json(&scene.to_json().expect("a file")).expect("a scene");
    assert_eq!(file.left_out, ["infinite", "end state of infinite.x", "seen 4", "effort"]);
    let system = file.scene.compile().expect("a system");
    let names: Vec<&str> = (0..system.outputs()).map(|k| system.output_name(k)).collect();
    assert_eq!(names, ["value of whole.x at the end", "rate of whole.x at the end", "seen 1"]);
}
