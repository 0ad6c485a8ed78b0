//! Closed loops: slider-crank, Bricard's mechanism, RSSR.

use hamiltonian_adjoint::spatial::{Body, Inertia, Load, MarkerForce, MarkerPoint, Quantity, Revolute};
use hamiltonian_adjoint::{Coordinate, Error, Grid, Inputs, Mechanics, Scalar, Scene, Scheme, Start, Sum, System};
use nalgebra::{Matrix3, Rotation3, Vector3};
use serde_json::Value;

use super::{Case, array, at, at_rest, ends, euler, list, named, number, put, reference};

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];

/// The rotation whose x axis is n and whose y axis is perpendicular to `other`.
fn along_x(n: Vector3<f64>, other: Vector3<f64>) -> Matrix3<f64> {
    let y = other.cross(&n).normalize();
    Matrix3::from_columns(&[n, y, n.cross(&y)])
}

/// The crank, on the ground, and the slider of the slider-crank; the crank's joint and the slider's one.
fn crank_and_slider(scene: &mut Scene, all: &Value, given: &Value) -> ([Body; 2], [Coordinate; 2]) {
    let of = &all["parameters"];
    let mut space = scene.spatial();
    space.gravity(array::<3>(&given["g"]));
    let crank = space.body("crank", Inertia::principal(number(&of["mass_crank"]), array::<3>(&of["J_crank_diag"])));
    let slider = space.body("slider", Inertia::principal(number(&of["mass_slider"]), array::<3>(&of["J_slider_diag"])));
    let centre = number(&given["crank_centre_from_A"]);
    let pivot = Body::GROUND.at(array::<3>(&of["A"])).along(X);
    let turn = space.revolute("pivot", pivot, crank.at([0.0, 0.0, -centre]).along(X));
    let slide = space.prismatic("rail", Body::GROUND.origin().along(X), slider.origin().along(X));
    ([crank, slider], [turn.angle, slide.offset])
}

fn slider_crank(name: &str, time: f64) -> Result<Case, Error> {
    let all = reference("3_slider_crank");
    let (of, given) = (&all["parameters"], &all[name]);
    let mut scene = Scene::new();
    let ([crank, slider], ends_of) = crank_and_slider(&mut scene, &all, given);
    let pin = number(&of["crank_length"]) - number(&given["crank_centre_from_A"]);
    let half = number(&of["rod_length"]) / 2.0;
    let inertia = Inertia::principal(number(&of["mass_rod"]), array::<3>(&of["J_rod_diag_x_along"]));
    let first = &given["start"];
    let (turn, shift) = (number(&first["crank"]), number(&first["slider"]));
    let n = (Vector3::new(shift, 0.0, 0.0) - Vector3::from(array::<3>(&first["B"]))) / (2.0 * half);
    let mut space = scene.spatial();
    let rod = space.body("rod", inertia);
    let start: Box<dyn Fn(&System) -> Start> = if given["rod_slider"] == "ball" {
        let ball = space.ball("pin", crank.at([0.0, 0.0, pin]), rod.at([-half, 0.0, 0.0]));
        space.close_ball("end", rod.at([half, 0.0, 0.0]), slider.origin());
        let rates = named(first, &["crank_rate", "slider_rate"]);
        let attitude = along_x(n, Vector3::z());
        let relative = Vector3::from(array::<3>(&first["rod_omega_world"])) - Vector3::x() * rates[0];
        let (e, own) = (euler(&attitude), (attitude.transpose() * relative).into());
        Box::new(move |system| {
            let mut start = at_rest(system);
            put(&mut start, &ends_of, &[turn, shift], &rates);
            put(&mut start, &ball.orientation, &e, &[0.0; 4]);
            start.set_angular_velocity(ball.orientation, own).expect("velocities");
            start
        })
    } else {
        // The first axis of the cross is the world's z; the y axis of the rod is the second one.
        let fork = slider.origin().along_and_toward([-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let cross = space.universal("cross", fork, rod.at([half, 0.0, 0.0]));
        space.close_ball("pin", crank.at([0.0, 0.0, pin]), rod.at([-half, 0.0, 0.0]));
        let second = n.z.acos();
        let f = Vector3::z().cross(&n).normalize();
        let angles = [f.y.atan2(f.x) - std::f64::consts::FRAC_PI_2, second];
        let rate = number(&first["crank_rate"]);
        Box::new(move |system| {
            let mut start = Start::assembled(system).hold(&ends_of[..1]);
            put(&mut start, &ends_of, &[turn, shift], &[rate, 0.0]);
            put(&mut start, &cross.angles, &angles, &[0.0; 2]);
            start
        })
    };
    let outputs = ends(&mut scene, &ends_of);
    let system = scene.compile()?;
    let start = start(&system);
    let inputs = Inputs { start: start.clone(), ..Inputs::at_rest(&system, Grid::uniform(1, 1e-3)) };
    let here = Mechanics::at_start(&system, &inputs)?;
    let acceleration = here.accelerations()?.0[ends_of[0].index()] / number(&first["crank_acceleration"]) - 1.0;
    let energy = here.energy() - number(&first["energy"]);
    println!("3 slider-crank, {name}: acceleration {acceleration:.1e}, energy {energy:.1e}");
    assert!(acceleration.abs() < 1e-12 && energy.abs() < 1e-14);
    let truth = named(at(&given["values"], time), &["crank", "slider", "crank_rate", "slider_rate"]);
    Ok(Case { outputs, ..Case::new(&format!("3 slider-crank, {name}"), system, start, (time, truth)) })
}

#[test]
fn a_slider_crank() -> Result<(), Error> {
    for name in ["no_gravity", "gravity", "no_gravity_centre_at_A", "gravity_centre_at_A"] {
        slider_crank(name, 0.5)?.assert_close(Scheme::ESDIRK5, 1000, 1e-9)?;
    }
    slider_crank("gravity", 0.25)?.assert_orders([200, 40, 40])?;
    slider_crank("no_gravity_universal", 0.5)?.assert_close(Scheme::ESDIRK5, 1000, 1e-9)?;
    slider_crank("gravity_universal", 0.25)?.assert_orders([200, 40, 40])
}

/// How the chain of five rods and five hinges is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Closed {
    /// By a sixth hinge: five equations of rank 4.
    Redundantly,
    /// By a ball joint and one component of the axis.
    ByFour,
}

fn bricard(closed: Closed, time: f64) -> Result<Case, Error> {
    let all = reference("4_bricard");
    let of = &all["parameters"];
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity(array::<3>(&of["g"]));
    let points: Vec<[f64; 3]> = (0..6).map(|k| array(&of["points"][k])).collect();
    let axes: Vec<[f64; 3]> = (0..6).map(|k| array(&of["axes_at_start"][k])).collect();
    let mut outer = Body::GROUND.at(points[0]);
    let mut hinges: Vec<Revolute> = Vec::new();
    let mut ends_of_rods = Vec::new();
    for k in 0..5 {
        let half: [f64; 3] = std::array::from_fn(|i| (points[k + 1][i] - points[k][i]) / 2.0);
        let moment = |i: usize| number(&of[if half[i] == 0.0 { "J_transversal" } else { "J_along" }]);
        let inertia = Inertia::principal(number(&of["mass"]), [0, 1, 2].map(moment));
        let rod = space.body(&format!("rod {k}"), inertia);
        let inner = rod.at(half.map(|x| -x));
        hinges.push(space.revolute(&format!("hinge {k}"), outer.along(axes[k]), inner.along(axes[k])));
        outer = rod.at(half);
        ends_of_rods.push(outer);
    }
    let ground = Body::GROUND.at(points[5]);
    match closed {
        Closed::Redundantly => {
            space.close_revolute("hinge 5", outer.along(axes[5]), ground.along(axes[5]));
        }
        Closed::ByFour => {
            space.close_ball("hinge 5", outer, ground);
            let beside: [f64; 3] = std::array::from_fn(|i| points[5][i] + axes[5][i]);
            space.point_on_plane("axis", outer.along([0.0, 0.0, 1.0]), Body::GROUND.at(beside));
        }
    }
    space.outputs("P3", Quantity::Position, ends_of_rods[2], Sum::Terminal);
    space.outputs("velocity of P3", Quantity::Velocity, ends_of_rods[2], Sum::Terminal);
    let angles: Vec<_> = hinges.iter().map(|hinge| hinge.angle).collect();
    let outputs = [(0..6).collect(), ends(&mut scene, &angles)].concat();
    let system = scene.compile()?;
    let start = at_rest(&system);
    let here = Mechanics::new(&system, start.q().as_slice(), start.rate().as_slice())?;
    let accelerations = here.accelerations()?.0;
    let [d, e] = array::<2>(&all["start"]["accelerations_d_e"]);
    let error = crate::common::relative_error(accelerations.as_slice(), &[d, e, d, e, d]);
    println!("4 Bricard: accelerations {error:.1e}");
    assert!(error < 1e-12);
    let end = at(&all["values"], time);
    let ([d, e], [d_rate, e_rate]) = ([number(&end["d"]), number(&end["e"])], array::<2>(&end["rates"]));
    let of_angles = [d, e, d, e, d, d_rate, e_rate, d_rate, e_rate, d_rate];
    let truth = [&named(end, &["P3", "P3_velocity"])[..], &of_angles].concat();
    Ok(Case { outputs, ..Case::new(&format!("4 Bricard, closed {closed:?}"), system, start, (time, truth)) })
}

#[test]
fn a_bricard_mechanism() -> Result<(), Error> {
    bricard(Closed::ByFour, 1.0)?.assert_orders([50, 20, 20])?;
    let mut case = bricard(Closed::Redundantly, 1.0)?;
    case.assert_order(Scheme::TRAPEZOIDAL, 50, 0.15)?;
    // Errors of positions within a step, of 1e-6, make the compliances brake by 1e-5 of the motion; with more steps this falls with the sixth order.
    case.assert_close(Scheme::ESDIRK4, 80, 1e-4)?;
    case.assert_close(Scheme::ESDIRK4, 640, 1e-9)?;
    case.settings.drift_bound = 0.0;
    case.assert_order(Scheme::TRAPEZOIDAL, 50, 0.15)?;
    case.assert_close(Scheme::ESDIRK5, 640, 1e-10)
}

/// The torque b₀ − b₁ ω about z.
struct Motor;

impl MarkerForce for Motor {
    fn loads<S: Scalar>(&self, at: &MarkerPoint<S>, loads: &mut [Load<S>]) {
        loads[0].torque[2] = at.b[0] - at.b[1] * at.markers[0].angular_velocity[2];
    }
}

/// With the coupler on the crank, or free with two loops. In the free one the spin of the coupler along its line does not depend on its length.
fn rssr(is_free: bool, tensor_follows: bool, time: f64) -> Result<Case, Error> {
    let all = reference("6_rssr");
    let (of, first) = (&all["parameters"], &all["start"]);
    let mut scene = Scene::new();
    let torque = scene.design("torque", number(&of["torque"]));
    let length = scene.design("coupler length", number(&of["coupler"]["length"]));
    let [crank_length, rocker_length] = ["crank", "rocker"].map(|name| number(&of[name]["length"]));
    let mut space = scene.spatial();
    space.gravity(array::<3>(&of["g"]));
    let inertia = |name: &str| Inertia::principal(number(&of[name]["mass"]), array::<3>(&of[name]["J_diag"]));
    let crank = space.body("crank", inertia("crank").centred_at([crank_length / 2.0, 0.0, 0.0]));
    let rocker = space.body("rocker", inertia("rocker").centred_at([0.0, 0.0, -rocker_length / 2.0]));
    let [axial, across, _] = array::<3>(&of["coupler"]["J_diag"]);
    let mass = number(&of["coupler"]["mass"]);
    let coupler = space.body(
        "coupler",
        match tensor_follows {
            true => {
                let across = length * length * (mass / 12.0);
                Inertia::principal(mass, (axial, across, across))
            }
            false => Inertia::principal(mass, [axial, across, across]),
        },
    );
    let a = space.revolute("a", Body::GROUND.origin(), crank.origin()).angle;
    let pivot = Body::GROUND.at(array::<3>(&of["rocker_point"]));
    let b = space.revolute("b", pivot.along(Y), rocker.origin().along(Y)).angle;
    let pins = [crank.at([crank_length, 0.0, 0.0]), rocker.at([0.0, 0.0, -rocker_length])];
    let sides = [coupler.at((length * -0.5, 0.0, 0.0)), coupler.at((length * 0.5, 0.0, 0.0))];
    let angles = named(first, &["crank", "rocker"]);
    let rates = named(first, &["crank_rate", "rocker_rate"]);
    let [from, to] = ["B", "C"].map(|name| Vector3::from(array::<3>(&first[name])));
    let attitude = along_x((to - from).normalize(), Vector3::z());
    let (position, orientation) = if is_free {
        let free = space.free("flight", Body::GROUND.origin(), coupler.origin());
        space.close_ball("B", pins[0], sides[0]);
        (free.position.to_vec(), free.orientation)
    } else {
        (Vec::new(), space.ball("B", pins[0], sides[0]).orientation)
    };
    space.close_ball("C", pins[1], sides[1]);
    space.force("motor", Motor, &[crank.origin()], &[], &[torque.into(), number(&of["damping"]).into()]);
    let outputs = ends(&mut scene, &[a, b]);
    let system = scene.compile()?;
    let start = if is_free {
        let mut start = Start::assembled(&system).hold(&[a]);
        put(&mut start, &[a, b], &angles, &[rates[0], 0.0]);
        put(&mut start, &position, ((from + to) / 2.0).as_slice(), &[0.0; 3]);
        put(&mut start, &orientation, &euler(&attitude), &[0.0; 4]);
        start
    } else {
        let mut start = at_rest(&system);
        let crank = Rotation3::from_axis_angle(&Vector3::z_axis(), angles[0]).into_inner();
        let e = euler(&(crank.transpose() * attitude));
        let relative = Vector3::from(array::<3>(&first["coupler_omega_world"])) - Vector3::z() * rates[0];
        put(&mut start, &[a, b], &angles, &rates);
        put(&mut start, &orientation, &e, &[0.0; 4]);
        start.set_angular_velocity(orientation, (attitude.transpose() * relative).into())?;
        start
    };
    let form = if tensor_follows { "tensor_follows" } else { "tensor_fixed" };
    let truth = named(at(&all["values"], time), &["crank", "rocker", "crank_rate", "rocker_rate"]);
    let rows = at(&all["derivatives"][form], time);
    let derivatives = match is_free {
        true => vec![(0, list(&rows["by_torque"])), (1, list(&rows["by_coupler_length"]))],
        // A given start does not follow the length.
        false => vec![(0, list(&rows["by_torque"]))],
    };
    let name = format!("6 RSSR, {}, {form}", if is_free { "free coupler" } else { "coupler on the crank" });
    Ok(Case { outputs, derivatives, ..Case::new(&name, system, start, (time, truth)) })
}

#[test]
fn a_spatial_four_bar() -> Result<(), Error> {
    for (is_free, tensor_follows) in [(false, false), (true, false), (true, true)] {
        rssr(is_free, tensor_follows, 0.25)?.assert_orders([400, 20, 20])?;
    }
    Ok(())
}
