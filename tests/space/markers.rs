//! Markers: costs, forces, springs and loops.

use hamiltonian_adjoint::planar::Harmonic;
use hamiltonian_adjoint::spatial::{Body, Inertia, Marker, MarkerFunction, MarkerPoint, Quantity, Revolute, Spatial};
use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Grid, Inputs, Mechanics, Multiplier, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, planar,
};
use nalgebra::{Matrix3, Quaternion, Rotation3, SVector, UnitQuaternion, Vector3};

use crate::common::{assert_gradient_is_exact_with, assert_says, largest_difference};

/// ½ |p|² + v·ω + a·p of the first marker, plus t u.
struct Mixed;

impl MarkerFunction for Mixed {
    fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
        let of = &at.markers[0];
        let dot = |a: [S; 3], b: [S; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        dot(of.position, of.position) * 0.5
            + dot(of.velocity, of.angular_velocity)
            + dot(of.acceleration, of.position) * 0.1
            + dot(of.angular_acceleration, of.axes[1]) * 0.1
            + at.t * at.u[0] * at.b[0]
    }
}

#[test]
fn gradients_with_markers_are_exact() -> Result<(), Error> {
    let mut scene = Scene::new();
    let (mass, length, tilt) = (scene.design("mass", 1.3), scene.design("length", 0.4), scene.design("tilt", 0.2));
    let [torque, push] = ["torque", "push"].map(|name| scene.control(name));
    let mut space = scene.spatial();
    space.gravity([0.0, 0.5, -9.81]);
    let tensor = [0.02, 0.03, 0.015, 0.001, -0.002, 0.0015];
    let names = ["base", "arm", "hand", "wheel", "ball"];
    let [base, arm, hand, wheel, ball] =
        names.map(|name| space.body(name, Inertia::new(mass, tensor).centred_at([0.02, 0.01, -0.1])));
    let free = space.free("free", Body::GROUND.origin(), base.at([0.1, 0.0, 0.0]));
    let universal = space.universal("universal", base.at([0.0, 0.2, 0.1]).turned([0.3, 0.1, -0.2]), arm.origin());
    space.cylindrical("slide", arm.at((0.0, 0.0, length)).along((0.2, 0.0, tilt)), hand.origin());
    space.revolute("axle", base.at([0.0, -0.3, 0.0]).along([0.0, 0.0, -1.0]), wheel.origin());
    let socket = space.ball("socket", hand.at([0.0, 0.0, 0.2]), ball.origin());
    let tip = ball.at([0.1, 0.0, 0.3]);
    space.torque("motor", base.origin(), wheel.origin(), torque);
    space.thrust("jet", tip.along([1.0, 1.0, 0.0]), push);
    space.spring_damper("rope", Body::GROUND.at([0.0, 0.0, 2.0]), tip, [20.0, 0.3, 0.5]);
    space.applied_on_body("wind", hand.origin(), [0.1, 0.2, 0.3], [0.0, 0.05, 0.0]);
    space.cost("mixed", Mixed, Sum::Integral, &[tip], &[push], &[0.7.into()]);
    space.cost("end", Mixed, Sum::Terminal, &[tip], &[push], &[0.7.into()]);
    space.outputs("tip", Quantity::Velocity, tip, Sum::Terminal);
    scene.place(universal.angles[0], 0.3);
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(0.9, 0.3, -0.1, 0.2));
    [free.orientation, socket.orientation].into_iter().for_each(|e| scene.place_rotation(e, rotation));
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    inputs.controls.iter_mut().enumerate().for_each(|(k, u)| *u = (0.3 * k as f64).sin());
    assert_gradient_is_exact_with("markers", &system, &inputs, Settings::default());
    Ok(())
}

/// Markers whose axes are not those of their bodies, on a joint that carries another joint.
#[test]
fn a_rotation_and_an_angular_velocity_are_those_of_b_relative_to_a() -> Result<(), Error> {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    let [hand, ball] = ["hand", "ball"].map(|name| space.body(name, Inertia::sphere(1.0, 0.1)));
    let hinge = space.revolute("hinge", Body::GROUND.origin(), hand.origin());
    let a = hand.at([0.1, 0.0, 0.2]).turned([0.3, 0.4, -0.5]);
    let b = ball.at([0.0, 0.2, 0.0]).along([1.0, 2.0, -1.0]);
    let socket = space.ball("socket", a, b);
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -2.0, 1.1));
    scene.place_rotation(socket.orientation, rotation);
    scene.place(hinge.angle, 0.7);
    let system = scene.compile()?;
    let (mut inputs, omega) = (Inputs::at_rest(&system, Grid::uniform(1, 0.01)), [0.5, -1.5, 2.5]);
    inputs.start.set_rate(hinge.angle, 0.3);
    inputs.start.set_angular_velocity(socket.orientation, omega)?;
    let here = Mechanics::at_start(&system, &inputs)?;
    let (outer, inner) = (here.marker(a)?, here.marker(b)?);
    let [of_a, of_b] = [&outer, &inner].map(|marker| Matrix3::from_columns(&marker.axes.map(Vector3::from)));
    let relative = Vector3::from(inner.angular_velocity) - Vector3::from(outer.angular_velocity);
    assert!((of_a.transpose() * of_b - rotation.to_rotation_matrix().matrix()).amax() < 1e-14);
    assert!((of_b.transpose() * relative - Vector3::from(omega)).amax() < 1e-14);
    let mut momenta = Start::Momentum { q: inputs.start.q().clone(), p_star: here.momenta() };
    let error = momenta.set_angular_velocity(socket.orientation, omega).expect_err("momenta");
    assert_says(&error, &["augmented momenta", "velocities"]);
    Ok(())
}

#[test]
fn a_loop_is_closed() -> Result<(), Error> {
    let mut scene = Scene::new();
    let length = scene.design("length", 0.6);
    let torque = scene.control("torque");
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let [crank, rod, rocker] = ["crank", "rod", "rocker"]
        .map(|name| space.body(name, Inertia::cuboid(0.5, [0.3, 0.05, 0.05]).centred_at([0.15, 0.0, 0.0])));
    let crank_joint = space.revolute("crank joint", Body::GROUND.origin(), crank.origin());
    space.ball("elbow", crank.at([0.2, 0.0, 0.0]), rod.origin());
    space.revolute(
        "rocker joint",
        Body::GROUND.at([0.5, 0.1, 0.3]).along([0.0, 1.0, 0.0]),
        rocker.origin().along([0.0, 1.0, 0.0]),
    );
    space.close_ball("end", rod.at((length, 0.0, 0.0)), rocker.at([0.5, 0.0, 0.0]));
    space.cost("mixed", Mixed, Sum::Terminal, &[rocker.at([0.5, 0.0, 0.0])], &[torque], &[0.1.into()]);
    space.torque("motor", Body::GROUND.origin(), crank.origin(), torque);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    inputs.start = Start::assembled(&system).hold(&[crank_joint.angle]);
    assert_gradient_is_exact_with("loop", &system, &inputs, Settings::default());
    Ok(())
}

#[test]
fn bodies_in_the_plane_carry_bodies_in_space() -> Result<(), Error> {
    let mut scene = Scene::new();
    let force = scene.control("force");
    let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
    scene.prismatic("rail", planar::Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    scene.actuator("motor", planar::Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let table = space.planar_body("table", cart);
    let rod = space.body("rod", Inertia::cuboid(0.5, [0.05, 0.05, 0.6]));
    let joint = space.universal("joint", table.at([0.1, 0.0, 0.0]), rod.at([0.0, 0.0, 0.3]));
    space.cost("mixed", Mixed, Sum::Terminal, &[rod.at([0.0, 0.0, -0.3])], &[force], &[0.3.into()]);
    scene.place(joint.angles[0], 0.4);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    inputs.controls.fill(3.0);
    assert_gradient_is_exact_with("cart and rod", &system, &inputs, Settings::default());
    Ok(())
}

#[test]
fn impossible_inertias_are_refused() -> Result<(), Error> {
    let mut scene = Scene::new();
    let most = scene.design("most", 0.15);
    let mut space = scene.spatial();
    let top = space.body("top", Inertia::principal(1.0, (most, 0.085, 0.085)));
    space.ball("tip", Body::GROUND.origin(), top.origin());
    let refused = scene.clone();
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(2, 0.01));
    inputs.design[0] = 0.3;
    let error = Solver::new(&system, Settings::default()).simulate(&inputs).map(|_| ()).expect_err("an impossible tensor");
    assert_says(
        &error,
        &["`top`", "8.5000e-2", "3.0000e-1", "sum of the other two", "J_xy = −∫ x y dm", "Inertia::unchecked"],
    );
    let mut scene = refused;
    let other = scene.spatial().body("other", Inertia::new(1.0, [0.1, 0.1, 0.1, 0.2, 0.0, 0.0]));
    scene.spatial().fixed("weld", top.origin(), other.origin());
    assert_says(&scene.compile().map(|_| ()).expect_err("a negative moment"), &["`other`", "-1.0000e-1"]);
    Ok(())
}

/// λ.
struct Reaction;

impl Cost<0, 1, 0, 0> for Reaction {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, _b: &SVector<S, 0>) -> S {
        at.lambda[0]
    }
}

#[test]
fn a_load_cell_measures_force_and_torque() -> Result<(), Error> {
    let mut scene = Scene::new();
    let mass = scene.design("mass", 0.7);
    let torque = scene.control("torque");
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let [foot, rod] = [Inertia::none(), Inertia::new(mass, [0.02, 0.03, 0.015, 0.001, -0.002, 0.0015])];
    let (foot, rod) = (space.body("foot", foot), space.body("rod", rod));
    let cell = space.load_cell("cell", Body::GROUND.at([0.2, 0.0, 0.1]), foot.origin());
    let axis = [0.0, 1.0, 0.0];
    let hinge = space.revolute("hinge", foot.at([0.0, 0.0, 0.3]).along(axis), rod.at([-0.4, 0.05, 0.0]).along(axis));
    space.torque("motor", foot.at([0.0; 3]).along(axis), rod.origin().along(axis), torque);
    let multipliers = [cell.force, cell.torque].concat();
    for (k, multiplier) in multipliers.iter().enumerate() {
        scene.cost(&format!("reaction {k}"), Reaction, Sum::Integral, [], [*multiplier], [], []);
    }
    scene.place(hinge.angle, 0.3);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    inputs.controls.iter_mut().enumerate().for_each(|(k, u)| *u = (0.3 * k as f64).sin());
    inputs.start.rate_mut()[hinge.angle.index()] = 2.0;
    assert_gradient_is_exact_with("load cell", &system, &inputs, Settings::default());
    // Newton's and Euler's equations of the rod, about the origin of the cell.
    let at = Mechanics::at_start(&system, &inputs)?;
    let (centre, lambda) = (at.marker(rod.origin())?, at.accelerations()?.1);
    let force = centre.acceleration.map(|a| 0.7 * a);
    let force = [force[0], force[1], force[2] + 0.7 * 9.81];
    let cross = |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let tensor = [[0.02, 0.001, -0.002], [0.001, 0.03, 0.0015], [-0.002, 0.0015, 0.015]];
    let own = |x: [f64; 3]| centre.axes.map(|axis| (0..3).map(|i| axis[i] * x[i]).sum::<f64>());
    let spin = |x: [f64; 3]| {
        let inner = tensor.map(|row: [f64; 3]| (0..3).map(|i| row[i] * own(x)[i]).sum::<f64>());
        [0, 1, 2].map(|i| (0..3).map(|j| centre.axes[j][i] * inner[j]).sum::<f64>())
    };
    let (faster, gyro) = (spin(centre.angular_acceleration), cross(centre.angular_velocity, spin(centre.angular_velocity)));
    let arm = [centre.position[0] - 0.2, centre.position[1], centre.position[2] - 0.1];
    let moment = cross(arm, force);
    for i in 0..3 {
        let (own, torque) = (-lambda[cell.force[i].index()], -lambda[cell.torque[i].index()]);
        assert!((own - force[i]).abs() < 1e-12, "force {i}: {own} for {}", force[i]);
        let expected = faster[i] + gyro[i] + moment[i];
        assert!((torque - expected).abs() < 1e-12, "torque {i}: {torque} for {expected}");
    }
    Ok(())
}

/// The reactions λ of a part between the ground and a free box at rest.
fn reactions<const M: usize>(gravity: [f64; 3], hold: impl FnOnce(&mut Spatial, Body) -> [Multiplier; M]) -> [f64; M] {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity(gravity);
    let inertia = Inertia::new(0.7, [0.02, 0.03, 0.015, 0.001, -0.002, 0.0015]).centred_at([0.1, -0.2, 0.3]);
    let body = space.body("box", inertia);
    space.free("flight", Body::GROUND.origin(), body.origin());
    let multipliers = hold(&mut space, body);
    let system = scene.compile().expect("a scene");
    let here = Mechanics::new(&system, system.initial_coordinates().as_slice(), &[0.0; 7]).expect("a state");
    let lambda = here.accelerations().expect("accelerations").1;
    multipliers.map(|multiplier| lambda[multiplier.index()])
}

#[test]
fn reactions_of_loops_act_on_b_and_back_on_a() {
    let (gravity, centre, at) = (Vector3::new(3.0, -2.0, -9.0), Vector3::new(0.1, -0.2, 0.3), [0.4, 0.1, -0.2]);
    let (weight, turn) = (gravity * 0.7, [0.3, 0.4, -0.5]);
    let axes = Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
    let marker = |body: Body, at: [f64; 3]| body.at(at).turned(turn);
    let assert_near = |found: Vector3<f64>, expected: Vector3<f64>| {
        assert!((found - expected).amax() < 1e-13, "{found} for {expected}");
    };
    let pin = reactions(gravity.into(), |space, body| {
        space.close_ball("pin", marker(Body::GROUND, centre.into()), marker(body, centre.into()))
    });
    assert_near(axes * -Vector3::from(pin), -weight);
    let [x, y, z, first, second, third] =
        reactions(gravity.into(), |space, body| space.close_fixed("weld", marker(Body::GROUND, at), marker(body, at)));
    assert_near(axes * -Vector3::new(x, y, z), -weight);
    assert_near(axes * Vector3::new(second, -first, third), -(centre - Vector3::from(at)).cross(&weight));
    let (middle, down): ([f64; 3], [f64; 3]) = (centre.into(), gravity.normalize().into());
    let along = |body: Body| body.at(middle).along(down);
    let [plane] = reactions(gravity.into(), |space, body| space.point_on_plane("plane", along(Body::GROUND), along(body)));
    assert_near(Vector3::from(down) * -plane, -weight);
    let hook = Body::GROUND.at([0, 1, 2].map(|i| middle[i] - 0.5 * down[i]));
    let [tension] = reactions(gravity.into(), |space, body| space.distance("rod", hook, along(body), 0.5));
    assert_near(Vector3::from(down) * -tension, -weight);
    let across = |body: Body| body.at(middle).along_and_toward([2.0, 3.0, 0.0], down);
    let line = reactions(gravity.into(), |space, body| space.point_on_line("line", across(Body::GROUND), across(body)));
    assert_near(Vector3::new(-line[0], -line[1], 0.0), Vector3::new(-weight.norm(), 0.0, 0.0));
}

/// A slewing crane with a load on a rope, its slewing joint, and the ends of a ram on its post and on its boom.
fn crane() -> (Scene, Revolute, [Marker; 2]) {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let post = space.body("post", Inertia::cuboid(3.0, [0.2, 0.2, 1.0]));
    let boom = space.body("boom", Inertia::cuboid(2.0, [1.6, 0.1, 0.1]).centred_at([0.8, 0.0, 0.0]));
    let load = space.body("load", Inertia::sphere(1.5, 0.1));
    let slew = space.revolute("slew", Body::GROUND.origin(), post.origin());
    let y = [0.0, -1.0, 0.0];
    let lift = space.revolute("lift", post.at([0.1, 0.0, 0.5]).along(y), boom.origin().along(y));
    let rope = space.universal("rope", boom.at([1.6, 0.0, 0.0]), load.at([0.0, 0.0, 0.7]));
    scene.place(lift.angle, 0.4);
    scene.place(rope.angles[0], 0.3);
    (scene, slew, [post.at([0.2, 0.05, -0.3]), boom.at([0.7, 0.0, -0.05])])
}

#[test]
fn a_driven_distance_acts_as_an_actuator() -> Result<(), Error> {
    let (mut scene, slew, [a, b]) = crane();
    let mut pushed = scene.clone();
    let (middle, stroke) = (scene.design("middle", 1.1), scene.design("stroke", 0.06));
    let law = [middle.into(), stroke.into(), 4.0.into(), 0.3.into()];
    let [ram] = scene.spatial().driven_distance("ram", a, b, Harmonic, law);
    scene.cost("reaction", Reaction, Sum::Integral, [], [ram], [], []);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    inputs.grid.start = 0.7;
    inputs.start = Start::assembled(&system).hold(&[slew.angle]);
    inputs.start.set_rate(slew.angle, 0.5);
    assert_gradient_is_exact_with("driven distance", &system, &inputs, Settings::default());

    let force = pushed.control("force");
    pushed.spatial().two_point_actuator("ram", a, b, force);
    let pushed = pushed.compile()?;
    let mut solver = Solver::new(&system, Settings { scheme: Scheme::ESDIRK5, ..Settings::default() });
    let motion = solver.simulate(&inputs)?.clone();
    for node in 0..=motion.last() {
        let at = Mechanics::at_node(&system, solver.inputs(), &motion, node)?;
        let [from, to] = [at.marker(a)?.position, at.marker(b)?.position];
        let distance = (0..3).map(|i| (to[i] - from[i]).powi(2)).sum::<f64>().sqrt();
        let given = 1.1 + 0.06 * (4.0 * motion.times[node] + 0.3).sin();
        assert!((distance - given).abs() < 1e-9, "{distance} for {given} at node {node}");
        let (acceleration, lambda) = at.accelerations()?;
        let [q, v] = [&motion.q, &motion.v].map(|all| all.column(node).as_slice().to_vec());
        // By the drift the direction is not of length 1 in the constraint.
        let force = -lambda[ram.index()] * distance / given;
        let other = Mechanics::new(&pushed, &q, &v)?.with_controls(&[force])?.accelerations()?.0;
        let difference = largest_difference(other.as_slice(), acceleration.as_slice());
        assert!(difference < 1e-12 * acceleration.amax(), "{difference:.1e} at node {node}");
    }
    Ok(())
}
