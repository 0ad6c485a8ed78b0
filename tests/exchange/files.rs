//! Inputs, gradients and motions as files: whole round trips, and files of strangers.
use crate::common::assert_says;
use hamiltonian_adjoint::planar::{Body, Revolute};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Error, Grid, Inputs, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System, Table,
    Trajectory, gradient,
};
use nalgebra::{DVector, SVector};
use proptest::prelude::*;
use serde_json::Value;

fn cart() -> System {
    let mut cart = CartPendulum::with_links(2).mechanism();
    let target = cart.scene.design("target <angle>", 0.3);
    cart.scene.cost("aim", AngleError, Sum::Terminal, [cart.links[1].coordinates[2]], [], [], [target.into()]);
    cart.scene.compile().expect("a scene")
}

fn lively(system: &System) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::new(0.1, vec![0.1, 0.2, 1.0 / 3.0]));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (i as f64).sqrt() / 3.0);
    inputs
}

#[test]
fn inputs_come_back_to_the_last_bit() {
    let system = cart();
    let plain = lively(&system);
    let q = system.initial_coordinates();
    let mut momentum = plain.clone();
    momentum.start = Start::Momentum { q: q.clone(), p_star: DVector::from_fn(q.len(), |i, _| 0.1 / (1.0 + i as f64)) };
    let mut assembled = plain.clone();
    assembled.start = Start::assembled(&system).hold(&[system.coordinate(2), system.coordinate(5)]);
    let mut part = plain.clone();
    part.grid = Grid::uniform(9, 0.1).part(2, 5);
    let mut within = plain.clone();
    within.grid = Grid::composed(2, 0.1, Composition::Suzuki4).part(3, 6);
    for inputs in [plain, momentum, assembled, part, within] {
        let json = inputs.to_json(&system).expect("a file");
        let back = Inputs::from_json(&system, &json).expect("the same");
        assert_eq!(back, inputs);
        assert_eq!(back.to_json(&system).expect("a file"), json);
    }
}

#[test]
fn gradients_and_motions_are_written_by_name() {
    let system = cart();
    let inputs = lively(&system);
    let gradient = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    let json: Value = serde_json::from_str(&gradient.to_json(&system).expect("a file")).expect("JSON");
    assert_eq!(json["value"].as_f64(), Some(gradient.value));
    assert_eq!(json["design"]["target <angle>"].as_f64(), Some(gradient.design[0]));
    assert_eq!(json["controls"]["force on the cart"][2].as_f64(), Some(gradient.controls[(0, 2)]));
    let direction = inputs.direction_from_json(&system, &json.to_string()).expect("a direction");
    assert_eq!((&direction.controls, &direction.design), (&gradient.controls, &gradient.design));
    assert_eq!((&direction.start, &direction.grid.steps), (&gradient.start, &gradient.steps));
    assert_eq!((direction.grid.start, direction.grid.stages), (0.0, inputs.grid.stages));
    let part = r#"{"format": "hamiltonian-adjoint gradient", "version": 1, "design": {"target <angle>": 2.0}}"#;
    let direction = inputs.direction_from_json(&system, part).expect("a direction");
    assert_eq!((direction.design[0], direction.controls.amax(), &direction.grid.steps), (2.0, 0.0, &vec![0.0; 3]));

    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("a motion").clone();
    let csv = motion.to_csv(&system, solver.inputs()).expect("a file");
    let table = Table::from_csv(&csv).expect("a table");
    assert_eq!((table.times.len(), table.columns.len()), (4, 3 * system.n() + system.m() + system.k()));
    assert_eq!(table.names[0], "cart.x [m]");
    let angle = table
        .column("p* of link 1.φ")
        .or_else(|_| table.column(&format!("p* of {}", system.coordinate_name(5))))
        .expect("a column");
    assert!(table.names[angle].ends_with("[N m s]"), "{}", table.names[angle]);
    for i in 0..4 {
        assert_eq!(table.columns[0][i], Some(motion.q[(0, i)]), "to the last bit");
        assert_eq!(table.columns[angle][i], Some(motion.p_star[(5, i)]));
    }
}

#[test]
fn columns_of_a_motion_have_their_units_where_they_are_known() {
    let mut scene = Scene::new();
    let [a, b] = ["a", "b"].map(|name| scene.body(name, 1.0, 0.1, [0.0; 3]));
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, a.at(0.0, 0.0), 0.0);
    scene.revolute("hinge (equation 1)", a.at(0.0, 0.0), b.at(0.0, 0.0));
    let ([x, y, phi], [x_b, y_b, phi_b]) = (a.coordinates, b.coordinates);
    scene.constraint("own", Revolute, [x, y, phi, x_b, y_b, phi_b], [0.0.into(); 4]);
    let [force, torque, both, _] = ["force", "torque", "both", "none"].map(|name| scene.control(name));
    scene.actuator("pusher", Body::GROUND.at(0.0, 0.0), 0.0, a.at(0.0, 0.0), force);
    scene.two_point_actuator("cylinder", Body::GROUND.at(1.0, 0.0), b.at(0.1, 0.0), both);
    scene.torque_actuator("motor", a, b, torque);
    scene.torque_actuator("another motor", a, b, both);
    let system = scene.compile().expect("a scene");
    let motion = Trajectory::zeros(&system, 1, Scheme::TRAPEZOIDAL);
    let csv = motion.to_csv(&system, &Inputs::at_rest(&system, Grid::uniform(0, 1.0))).expect("a file");
    let header: Vec<&str> = csv.trim_end().split(',').collect();
    let expected = [
        "σ of `rail` (equation 0) [N s]",
        "σ of `rail` (equation 1) [N m s]",
        "σ of `hinge (equation 1)` (equation 0) [N s]",
        "σ of `hinge (equation 1)` (equation 1) [N s]",
        "σ of `own` (equation 0)",
        "σ of `own` (equation 1)",
        "force [N]",
        "torque [N m]",
        "both",
        "none",
    ];
    assert_eq!(header[1 + 3 * system.n()..], expected);
}

#[test]
fn names_that_are_formulas_are_made_harmless() {
    let mut scene = Scene::new();
    let body = scene.body("=cmd()", 1.0, 0.1, [0.0; 3]);
    let force = scene.control("@SUM(1,\"2\")\n");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.0, 0.0), force);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(2, 0.1));
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("a motion").clone();
    let csv = motion.to_csv(&system, &inputs).expect("a file");
    let table = Table::from_csv(&csv).expect("a table");
    assert!(table.names.iter().all(|name| !name.starts_with(['=', '@', '+', '-'])), "{:?}", table.names);
    assert!(table.names.iter().any(|name| name.contains("\"2\"")), "quotes come back: {:?}", table.names);
    let json = inputs.to_json(&system).expect("a file");
    assert_eq!(Inputs::from_json(&system, &json).expect("the same"), inputs);
}

#[test]
fn what_is_wrong_in_inputs_is_named_with_its_place() {
    let system = cart();
    let json = lively(&system).to_json(&system).expect("a file");
    let read = |json: &str| Inputs::from_json(&system, json).expect_err("a wrong file");
    assert_says(&read(&json.replacen("\"steps\"", "\"step\"", 1)), &["line 6", "column", "unknown field `step`"]);
    assert_says(&read(&json[..json.len() / 2]), &["line", "column", "EOF"]);
    assert_says(&read(&json.replacen("\"cart.x\"", "\"cart.z\"", 1)), &["start.q", "no value for `cart.x`"]);
    let strange = json.replacen("\"cart.y\"", "\"cart.w\": 1, \"cart.v\": 1, \"cart.y\"", 1);
    assert_says(&read(&strange), &["start.q", "the system has nothing called `cart.w`"]);
    assert_says(&read(&json.replacen("\"cart.y\": 0.0", "\"cart.x\": 0.0", 1)), &["`cart.x` occurs twice here"]);
    assert_says(&read(&json.replacen("\"version\": 1", "\"version\": 2", 1)), &["version 2", "expected", "version 1"]);
    assert_says(&read(&json.replacen("\"stages\": 1", "\"stages\": 0", 1)), &["Grid::stages"]);
    let mut short: Value = serde_json::from_str(&json).expect("JSON");
    short["controls"]["force on the cart"].as_array_mut().expect("a list").pop();
    assert_says(&read(&short.to_string()), &["force on the cart", "3 values for 4 nodes"]);
    short["controls"]["force on the cart"] = serde_json::json!([1, 2, null, 4]);
    assert!(matches!(read(&short.to_string()), Error::File { .. }));
    for around in ["[18446744073709551615, 0]", "[9223372036854775807, 9223372036854775805]"] {
        let endless = json.replacen("\"stages\"", &format!("\"around\": {around}, \"stages\""), 1);
        let error = read(&endless);
        assert!(matches!(error, Error::Parameter { .. }), "{error:?}");
        assert_says(&error, &["`Grid::around`", "can be counted"]);
    }
    let mut far = lively(&system);
    far.grid.around = [usize::MAX, 0];
    assert_eq!(far.grid.part(1, 2).around, [usize::MAX, 1]);
    let largest = json.replacen("\"stages\"", "\"around\": [9223372036854775807, 9223372036854775804], \"stages\"", 1);
    let inputs = Inputs::from_json(&system, &largest).expect("as many nodes as can be counted");
    assert!(Solver::new(&system, Settings::default()).simulate(&inputs).is_ok());
}

#[test]
fn a_grid_through_times_steps_from_each_to_the_next() {
    for (times, longest, steps) in [
        (&[0.0, 1.0, 2.0][..], f64::INFINITY, &[1.0, 1.0][..]),
        (&[0.0, 1.0, 2.0], 1e3, &[1.0, 1.0]),
        (&[0.0, 1e-300, -1e-300], 1e300, &[1e-300, -2e-300]),
        (&[0.0, 0.0, 1.0], f64::INFINITY, &[1.0]),
        (&[1.0, 2.0, 1.5], 0.5, &[0.5, 0.5, -0.5]),
    ] {
        assert_eq!(Grid::through(times, longest).expect("a grid").steps, steps, "{times:?}, {longest}");
    }
}

#[test]
fn what_is_wrong_in_a_table_is_named_with_its_line() {
    let read = |csv: &str| Table::from_csv(csv).expect_err("a wrong table");
    assert_says(&read(""), &["line 1", "no column"]);
    assert_says(&read("t,x\n"), &["no rows"]);
    assert_says(&read("t,x\n0,1\n1,one\n"), &["line 3", "column 2", "`one`"]);
    assert_says(&read("t,x\n0,1\n1\n"), &["line 3", "1 cells", "has 2"]);
    assert_says(&read("t,x\n0,1\n0,2\n"), &["line 3", "not later"]);
    assert_says(&read("t,x\n0,inf\n"), &["line 2", "not a finite number"]);
    assert_says(&read("t,x,x\n0,1,2\n"), &["`x`"]);
    assert_says(&read("t,x,y\n0,1,\n"), &["`y` has no values"]);
    for (first, other) in [("x", "t"), ("", "Time [s]"), ("u", "t (s)")] {
        let error = read(&format!("{first},y,{other}\n0,1,2\n"));
        assert_says(
            &error,
            &["line 1", &format!("column 3 is called `{other}`"), &format!("first column, called `{first}`")],
        );
    }
    for (name, unit) in [("t [ms]", "`ms`"), ("time[min]", "`min`"), ("t [1]", "`1`"), ("t (µs)", "`µs`"), ("t / h", "`h`")]
    {
        let error = read(&format!("{name},x\n0,1\n"));
        assert_says(&error, &["line 1", "column 1", name, unit, "expected `s`"]);
    }
    for name in ["t", "t [s]", "time [ s ]", "t []", "t (relative)", "t (s)", "", "t/T"] {
        assert_eq!(Table::from_csv(&format!("{name},x\n0,1\n")).expect("a table").times, [0.0], "{name}");
    }
    assert_eq!(Table::from_csv("timestamp,t\n0,1\n").expect("a table").times, [0.0]);
    let table = Table::from_csv("t [s], x [m]\n1,2\n2,4\n").expect("a table");
    assert_eq!([0.0, 1.25, 9.0].map(|t| table.value(0, t)), [2.0, 2.5, 4.0]);
    assert_says(&table.column("z").expect_err("no column"), &["`z`", "x [m]"]);
}

#[test]
fn a_table_has_the_values_of_its_rows_and_nothing_beyond_them() {
    let table = Table::from_csv("t,x\n0,1e17\n1,1\n2,-1.7e308\n3,1.7e308\n").expect("a table");
    assert_eq!([0.0, 1.0, 2.0, 2.5, 3.0].map(|t| table.value(0, t)), [1e17, 1.0, -1.7e308, 0.0, 1.7e308]);
    let constant = Table::from_csv("t,x\n0,5.13771663187637\n1,5.13771663187637\n").expect("a table");
    assert!((0..1000).all(|k| constant.value(0, 1e-3 * f64::from(k)) == 5.13771663187637));
}

#[test]
fn columns_that_differ_in_their_units_alone_are_told_apart() {
    let table = Table::from_csv("t,a [m],a [N],b\n0,1,2,3\n").expect("a table");
    assert_says(&table.column("a").expect_err("two"), &["more than one", "`a`", "a [m], a [N]"]);
    assert_eq!(["a [m]", "a [N]", "b"].map(|name| table.column(name).expect("one")), [0, 1, 2]);
}

#[test]
fn readings_belong_to_nodes_of_the_grid() {
    let table = Table::from_csv("t,x\n0,1\n0.1,2\n").expect("a table");
    let readings = |grid: &Grid| table.readings(0, grid);
    assert_eq!(readings(&Grid::uniform(2, 0.05)).expect("readings"), [(0, 1.0), (2, 2.0)]);
    let jumping = Grid::new(0.0, vec![0.1, 0.0, 0.1]);
    assert_eq!(readings(&jumping).expect("readings"), [(0, 1.0), (1, 2.0)]);
    assert_says(&readings(&Grid::uniform(0, 0.05)).expect_err("one node"), &["`x`", "0.1 s", "no node"]);
    // Steps back and forth: the node that is nearest, of those at the same time the first.
    let there_and_back = Grid::new(-0.125, vec![0.25, -0.125, 0.125, -0.025, -0.05, 0.05, -0.125]);
    assert_eq!(readings(&there_and_back).expect("readings"), [(2, 1.0), (4, 2.0)]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Files that were cut, doubled or changed somewhere: an answer or an error, and never a panic.
    #[test]
    fn broken_files_are_refused_or_read(at in 0.0..1.0f64, len in 0..40usize, with in "[ -~\\n]{0,6}") {
        let system = cart();
        let inputs = lively(&system).to_json(&system).expect("a file");
        let table = "t [s],x [m],y\n0,1.5,2\n0.5,,3\n1,\"2\",1e3\n".to_string();
        for (k, text) in [inputs, table].into_iter().enumerate() {
            let from = (at * text.len() as f64) as usize;
            let to = (from + len).min(text.len());
            let broken = format!("{}{with}{}", text.get(..from).unwrap_or(""), text.get(to..).unwrap_or(""));
            if k == 0 {
                if let Ok(inputs) = Inputs::from_json(&system, &broken) {
                    prop_assert!(inputs.to_json(&system).is_ok());
                }
            } else if let Ok(table) = Table::from_csv(&broken) {
                prop_assert!((0..table.columns.len()).all(|k| table.value(k, 0.3).is_finite()));
            }
        }
    }
}

/// The coordinate.
struct Place;

impl Cost<1, 0, 0, 0> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

#[test]
fn files_keep_events() -> Result<(), Error> {
    let mut scene = Scene::new();
    let ball = scene.particle("ball", 1.0, [0.0, 1.0]);
    let landing = scene.event("landing", Place, [ball.coordinates[1]], [], [], []);
    let system = scene.compile()?;
    let mut given = Inputs::at_rest(&system, Grid::uniform(20, 0.04));
    given.events = vec![landing.at(11), landing.at(13)];
    let json = given.to_json(&system)?;
    assert_eq!(Inputs::from_json(&system, &json)?, given);
    let wrong = json.replace("landing", "take-off");
    assert_says(&Inputs::from_json(&system, &wrong).expect_err("no such event"), &["`events`", "take-off"]);
    Ok(())
}
