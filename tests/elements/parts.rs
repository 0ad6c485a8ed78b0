//! Ready parts against closed forms; their gradients are held to the plain formulas with all other elements (`skipped.rs`).

use crate::common::{assert_gradient_is_exact, assert_says, largest};
use hamiltonian_adjoint::planar::{Body, Constant, Curve, Harmonic, Point};
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Control, Error, Grid, Inputs, KineticEnergy, Mechanics, Scalar, Scene, Scheme, Settings, Start, Sum, System, simulate,
};
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

const GRAVITY: f64 = 9.81;

fn accelerations(system: &System, v: &[f64], u: &[f64]) -> Vec<f64> {
    let q = system.initial_coordinates();
    let at = Mechanics::new(system, q.as_slice(), v).and_then(|at| at.with_controls(u)).expect("a state");
    at.accelerations().expect("accelerations").0.as_slice().to_vec()
}

/// A wheel on the ground.
fn wheel(scene: &mut Scene, name: &str, inertia: f64, x: f64) -> Body {
    let wheel = scene.body(name, 1.0, inertia, [x, 0.0, 0.2]);
    scene.revolute(&format!("axle of {name}"), Body::GROUND.at(x, 0.0), wheel.at(0.0, 0.0));
    wheel
}

fn motor(scene: &mut Scene, on: Body) -> Control {
    let u = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, on, u);
    u
}

#[test]
fn a_gear_adds_up_inertias_by_the_square_of_its_ratio() {
    let mut scene = Scene::new();
    let (a, b) = (wheel(&mut scene, "a", 0.2, 0.0), wheel(&mut scene, "b", 0.5, 1.0));
    scene.gear("gear", a, 0.3, b, 0.6);
    motor(&mut scene, a);
    let system = scene.compile().expect("a scene");
    let v_dot = accelerations(&system, &[0.0; 6], &[1.5]);
    let expected = 1.5 / (0.2 + 0.5 * 0.25);
    assert!((v_dot[2] - expected).abs() < 1e-13 && (v_dot[5] + 0.5 * expected).abs() < 1e-13, "{v_dot:?}");
}

#[test]
fn a_rack_moves_as_far_as_its_wheel_rolls() {
    let mut scene = Scene::new();
    let pinion = wheel(&mut scene, "pinion", 0.2, 0.0);
    let rack = scene.body("rack", 2.0, 0.1, [0.0, 0.3, 0.0]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.3), 0.0, rack.at(0.0, 0.0), 0.0);
    scene.rack("teeth", rack, 0.0, pinion, -0.3);
    motor(&mut scene, pinion);
    let system = scene.compile().expect("a scene");
    let v_dot = accelerations(&system, &[0.0; 6], &[1.5]);
    let expected = 1.5 / (0.2 + 2.0 * 0.09);
    assert!((v_dot[2] - expected).abs() < 1e-13 && (v_dot[3] + 0.3 * expected).abs() < 1e-13, "{v_dot:?}");
}

#[test]
fn a_cylinder_that_carries_the_weight_keeps_a_beam_at_rest() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let beam = scene.body("beam", 3.0, 0.4, [0.5, 0.0, 0.0]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), beam.at(-0.5, 0.0));
    let force = scene.control("force");
    scene.two_point_actuator("cylinder", Body::GROUND.at(0.0, -0.6), beam.at(0.3, 0.0), force);
    let system = scene.compile().expect("a scene");
    // Its lever about the pivot is that of its line at the point (0.8, 0).
    let lever = 0.8 * 0.6 / 1.0;
    let carrying = 3.0 * GRAVITY * 0.5 / lever;
    assert!(largest(&accelerations(&system, &[0.0; 3], &[carrying])) < 1e-13);
    assert!(accelerations(&system, &[0.0; 3], &[1.1 * carrying])[2] > 0.1, "a larger force lifts it");
}

#[test]
fn driven_parts_follow_their_programme() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let bob = scene.body("bob", 1.0, 0.1, [0.0, -1.0, 0.0]);
    // Starts at rest: cos(5 t) has no slope at 0.
    let parameters = [0.8.into(), 0.2.into(), 5.0.into(), FRAC_PI_2.into()];
    scene.driven_distance("rope", Body::GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), Harmonic, parameters);
    let cart = scene.body("cart", 1.0, 0.1, [0.2, 0.0, 0.0]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    scene.driven_slider(
        "drive",
        (Body::GROUND.at(0.0, 0.0), 0.0),
        cart.at(0.0, 0.0),
        Harmonic,
        [0.0.into(), 0.2.into(), 5.0.into(), FRAC_PI_2.into()],
    );
    let system = scene.compile().expect("a scene");
    let settings = Settings { scheme: Scheme::ESDIRK5, ..Settings::default() };
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    let motion = simulate(&system, &inputs, settings).expect("a motion");
    for i in [17, 100] {
        let t = motion.times[i];
        let length = motion.q[(0, i)].hypot(motion.q[(1, i)]);
        assert!((length - 0.8 - 0.2 * (5.0 * t).cos()).abs() < 1e-8, "{length}");
        assert!((motion.q[(3, i)] - 0.2 * (5.0 * t).cos()).abs() < 1e-8);
    }
}

#[test]
fn forces_given_by_time_move_a_free_body_as_integrated() {
    let mut scene = Scene::new();
    let body = scene.body("body", 2.0, 0.5, [0.0; 3]);
    scene.applied_force("constant", body.at(0.0, 0.0), 0.3, Constant, [4.0.into()]);
    scene.applied_torque("harmonic", body, Harmonic, [0.0.into(), 3.0.into(), 2.0.into(), FRAC_PI_2.into()]);
    let eccentric = scene.body("eccentric", 2.0, 0.5, [0.0; 3]);
    scene.applied_force("at a lever", eccentric.at(0.25, 0.0), FRAC_PI_2, Constant, [4.0.into()]);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    let settings = Settings { scheme: Scheme::ESDIRK5, ..Settings::default() };
    let motion = simulate(&system, &inputs, settings).expect("a motion");
    let end = motion.q.column(100);
    assert!((end[0] - 0.3f64.cos()).abs() < 1e-12 && (end[1] - 0.3f64.sin()).abs() < 1e-12);
    // φ̈ = 6 cos 2t from rest: φ = 1.5 (1 − cos 2t).
    assert!((end[2] - 1.5 * (1.0 - 2f64.cos())).abs() < 1e-9, "{}", end[2]);
    assert!((accelerations(&system, &[0.0; 6], &[])[5] - 4.0 * 0.25 / 0.5).abs() < 1e-13);
}

#[test]
fn a_bushing_is_three_springs_and_three_dampers() {
    let mut scene = Scene::new();
    let body = scene.body("body", 2.0, 0.5, [0.01, -0.02, 0.03]);
    let list = |values: [f64; 3]| values.map(Into::into);
    scene.bushing(
        "bushing",
        Body::GROUND.at(0.0, 0.0),
        body.at(0.0, 0.0),
        list([900.0, 700.0, 20.0]),
        list([3.0, 2.0, 0.1]),
    );
    let system = scene.compile().expect("a scene");
    let v_dot = accelerations(&system, &[0.1, 0.2, 0.3], &[]);
    let expected = [(-900.0 * 0.01 - 3.0 * 0.1) / 2.0, (700.0 * 0.02 - 2.0 * 0.2) / 2.0, (-20.0 * 0.03 - 0.1 * 0.3) / 0.5];
    assert!((0..3).all(|i| (v_dot[i] - expected[i]).abs() < 1e-12), "{v_dot:?}");
}

#[test]
fn dry_friction_stops_at_a_constant_rate() {
    let mut scene = Scene::new();
    let wheel = wheel(&mut scene, "wheel", 0.5, 0.0);
    scene.coulomb_friction("friction", Body::GROUND, wheel, 0.4, 0.01);
    let cart = scene.body("cart", 2.0, 0.1, [0.0, 1.0, 0.0]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 1.0), 0.0, cart.at(0.0, 0.0), 0.0);
    scene.coulomb_sliding("rail friction", Body::GROUND.at(0.0, 1.0), 0.0, cart.at(0.0, 0.0), 3.0, 0.01);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(400, 0.01));
    inputs.start.set_rate(wheel.coordinates[2], 2.0);
    inputs.start.set_rate(cart.coordinates[0], 3.0);
    let settings = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    let motion = simulate(&system, &inputs, settings).expect("a motion");
    assert!((motion.v[(2, 100)] - (2.0 - 0.8)).abs() < 1e-9, "−M/J t");
    assert!((motion.v[(3, 100)] - (3.0 - 1.5)).abs() < 1e-9, "−F/m t");
    assert!(motion.v[(2, 400)].abs() < 1e-6 && motion.v[(3, 400)].abs() < 1e-6, "at rest");
    assert!((motion.q[(3, 400)] - 9.0 / 2.0 / 1.5).abs() < 1e-2, "v²/(2 a)");
}

#[test]
fn a_ball_bounces_to_its_height_and_sinks_in_as_hertz_says() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let ball = scene.body("ball", 0.2, 1e-4, [0.0, 0.5, 0.0]);
    let k: f64 = 1e5;
    scene.contact(
        "floor",
        Body::GROUND.at(0.0, 0.0),
        FRAC_PI_2,
        ball.at(0.0, 0.0),
        [k.into(), 0.0.into(), 0.0.into(), 1.0.into()],
    );
    let system = scene.compile().expect("a scene");
    let settings = Settings { scheme: Scheme::ESDIRK5, ..Settings::default() };
    let fall = (2.0 * 0.5 / GRAVITY).sqrt();
    let inputs = Inputs::at_rest(&system, Grid::uniform(20_000, 2.2 * fall / 20_000.0));
    let motion = simulate(&system, &inputs, settings).expect("a motion");
    let lowest = motion.q.row(1).transpose().imin();
    let (depth, speed) = (-motion.q[(1, lowest)], motion.v[(1, lowest)]);
    // m g (h + δ) = 2/5 k δ^(5/2) + ½ m v², the last at most of one step.
    let work = 0.2 * GRAVITY * (0.5 + depth) - 0.4 * k * depth.powf(2.5) - 0.1 * speed * speed;
    assert!(work.abs() < 1e-7 && speed.abs() < 0.02, "{work} {speed}");
    let after = motion.q.row(1).columns(12_000, 8_000).max();
    assert!((after - 0.5).abs() < 1e-5, "{after}");
}

#[test]
fn a_block_on_a_slope_slides_by_gravity_less_friction() {
    let (slope, mu) = (0.6f64, 0.25);
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let normal_force = 2.0 * GRAVITY * slope.cos();
    let k: f64 = 1e6;
    let depth = (normal_force / k).powf(2.0 / 3.0);
    let block = scene.body("block", 2.0, 0.1, [depth * slope.sin(), -depth * slope.cos(), 0.0]);
    let law = [k.into(), 0.5.into(), mu.into(), 1e-3.into()];
    scene.contact("slope", Body::GROUND.at(0.0, 0.0), slope + FRAC_PI_2, block.at(0.0, 0.0), law);
    let system = scene.compile().expect("a scene");
    // Downhill: the tangent of the contact points uphill where the slope goes up to the right.
    let v = [-slope.cos(), -slope.sin(), 0.0];
    let v_dot = accelerations(&system, &v, &[]);
    let downhill = -(v_dot[0] * slope.cos() + v_dot[1] * slope.sin());
    assert!((downhill - GRAVITY * (slope.sin() - mu * slope.cos())).abs() < 1e-10, "{v_dot:?}");
    assert!((v_dot[1] * slope.cos() - v_dot[0] * slope.sin()).abs() < 1e-10, "not off the slope");
}

/// x² + y² = r², as a distance.
struct Ring;

impl Curve<1> for Ring {
    fn value<S: Scalar>(&self, x: S, y: S, b: &SVector<S, 1>) -> S {
        ((x * x + y * y) / b[0] - b[0]) * 0.5
    }
}

#[test]
fn a_pin_in_a_round_slot_is_a_pendulum() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let bead = scene.body("bead", 0.7, 0.1, [0.48, -0.64, 0.0]);
    scene.point_on_curve("slot", Body::GROUND.at(0.0, 0.0), Ring, bead.at(0.0, 0.0), [0.8.into()]);
    let rod = scene.body("bob", 0.7, 0.1, [0.48, -0.64, 0.0]);
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), rod.at(0.0, 0.0), 0.8);
    let system = scene.compile().expect("a scene");
    let v_dot = accelerations(&system, &[0.8, 0.6, 0.0, 0.8, 0.6, 0.0], &[]);
    assert!(largest(&[v_dot[0] - v_dot[3], v_dot[1] - v_dot[4]]) < 1e-13, "{v_dot:?}");
}

/// A string of four ends on a hook, joined by everything that goes without angles: of particles, or of bodies that do not turn.
fn string(particles: [bool; 4]) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let ends: Vec<Point> = Vec::from_iter(particles.iter().enumerate().map(|(k, is_particle)| {
        let (name, [x, y]) = (format!("end {k}"), [0.3 * (k + 1) as f64, -0.4 * (k + 1) as f64]);
        match is_particle {
            true => scene.particle(&name, 0.4, [x, y]).point(),
            false => scene.body(&name, 0.4, 0.1, [x, y, 0.0]).at(0.0, 0.0),
        }
    }));
    let hook = Body::GROUND.at(0.0, 0.0);
    scene.distance("rod", hook, ends[0], 0.5);
    scene.spring_damper("spring", ends[0], ends[1], 90.0, 0.4, 0.3);
    scene.distance("second rod", ends[2], ends[1], 0.5);
    scene.spring_damper("last spring", ends[3], ends[2], 80.0, 0.5, 0.2);
    scene.spring_damper("rope", ends[3], hook, 20.0, 1.5, 0.1);
    let force = scene.control("force");
    scene.two_point_actuator("cylinder", ends[0], ends[2], force);
    scene.applied_force("gust", ends[1], 0.2, Constant, [0.4.into()]);
    let q = scene.coordinates("gauge", ["s"]);
    scene.kinetic_energy("gauge", Gauge, q, []);
    scene.cost("gauge", AngleError, Sum::Terminal, q, [], [], [0.3.into()]);
    scene.compile().expect("a scene")
}

/// Keeps a cost apart from the ends.
struct Gauge;

impl KineticEnergy<1> for Gauge {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

#[test]
fn particles_move_as_bodies_that_are_not_turned() {
    let places = |particles: [bool; 4]| {
        let system = string(particles);
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.01));
        inputs.controls.fill(1.5);
        let motion = simulate(&system, &inputs, Settings::default()).expect("a motion");
        let kept = |i: &usize| !system.coordinate_name(*i).ends_with('φ');
        let names: Vec<f64> = (0..system.n()).filter(kept).map(|i| motion.q[(i, 40)]).collect();
        names
    };
    let bodies = places([false; 4]);
    for mask in 1..16 {
        let particles = places(std::array::from_fn(|k| mask >> k & 1 == 1));
        let differences: Vec<f64> = bodies.iter().zip(&particles).map(|(a, b)| a - b).collect();
        assert!(largest(&differences) < 1e-11, "{mask:04b}: {differences:?}");
    }
}

/// y = b x².
struct Bowl;

impl Curve<1> for Bowl {
    fn value<S: Scalar>(&self, x: S, y: S, b: &SVector<S, 1>) -> S {
        y - b[0] * x * x
    }
}

#[test]
fn gradients_with_particles_are_exact() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let (m, l) = (scene.design("mass", 0.5), scene.design("length", 0.8));
    let bob = scene.particle("bob", m * 2.0, [0.5, -0.5]);
    let arm = scene.body("arm", 1.0, 0.1, [0.9, -0.5, 0.2]);
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.point(), l);
    scene.revolute("hinge", bob.point(), arm.at(-0.3, 0.0));
    let u = scene.control("force");
    scene.two_point_actuator("cylinder", Body::GROUND.at(0.3, 0.0), arm.at(0.3, 0.0), u);
    // All that goes with points goes with particles.
    let (bead, slide) = (scene.particle("bead", 0.3, [1.5, 0.4]), scene.particle("slide", m, [2.0, -0.2]));
    let law = [300.0.into(), 2.0.into(), 0.3.into(), 0.1.into()];
    scene.contact("floor", Body::GROUND.at(0.0, -0.6), 0.0, bob.point(), law);
    scene.contact("bump", bead.point(), 0.4, arm.at(0.2, 0.1), law);
    scene.point_on_curve("bowl", Body::GROUND.at(1.5, 0.2), Bowl, bead.point(), [m * 2.0]);
    let harmonic = [0.0.into(), 0.1.into(), 3.0.into(), 0.2.into()];
    scene.driven_slider("shaker", (Body::GROUND.at(2.0, 0.0), 1.0), slide.point(), Harmonic, harmonic);
    scene.coulomb_sliding("rub", Body::GROUND.at(2.0, 0.0), 1.0, slide.point(), 0.4, 0.05);
    scene.spring_damper("link", slide.point(), bead.point(), 20.0, l * 0.5, 0.3);
    scene.cost("angle", AngleError, Sum::Terminal, [arm.coordinates[2]], [], [], [0.3.into()]);
    scene.cost("bead", AngleError, Sum::Terminal, [bead.coordinates[0]], [], [], [1.0.into()]);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(15, 0.01));
    inputs.start = Start::assembled(&system);
    inputs.controls.fill(2.0);
    assert_gradient_is_exact("particle", &system, &inputs);
    let at = Mechanics::at_start(&system, &inputs).expect("a start");
    let [x, y] = at.position(bob.point());
    assert!((x.hypot(y) - 0.8).abs() < 1e-14);
}

#[test]
fn a_particle_has_no_angle_to_hold() {
    let wrong: [fn(&mut Scene, Point, Body); 4] = [
        |scene, end, body| _ = scene.weld("weld", end, body.at(0.0, 0.0), 0.0),
        |scene, end, body| _ = scene.prismatic("rail", body.at(0.0, 0.0), 0.0, end, 0.0),
        |scene, end, body| scene.joint_friction("friction", end.frame(), body, 1.0),
        |scene, end, body| scene.torsional_spring_damper("spring", body, end.frame(), 1.0, 0.0, 0.0),
    ];
    for add in wrong {
        let mut scene = Scene::new();
        let (end, body) = (scene.particle("end", 1.0, [0.0; 2]).point(), scene.body("body", 1.0, 0.1, [0.0; 3]));
        add(&mut scene, end, body);
        let error = scene.compile().expect_err("an angle that is not there");
        assert!(matches!(error, Error::Particle { .. }), "{error}");
    }
}

#[test]
fn numbers_out_of_range_are_named() {
    let scene = |add: fn(&mut Scene, Body)| {
        let mut scene = Scene::new();
        let body = scene.body("body", 1.0, 0.1, [0.0; 3]);
        add(&mut scene, body);
        scene.compile().expect_err("a scene that is wrong")
    };
    let error = scene(|scene, body| scene.coulomb_friction("friction", Body::GROUND, body, 1.0, 0.0));
    assert_says(&error, &["the speed of `friction`", "positive"]);
    let error = scene(|scene, body| {
        let law = [1.0.into(), 0.0.into(), 0.0.into(), (-1.0).into()];
        scene.contact("floor", Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.0, 0.0), law);
    });
    assert_says(&error, &["friction speed of `floor`", "positive"]);
    let error = scene(|scene, _| scene.applied_force("push", Body::GROUND.at(0.0, 0.0), 0.0, Constant, [1.0.into()]));
    assert_says(&error, &["push"]);
}
