//! Scenes in space, along axes and with events as files: every kind comes back as it was, to the last bit.
use crate::common::{assert_says, files};
use hamiltonian_adjoint::axis::Axis;
use hamiltonian_adjoint::planar::{self, Constant, ConstantSpeed, Harmonic};
use hamiltonian_adjoint::spatial::{Body, Inertia, Load, Marker, MarkerForce, MarkerPoint, Quantity, Spatial};
use hamiltonian_adjoint::{
    Grid, Inputs, Multiplier, Param, Scalar, Scene, SceneFile, Settings, Start, Sum, System, simulate,
};
use nalgebra::{DMatrix, UnitQuaternion, Vector3};
use proptest::prelude::*;
use serde_json::Value;
use std::collections::BTreeSet;

const QUANTITIES: [Quantity; 8] = [
    Quantity::Position,
    Quantity::Velocity,
    Quantity::Acceleration,
    Quantity::XAxis,
    Quantity::YAxis,
    Quantity::ZAxis,
    Quantity::AngularVelocity,
    Quantity::AngularAcceleration,
];

const ROUGH: [f64; 6] = [0.11, 0.12, 0.13, 0.01, -0.02, 0.03];

/// All joints, forces, outputs and cuts, with parameters of all forms.
fn tree() -> Scene {
    let mut scene = Scene::new();
    let [l, m, a] = [("l", 0.5), ("mass of it", 1.5), ("a", 0.3)].map(|(name, value)| scene.design(name, value));
    let [thrust, torque, ram, motor] = ["thrust", "torque", "ram", "motor"].map(|name| scene.control(name));
    let flat = scene.body("flat", m, l * l * 0.3, [0.3, -0.2, 0.4]);
    let mut space = scene.spatial();
    space.gravity((0.1, -(m * 0.2), (l * a).sin() - 9.81));
    let ground = Body::GROUND;
    let rough = Inertia::new(m * 1.1, ROUGH.map(|x| m * x + l * l * 0.01 + 0.02 * a.cos()));
    let base = space.body("base", Inertia::cuboid(m, (l, l * 0.4, 0.2)));
    space.fixed("anchor", ground.at((1.0, 0.0, l)).turned((a, 0.2, -a)), base.origin());
    let arm = space.body("arm", rough.centred_at((0.0, l * 0.5, -0.1)));
    let hinge = space.revolute("hinge", base.origin().along((0.0, a, 1.0)), arm.at((0.0, 0.0, l)).along([0.0, 0.1, -1.0]));
    let sled = space.body("sled", Inertia::sphere(m, l - 0.2));
    let slide = space.prismatic("slide", base.at((l, 0.0, 0.0)), sled.origin());
    let wheel = space.body("wheel", Inertia::principal(0.3, [0.01, 0.02, 0.03]).unchecked());
    space.dependent_revolute("gear", arm.origin(), wheel.at([0.1, 0.0, 0.0]), hinge.angle, (l * -2.0, 0.1));
    let rack = space.body("rack", Inertia::point(a + 0.1));
    space.dependent_prismatic("rack drive", sled.origin(), rack.origin(), hinge.angle, (0.2, a * l));
    let cross = space.body("cross", Inertia::cuboid(0.4, [0.1, 0.2, 0.3]));
    let toward = arm.at([0.0, 0.1, 0.2]).along_and_toward((1.0, a, 0.0), (0.0, l, 1.0));
    space.universal("cardan", toward, cross.at([0.0, 0.0, 0.3]));
    let tube = space.body("tube", rough);
    space.cylindrical("sleeve", sled.at([0.1, 0.0, 0.0]).along([1.0, 0.0, 0.2]), tube.origin());
    let puck = space.body("puck", rough);
    let table = space.planar("table", ground.at([2.0, 0.0, 0.0]), puck.origin());
    let load = space.body("load", Inertia::cuboid(0.2, [0.1, 0.1, 0.1]));
    let cell = space.load_cell("cell", puck.at([0.0, 0.0, 0.2]), load.origin());
    let top = space.body("top", rough);
    let socket = space.ball("socket", tube.at([0.0, 0.0, 0.2]), top.at([0.1, 0.0, 0.0]));
    let kite = space.body("kite", rough);
    space.free("flight", arm.origin(), kite.origin());
    let carrier = space.planar_body("carrier", flat);
    let rider = space.body("rider", rough);
    space.revolute("saddle", carrier.at([0.1, 0.2, 0.0]).along([1.0, 0.0, 0.0]), rider.origin());
    let mut outer = ground.at([3.0, 0.0, 0.0]);
    for k in 0..4 {
        let link = space.body(&format!("link {k}"), Inertia::cuboid(0.4, (0.1, 0.1, l)));
        space.revolute(
            &format!("joint {k}"),
            outer.along([0.0, 1.0, 0.1]),
            link.at((0.0, 0.0, l * 0.5)).along([0.0, 1.0, 0.0]),
        );
        if k == 1 {
            space.cut("cut", link);
        }
        outer = link.at((0.0, 0.0, l * -0.5));
    }
    space.thrust("jet", kite.at((0.1, 0.0, l)).along([1.0, 0.0, 1.0]), thrust);
    space.torque("twist", tube.origin(), top.origin().along([0.0, 1.0, 0.0]), torque);
    space.applied_in_space("wind", top.origin(), (0.1, a, -0.2), [0.0, 0.01, 0.0]);
    space.applied_on_body("tug", rider.at([0.0, 0.1, 0.0]), [0.1, 0.2, 0.3], (a * 0.1, 0.0, 0.0));
    space.two_point_actuator("ram", ground.at([2.0, 1.0, 0.5]), puck.at([0.1, 0.0, 0.0]), ram);
    space.spring_damper("spring", ground.at([0.0, 2.0, 0.0]), kite.origin(), (20.0, l, a * 0.3));
    space.spring_damper("slack", kite.at([0.0, 0.0, 0.1]), arm.at([0.0, 0.3, 0.1]), [5.0, 0.0, 0.0]);
    for quantity in QUANTITIES {
        space.outputs(&format!("{quantity:?}"), quantity, top.at((0.0, l, 0.0)), Sum::Integral);
    }
    for (k, sum) in [Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Terminal].into_iter().enumerate() {
        space.rotation_error(&format!("turn {k}"), kite.origin().along([0.0, 1.0, 1.0]), arm.origin(), sum);
    }
    space.outputs("seen at 3", Quantity::Position, outer, Sum::Node(3));
    scene.place_rotation(socket.orientation, UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.4));
    scene.place(hinge.angle, 0.2);
    along_axes(&mut scene, (hinge.angle, slide.offset, table.offsets[1]), motor);
    scene.effort("effort", motor, l * 0.1);
    assert_eq!((scene.body_in_space_named("top"), scene.body_in_space_named("nobody")), (Some(top), None));
    assert_eq!(cell.force[0].index() + 5, cell.torque[2].index());
    scene
}

type Coordinates = (hamiltonian_adjoint::Coordinate, hamiltonian_adjoint::Coordinate, hamiltonian_adjoint::Coordinate);

/// All parts along axes: single coordinates, and combinations with factors of all forms.
fn along_axes(scene: &mut Scene, (angle, offset, side): Coordinates, motor: hamiltonian_adjoint::Control) {
    let k = scene.design("stiffness", 30.0);
    let ratio = scene.design("gear ratio", 3.0);
    let both = Axis::difference(angle, ratio * 0.5, offset);
    scene.motor("motor", angle, motor);
    scene.axis_force("push", both.clone(), Harmonic, [0.0.into(), k * 0.01, 5.0.into(), 0.2.into()]);
    scene.axis_spring_damper("belt", both, k, 0.1, k * 0.01);
    scene.axis_coulomb_friction("dry", offset, 0.2, ratio * 0.1);
    scene.axis_end_stop("hard stop", offset, [(-0.1).into(), ratio * 0.1], [k.into(), 0.1.into(), 0.0.into()]);
    scene.axis_end_stop("soft stop", angle, [-0.1, 0.2].map(Into::into), [k.into(), 0.1.into(), 0.02.into()]);
    scene.rotor("rotor", [(angle, ratio * 1.0), (side, 2.0.into())], 0.01, ratio);
    let [x, y, z] = scene.coordinates("shaft", ["x", "y", "z"]);
    [x, y, z].into_iter().enumerate().for_each(|(i, q)| scene.rotor(&format!("wheel {i}"), q, 0.1, 1.0));
    scene.linear_relation("relation", [(x, ratio * 1.0), (y, 0.5.into()), (side, 0.1.into())], 0.0);
    scene.driven_axis("drive", z, ConstantSpeed, [0.0.into(), ratio / 7.0]);
    scene.draw_spring("picture", planar::Body::GROUND.at(0.0, 1.0), planar::Body::GROUND.at(ratio * 0.1, 0.0));
    scene.draw_rod("picture", planar::Body::GROUND.at(0.0, 1.0), planar::Body::GROUND.at(1.0, 0.0));
}

/// Bodies that move freely, each held by one kind of constraint.
fn loops() -> Scene {
    let mut scene = Scene::new();
    let (l, m) = (scene.design("l", 0.5), scene.design("m", 1.5));
    let mut space = scene.spatial();
    space.gravity([0.0, 0.3, -9.81]);
    let mut held = |name: &str, hold: &mut dyn FnMut(&mut Spatial, Marker, Marker) -> Vec<Multiplier>| {
        let body = space.body(name, Inertia::new(m, ROUGH.map(|x| l * x + 0.01 * x)));
        let place = Body::GROUND.at((l, 0.0, m)).along((0.1, l, 1.0));
        space.free(&format!("motion of {name}"), place, body.origin());
        let all = hold(&mut space, place, body.origin());
        let driven = space.body(&format!("{name}'s weight"), Inertia::point(0.2));
        space.fixed(&format!("{name}'s bolt"), body.at([0.3, 0.0, 0.1]), driven.origin());
        all.len()
    };
    let counts = [
        held("ball", &mut |space, a, b| space.close_ball("ball loop", a, b).to_vec()),
        held("parallel", &mut |space, a, b| space.close_parallel("parallel loop", a, b).to_vec()),
        held("revolute", &mut |space, a, b| space.close_revolute("revolute loop", a, b).to_vec()),
        held("cylindrical", &mut |space, a, b| space.close_cylindrical("cylindrical loop", a, b).to_vec()),
        held("prismatic", &mut |space, a, b| space.close_prismatic("prismatic loop", a, b).to_vec()),
        held("fixed", &mut |space, a, b| space.close_fixed("fixed loop", a, b).to_vec()),
        held("plane", &mut |space, a, b| space.point_on_plane("plane loop", a, b).to_vec()),
        held("line", &mut |space, a, b| space.point_on_line("line loop", a, b).to_vec()),
    ];
    assert_eq!(counts, [3, 2, 5, 4, 5, 6, 1, 2]);
    let tip = |b: Marker| b.body().at((0.0, l, 0.0));
    held("rod", &mut |space, a, b| space.distance("rod loop", a, tip(b), l).to_vec());
    held("jack", &mut |space, a, b| {
        space.driven_distance("jack loop", a, tip(b), Harmonic, [l.into(), 0.1.into(), 3.0.into(), 0.0.into()]).to_vec()
    });
    held("ram", &mut |space, a, b| space.driven_distance("ram loop", a, tip(b), Constant, [l.into()]).to_vec());
    scene
}

/// A mass over a floor that a growing force lifts, and what an event does to its contact.
fn floor(act: impl FnOnce(&mut Scene, planar::RigidContact), lift: bool) -> Scene {
    let mut scene = Scene::new();
    let m = scene.design("m", 2.0);
    let height = if lift { 0.0 } else { 1.0 };
    let ball = scene.particle("ball", m, [0.1, height]);
    scene.gravity(0.0, -9.81);
    let force = [0.0.into(), m * if lift { 20.0 } else { 0.1 }];
    scene.applied_force("lift", ball.point(), std::f64::consts::FRAC_PI_2, ConstantSpeed, force);
    let ground = planar::Body::GROUND.at(0.0, 0.0);
    let contact = scene.rigid_contact("floor", ground, std::f64::consts::FRAC_PI_2, ball.point());
    act(&mut scene, contact);
    scene.event_time("time", 0);
    scene.event_impulse("impulse", contact.equation, 0);
    scene.end_state(ball.coordinates[1]);
    scene
}

/// Everything that events do, each with the number of steps of length zero that it needs.
fn events() -> Vec<(Scene, &'static str, usize)> {
    let impact = floor(
        |scene, contact| {
            let restitution = scene.design("restitution", 0.8);
            scene.impact_at(contact.event, contact.equation, restitution * 0.9);
        },
        false,
    );
    let close = floor(
        |scene, contact| {
            scene.close_at(contact.event, &[contact.equation]);
        },
        false,
    );
    let hold = floor(
        |scene, contact| {
            scene.hold_at(contact.event, &[contact.equation]);
        },
        false,
    );
    let open = floor(
        |scene, contact| {
            let event = scene.reaction_event("off", contact.equation);
            scene.open_at(event, &[contact.equation]);
        },
        true,
    );
    vec![(impact, "floor", 2), (close, "floor", 1), (hold, "floor", 1), (open, "off", 1)]
}

/// The scene that is read from the file of a scene, and the file.
fn copied(scene: &Scene) -> (Scene, String) {
    let json = scene.to_json().expect("a file");
    let file = SceneFile::from_json(&json).unwrap_or_else(|error| panic!("{error}\n{json}"));
    assert!(file.left_out.is_empty(), "{:?}", file.left_out);
    assert_eq!(file.scene.to_json().expect("a file"), json, "written again it is the same");
    (file.scene, json)
}

/// Asserts that a scene is the same after it was written and read, along a short motion whose inputs may be changed.
fn assert_same(scene: Scene, change: impl Fn(&Scene, &mut Inputs)) {
    let inputs = |scene: &Scene, system: &System| {
        let mut inputs = Inputs { start: Start::assembled(system), ..Inputs::at_rest(system, Grid::uniform(8, 0.01)) };
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (i as f64).sin());
        change(scene, &mut inputs);
        inputs
    };
    copied(&scene);
    assert_eq!(files::compared("a scene in space", &scene, &inputs), files::Copied::Same);
    let system = scene.clone().compile().expect("a system");
    assert!(simulate(&system, &inputs(&scene, &system), Settings::default()).expect("a motion").q.amax() > 0.0);
}

#[test]
fn trees_and_axes_come_back_to_the_last_bit() {
    assert_same(tree(), |_, _| {});
}

#[test]
fn loops_come_back_to_the_last_bit() {
    assert_same(loops(), |_, _| {});
}

#[test]
fn events_come_back_to_the_last_bit() {
    for (scene, event, zeros) in events() {
        let grid = Grid::new(0.0, [vec![0.032; 14], vec![0.0; zeros], vec![0.03; 10]].concat());
        assert_same(scene, |scene, inputs| {
            inputs.controls = DMatrix::zeros(0, grid.steps.len() + 1);
            inputs.grid = grid.clone();
            inputs.events = vec![scene.event_named(event).expect("an event").at(14)];
        });
    }
}

/// Scenes that contain all kinds of ready-made parts.
pub fn all() -> Vec<Scene> {
    let events = events().into_iter().map(|(scene, ..)| scene);
    [super::scenes::everything(), tree(), loops()].into_iter().chain(events).collect()
}

#[test]
fn the_scenes_of_these_tests_contain_all_kinds() {
    let mut kinds = BTreeSet::new();
    for scene in all() {
        let file: Value = serde_json::from_str(&copied(&scene).1).expect("JSON");
        let parts = file["parts"].as_array().expect("parts");
        kinds.extend(parts.iter().map(|part| part["kind"].as_str().expect("a kind").to_string()));
    }
    // Formulas of users are tested elsewhere.
    let formulas = ["kinetic energy", "potential energy", "force", "constraint", "cost", "output", "term", "event"];
    kinds.extend(formulas.map(String::from));
    let known: BTreeSet<String> = SceneFile::kinds().map(|kind| kind.name.to_string()).collect();
    assert_eq!(known.len(), SceneFile::kinds().count(), "names of kinds are unique");
    assert_eq!(kinds, known);
}

/// The order in which expressions were created is not that of the parts that contain them.
#[test]
fn expressions_in_any_order_come_back_to_the_last_bit() {
    let mut scene = Scene::new();
    let [l, m, r] = [("l", 0.7), ("m", 1.3), ("r", 0.3)].map(|(name, value)| scene.design(name, value));
    let sums: Vec<Param> = (0..12).map(|k| (l * (0.1 + f64::from(k))).sin() * m + r.exp() * l * r / 3.0).collect();
    let all = sums.iter().rev().fold(l * m * r, |all, sum| *sum * *sum * 0.1 + all);
    let mut space = scene.spatial();
    space.gravity((0.0, sums[3], sums[2] - 9.81));
    let mut outer = Body::GROUND.at((r, sums[0], 0.0));
    for k in 0..4 {
        let [a, b] = [sums[11 - k] * 0.1, sums[5 - k]];
        let body = space.body(&format!("body {k}"), Inertia::cuboid(all + b * b, (l, b * b * 0.1 + a * a, r)));
        space.universal(&format!("joint {k}"), outer.along((a, 1.0, b)), body.at((b, r, all)).turned((b, a * l, 0.1)));
        outer = body.at((a, l * r * m, b));
    }
    space.outputs("place", Quantity::Position, outer, Sum::Terminal);
    assert_same(scene, |_, _| {});
}

/// The machines of two examples.
#[test]
fn a_gyroscope_and_a_four_bar_linkage_come_back_to_the_last_bit() {
    let mut scene = Scene::new();
    let weight = scene.design("weight", 0.2);
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let [outer, inner, rotor] = [("outer ring", 0.3), ("inner ring", 0.2), ("rotor", 1.5)]
        .map(|(name, mass)| space.body(name, Inertia::principal(mass, [1e-3 * mass, 2e-3, 2e-3])));
    let load = space.body("load", Inertia::point(weight));
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let precession = space.revolute("outer bearing", Body::GROUND.origin().along(z), outer.origin().along(z));
    let tilt = space.revolute("inner bearing", outer.origin().along(x), inner.origin().along(x));
    space.revolute("axle", inner.origin().along(y), rotor.origin().along(y));
    space.fixed("hook", inner.at([0.0, 0.1, 0.0]), load.origin());
    scene.axis_spring_damper("grease", tilt.angle, 0.0, 0.0, 0.3);
    scene.end_state(precession.angle);
    assert_same(scene, |scene, inputs| {
        inputs.start.set_rate(scene.coordinate_named("axle.angle").expect("an axle"), 200.0);
    });

    let mut scene = Scene::new();
    let [crank, rod, rocker, side] =
        [("crank", 0.12), ("rod", 0.6), ("rocker", 0.35), ("y", 0.1)].map(|(name, value)| scene.design(name, value));
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let [of_crank, of_rod, of_rocker] = [("crank", crank), ("rod", rod), ("rocker", rocker)]
        .map(|(name, l)| space.body(name, Inertia::cuboid(l * 1.5, (l, 0.03, 0.03)).centred_at((l * 0.5, 0.0, 0.0))));
    let drive = space.revolute("drive", Body::GROUND.origin(), of_crank.origin());
    let elbow = of_crank.at((crank, 0.0, 0.0)).along_and_toward([-1.0, 0.0, 0.0], z);
    space.universal("elbow", elbow, of_rod.origin().along_and_toward([-1.0, 0.0, 0.0], z));
    let pivot = space.revolute("pivot", Body::GROUND.at((0.5, side, 0.3)).along(y), of_rocker.origin().along(y));
    space.close_ball("end", of_rod.at((rod, 0.0, 0.0)), of_rocker.at((rocker, 0.0, 0.0)));
    scene.driven_axis("motor", drive.angle, ConstantSpeed, [0.0.into(), 6.0.into()]);
    scene.place(pivot.angle, 1.5);
    scene.end_state(pivot.angle);
    assert_same(scene, |_, _| {});
}

/// −v.
struct Drag;

impl MarkerForce for Drag {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        loads[0].force = at.markers[0].velocity.map(|v| -v);
    }
}

#[test]
fn what_belongs_to_parts_that_are_left_out_is_left_out() {
    let mut scene = Scene::new();
    let l = scene.design("l", 1.0);
    let mut space = scene.spatial();
    let [odd, whole] = [("odd", (l + f64::INFINITY) * 2.0), ("whole", l * 1.0)]
        .map(|(name, mass)| space.body(name, Inertia::principal(mass, [0.1; 3])));
    let hinge = space.revolute("odd hinge", Body::GROUND.origin(), odd.origin());
    let slide = space.prismatic("slide", Body::GROUND.origin(), whole.origin());
    space.spring_damper("odd spring", odd.origin(), whole.at([1.0, 0.0, 0.0]), [1.0, 0.5, 0.0]);
    space.force("drag", Drag, &[whole.origin()], &[], &[]);
    let [rope] = space.distance("odd rope", odd.at([0.0, 0.0, 1.0]), Body::GROUND.origin(), 1.0);
    scene.axis_spring_damper("odd belt", Axis::difference(hinge.angle, 1.0, slide.offset), 1.0, 0.0, 0.0);
    scene.axis_spring_damper("bumper", slide.offset, 1.0, 0.0, 0.0);
    let event = scene.reaction_event("odd event", rope);
    scene.open_at(event, &[rope]);
    scene.event_impulse("odd impulse", rope, 0);
    scene.event_time("time", 0);
    let file = SceneFile::from_json(&scene.to_json().expect("a file")).expect("a scene");
    let odd = ["odd", "odd hinge", "odd spring", "odd rope", "odd belt", "odd event", "odd event", "odd impulse"];
    assert_eq!(file.left_out, odd);
    let system = file.scene.compile().expect("a system");
    assert_eq!((system.n(), system.m(), system.output_name(0)), (1, 0, "time"));
}

#[test]
fn what_is_wrong_in_space_is_named_with_its_place() {
    let json = tree().to_json().expect("a file");
    let all: Value = serde_json::from_str(&json).expect("JSON");
    // The file with another value of an entry of a part, or without the entry.
    let changed = |name: &str, path: &str, value: Option<Value>| {
        let mut all = all.clone();
        let parts = all["parts"].as_array_mut().expect("parts");
        let part = parts.iter_mut().find(|part| part["name"] == name).unwrap_or_else(|| panic!("{name}"));
        let (within, last) = path.rsplit_once('/').map_or(("", path), |(within, last)| (within, last));
        let object = part.pointer_mut(within).and_then(Value::as_object_mut).expect("an entry");
        match value {
            Some(value) => drop(object.insert(last.into(), value)),
            None => drop(object.remove(last).expect("an entry")),
        }
        SceneFile::from_json(&all.to_string())
    };
    let text = |text: &str| Some(serde_json::from_str::<Value>(text).expect("JSON"));
    let refused = |name: &str, path: &str, value: Option<Value>, words: &[&str]| {
        let error = changed(name, path, value).map(|_| ()).expect_err(path);
        assert_says(&error, &[&[&format!("`{name}`")[..]], words].concat());
    };
    refused("hinge", "/b", None, &["`b` is missing"]);
    refused("hinge", "/b/body", text("\"nobody\""), &["`b`", "no body in space `nobody`"]);
    refused("hinge", "/b/at", text("[1, 2]"), &["`b`", "`at` must have 3 numbers"]);
    refused("hinge", "/b/along", text("[1, 2, \"q\"]"), &["`b`", "`along`", "no design variable is called `q`"]);
    refused("hinge", "/b/toward", None.or(text("1")), &["`b`", "`toward` must be a list"]);
    refused("slide", "/b/toward", text("[1, 0, 0]"), &["`b`", "the field `toward` does not exist"]);
    refused("hinge", "/b/turned", text("[1, 0, 0]"), &["`b`", "the field `along` does not exist"]);
    refused("arm", "/inertia", text("[1, 2, 3, 4, 5]"), &["`inertia` must have 6 numbers"]);
    refused("arm", "/mass", None, &["`mass` is missing"]);
    refused("wheel", "/unchecked", text("1"), &["`unchecked` must be true or false"]);
    refused("gear", "/of", text("\"hinge.offset\""), &["no coordinate `hinge.offset`"]);
    refused("cut", "/body/at", text("[0, 0, 0]"), &["`body`", "the field `at` does not exist"]);
    refused("jet", "/force", text("\"jets\""), &["no control `jets`"]);
    refused("wind", "/force", text("[1, 2]"), &["`force` must have 3 numbers"]);
    refused("Position", "/quantity", text("\"place\""), &["`quantity` must be one of position, velocity"]);
    refused("Position", "/sum", text("\"all\""), &["`all` is not one of the sums plain"]);
    refused("Position", "/sum", text("{\"node\": -1}"), &["`sum`", "`node` must be"]);
    refused("Position", "/sum", text("{\"nodes\": 1}"), &["`sum`", "`node`, `event` or `after event` is expected"]);
    refused("Position", "/sum", text("{\"node\": 1, \"event\": 1}"), &["`sum`", "the field `event` does not exist"]);
    refused("belt", "/axis", text("3"), &["`axis` must be a list"]);
    refused("belt", "/axis", text("[{\"coordinate\": \"hinge.angle\"}]"), &["`axis`", "`factor` is missing"]);
    refused("belt", "/axis", text("[{\"coordinate\": \"x\", \"factor\": 1}]"), &["`axis`", "no coordinate `x`"]);
    // What the scene itself refuses.
    let odd = |name: &str, path: &str, value: &str, words: &[&str]| {
        let scene = changed(name, path, text(value)).expect("a file").scene;
        assert!(scene.to_json().is_err() || scene.clone().compile().is_err());
        assert_says(&scene.compile().map(|_| ()).expect_err(path), &[&[&format!("`{name}`")[..]], words].concat());
    };
    odd("hinge", "/b/along", "[0, 0, 0]", &["the length of an axis"]);
    odd("cardan", "/a/toward", "[1, \"a\", 0]", &["parallel"]);
    odd("wheel", "/mass", "-1", &["mass"]);
    odd("base", "/inertia", "[1, 1, 3, 0, 0, 0]", &[]);
    odd("cut", "/body", "{}", &[]);
    odd("flight", "/b/body", "\"arm\"", &[]);
    odd(
        "rotor",
        "/axis",
        "[{\"coordinate\": \"hinge.angle\", \"factor\": 1}, {\"coordinate\": \"hinge.angle\", \"factor\": 1}]",
        &[],
    );
}

#[test]
fn equations_and_events_of_strangers_are_named() {
    let (scene, ..) = events().remove(0);
    let json = scene.to_json().expect("a file");
    let change = |from: &str, to: &str| {
        assert!(json.contains(from), "{from}: {json}");
        SceneFile::from_json(&json.replacen(from, to, 1))
    };
    let refused = |from: &str, to: &str, words: &[&str]| {
        assert_says(&change(from, to).map(|_| ()).expect_err(to), words);
    };
    refused("\"equation\": \"floor\"", "\"equation\": \"floor.1\"", &["`floor`", "no constraint equation `floor.1`"]);
    refused("\"equation\": \"floor\"", "\"equation\": 0", &["`floor`", "`equation` must be a string"]);
    let other =
        json.replacen("\"name\": \"floor\",\n      \"restitution\"", "\"name\": \"roof\",\n      \"restitution\"", 1);
    assert_says(&SceneFile::from_json(&other).map(|_| ()).expect_err("no event"), &["no event `roof`"]);
    let far = change("\"event\": 0", "\"event\": 18446744073709551615").expect("a file").scene;
    assert!(far.compile().is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Files that were cut, doubled or changed somewhere: an answer or an error, and never a panic.
    #[test]
    fn broken_scenes_in_space_are_refused_or_read(at in 0.0..1.0f64, len in 0..40usize, with in "[ -~\\n]{0,6}") {
        let text = tree().to_json().expect("a file");
        let from = (at * text.len() as f64) as usize;
        let to = (from + len).min(text.len());
        let broken = format!("{}{with}{}", text.get(..from).unwrap_or(""), text.get(to..).unwrap_or(""));
        if let Ok(file) = SceneFile::from_json(&broken) {
            let _ = file.scene.to_json();
        }
    }
}
