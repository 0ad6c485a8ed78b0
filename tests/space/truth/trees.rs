//! Bodies on hinges without loops: governor, Furuta's pendulum, a chain of universal joints.

use hamiltonian_adjoint::spatial::{Body, Inertia, Load, MarkerForce, MarkerPoint};
use hamiltonian_adjoint::{Error, Mechanics, Param, Scalar, Scene, Scheme, System};

use super::{Case, array, at, at_rest, ends, list, named, number, put, reference};
use crate::common::relative_error;

#[test]
fn a_stiff_governor() -> Result<(), Error> {
    let all = reference("5_governor");
    let (of, given) = (&all["parameters"], &all["start"]);
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity(array::<3>(&of["g"]));
    let inertia = |of: &serde_json::Value, tensor: &str| Inertia::principal(number(&of["mass"]), array::<3>(&of[tensor]));
    let shaft = space.body("shaft", inertia(&of["shaft"], "J_diag").centred_at([0.0, 0.0, 0.5]));
    let slider = space.body("slider", inertia(&of["slider"], "J_diag"));
    let turn = space.revolute("bearing", Body::GROUND.origin(), shaft.origin());
    let slide = space.prismatic("slide", shaft.origin(), slider.origin());
    let spring = &of["spring"];
    let numbers = ["K", "rest", "C"].map(|name| number(&spring[name]));
    let offset = number(&of["hinge_offset"]);
    let hinges = [("1", 1.0), ("2", -1.0)].map(|(name, side)| {
        let rod =
            space.body(&format!("rod {name}"), inertia(&of["rod"], "J_diag_x_along").centred_at([0.5 * side, 0.0, 0.0]));
        let ball = space.body(&format!("ball {name}"), Inertia::point(number(&of["rod"]["point_mass"])));
        let axis = [0.0, side, 0.0];
        let hinge = space.revolute(
            &format!("hinge {name}"),
            shaft.at([side * offset, 0.0, 1.0]).along(axis),
            rod.origin().along(axis),
        );
        space.fixed(&format!("end {name}"), rod.at([side, 0.0, 0.0]), ball.origin());
        space.spring_damper(
            &format!("spring {name}"),
            rod.at([0.5 * side, 0.0, 0.0]),
            slider.at([side * offset, 0.0, 0.0]),
            numbers,
        );
        hinge.angle
    });
    let coordinates = [turn.angle, hinges[0], hinges[1], slide.offset];
    let outputs = ends(&mut scene, &coordinates);
    let system = scene.compile()?;
    let mut start = at_rest(&system);
    let places = named(given, &["shaft_angle", "rod_angles", "slider"]);
    put(&mut start, &coordinates, &places, &named(given, &["shaft_rate", "rod_rates", "slider_rate"]));
    let here = Mechanics::new(&system, start.q().as_slice(), start.rate().as_slice())?;
    let accelerations = system_order(&system, &coordinates, here.accelerations()?.0.as_slice());
    // The springs are stretched by rounding, which their stiffness of 8e5 N/m turns into 1e-10 N.
    let error = relative_error(&accelerations, &list(&given["accelerations"]));
    println!("5 governor: accelerations {error:.1e}");
    assert!(error < 1e-11);
    let end = at(&all["values"], 0.5);
    let truth = named(end, &["shaft_angle", "rod_angles", "slider", "shaft_rate", "rod_rates", "slider_rate"]);
    let case = Case { outputs, ..Case::new("5 governor", system, start, (0.5, truth)) };
    case.assert_order(Scheme::TRAPEZOIDAL, 100, 0.15)?;
    // The stiffness takes their full order from the others until steps resolve it.
    case.assert_close(Scheme::ESDIRK4, 800, 1e-10)?;
    case.assert_close(Scheme::ESDIRK5, 800, 1e-10)
}

/// A vector of the system in the order of these coordinates.
fn system_order(system: &System, coordinates: &[hamiltonian_adjoint::Coordinate], x: &[f64]) -> Vec<f64> {
    assert_eq!(system.n(), coordinates.len());
    coordinates.iter().map(|q| x[q.index()]).collect()
}

/// 0.05 sin 3t about z on the arm; damping on the arm and between arm and pendulum; b = [d, d]. The markers are those of the arm and of the pendulum.
struct Drive;

impl MarkerForce for Drive {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        let [arm, pendulum] = [&at.markers[0], &at.markers[1]];
        let vertical = (at.t * 3.0).sin() * 0.05 - at.b[0] * arm.angular_velocity[2];
        let relative: [S; 3] = std::array::from_fn(|i| pendulum.angular_velocity[i] - arm.angular_velocity[i]);
        let pull = relative.map(|w| w * at.b[1]);
        loads[0].torque = [pull[0], pull[1], pull[2] + vertical];
        loads[1].torque = pull.map(|x| -x);
    }
}

fn furuta(tensors_follow: bool, time: f64) -> Result<Case, Error> {
    let all = reference("7_furuta");
    let of = &all["parameters"];
    let mut scene = Scene::new();
    let length = scene.design("length", number(&of["pendulum"]["length"]));
    let mass = scene.design("mass", number(&of["arm"]["mass"]));
    let pendulum_mass = number(&of["pendulum"]["mass"]);
    let arm_length = number(&of["arm"]["length"]);
    let [_, _, axial] = array::<3>(&of["pendulum"]["J_diag"]);
    let (arm_tensor, tensor): (Param, Param) = match tensors_follow {
        true => (mass * (arm_length * arm_length / 12.0), length * length * (pendulum_mass / 12.0)),
        false => (number(&of["arm"]["J_vertical_centre"]).into(), number(&of["pendulum"]["J_diag"][0]).into()),
    };
    let mut space = scene.spatial();
    space.gravity(array::<3>(&of["g"]));
    let arm =
        space.body("arm", Inertia::principal(mass, (0.0, arm_tensor, arm_tensor)).centred_at([arm_length / 2.0, 0.0, 0.0]));
    let inertia = Inertia::principal(pendulum_mass, (tensor, tensor, axial)).centred_at((0.0, 0.0, length * -0.5));
    let pendulum = space.body("pendulum", inertia);
    let x = [1.0, 0.0, 0.0];
    let a = space.revolute("a", Body::GROUND.origin(), arm.origin());
    let b = space.revolute("b", arm.at([arm_length, 0.0, 0.0]).along(x), pendulum.origin().along(x));
    let damping = array::<2>(&of["damping"]).map(Param::from);
    space.force("drive", Drive, &[arm.origin(), pendulum.origin()], &[], &damping);
    let outputs = ends(&mut scene, &[a.angle, b.angle]);
    let system = scene.compile()?;
    let mut start = at_rest(&system);
    put(&mut start, &[a.angle, b.angle], &named(&all["start"], &["a", "b"]), &[0.0; 2]);
    let here = Mechanics::new(&system, start.q().as_slice(), &[0.0; 2])?;
    assert!(relative_error(here.accelerations()?.0.as_slice(), &list(&all["start"]["accelerations"])) < 1e-14);
    let form = if tensors_follow { "tensors_follow" } else { "tensors_fixed" };
    let truth = named(at(&all["values"], time), &["a", "b", "a_rate", "b_rate"]);
    let rows = at(&all["derivatives"][form], time);
    let derivatives = [(0, "by_pendulum_length"), (1, "by_arm_mass")].map(|(design, name)| (design, list(&rows[name])));
    let derivatives = derivatives.to_vec();
    Ok(Case { outputs, derivatives, ..Case::new(&format!("7 Furuta, {form}"), system, start, (time, truth)) })
}

#[test]
fn a_furuta_pendulum() -> Result<(), Error> {
    for tensors_follow in [false, true] {
        let case = furuta(tensors_follow, 0.5)?;
        case.assert_orders([100, 40, 40])?;
        case.assert_close(Scheme::ESDIRK5, 1000, 1e-11)?;
    }
    Ok(())
}

#[test]
fn a_chain_of_universal_joints() -> Result<(), Error> {
    let all = reference("9_chain");
    let of = &all["parameters"];
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity(array::<3>(&of["g"]));
    let bodies = ["1", "2"].map(|name| {
        let [xx, xy, xz, _, yy, yz, _, _, zz] = array::<9>(&of[format!("J{name}")]);
        let mass = list(&of["mass"])[usize::from(name == "2")];
        let centre = array::<3>(&of[format!("centre{name}")]);
        space.body(name, Inertia::new(mass, [xx, yy, zz, xy, xz, yz]).centred_at(centre))
    });
    let first = space.universal("first", Body::GROUND.origin(), bodies[0].origin());
    let second = space.universal("second", bodies[0].at(array::<3>(&of["joint2_in_1"])), bodies[1].origin());
    let angles = [first.angles, second.angles].concat();
    let outputs = ends(&mut scene, &angles);
    let system = scene.compile()?;
    let states = all["random_states"].as_array().expect("states").iter().chain([&all["start"]]);
    for state in states {
        let here = Mechanics::new(&system, &list(&state["q"]), &list(&state["u"]))?;
        let accelerations = relative_error(here.accelerations()?.0.as_slice(), &list(&state["acceleration"]));
        let kinetic = (here.kinetic_energy() / number(&state["kinetic"]) - 1.0).abs();
        let potential = (here.potential_energy() / number(&state["potential"]) - 1.0).abs();
        println!("9 chain: accelerations {accelerations:.1e}, energies {kinetic:.1e}, {potential:.1e}");
        assert!(accelerations < 1e-13 && kinetic < 1e-14 && potential < 1e-14);
    }
    let mut start = at_rest(&system);
    put(&mut start, &angles, &list(&all["start"]["q"]), &list(&all["start"]["u"]));
    let truth = named(at(&all["values"], 0.25), &["q", "u"]);
    Case { outputs, ..Case::new("9 chain", system, start, (0.25, truth)) }.assert_orders([50, 20, 20])
}
