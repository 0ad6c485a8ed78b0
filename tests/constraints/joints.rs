//! Every planar joint and force between two moving bodies, and with the ground on either side: gradients with respect to everything.
//!
//! All constants are design variables; the cost uses everything that a cost may use.

use crate::common::assert_gradient_is_exact;
use crate::common::bench::{Bench, Part, from_velocity, lively};
use hamiltonian_adjoint::planar::{ConstantSpeed, Harmonic, Motion};
use hamiltonian_adjoint::{Multiplier, Param, Scalar, Sum};
use nalgebra::SVector;

/// Where the parts stand at the start, and a point that is a hinge of both.
const FIRST: [f64; 3] = [0.5, -0.2, -0.7];
const SECOND: [f64; 3] = [1.1, -0.9, 0.4];
const HINGE: [f64; 2] = [0.9, -0.6];

/// Adds something between two parts to three scenes, in which both parts move or one of them is the ground, and sums costs in all ways.
fn assert_exact(what: &str, add: impl Fn(&mut Bench, Part, Part)) {
    for place in ["moving", "on the ground", "to the ground"] {
        for sum in [Sum::Plain, Sum::Rectangle, Sum::Trapezoidal] {
            let system = scene_with(place, &add).compile(sum);
            let inputs = lively(&system, 12, 0.03);
            assert_gradient_is_exact(&format!("{what} {place}, {sum:?}, from p*"), &system, &inputs);
            let inputs = from_velocity(&system, &inputs);
            assert_gradient_is_exact(&format!("{what} {place}, {sum:?}, from v"), &system, &inputs);
        }
    }
}

fn scene_with(place: &str, add: impl Fn(&mut Bench, Part, Part)) -> Bench {
    let mut bench = Bench::new();
    let first = bench.body(FIRST);
    bench.hinge(Part::GROUND, first, [0.1, 0.2]);
    let second = bench.body(SECOND);
    // What is added may leave the second body without any joint: a hinged third one keeps a multiplier near.
    let third = bench.body([1.6, -0.3, 1.2]);
    bench.hinge(second, third, [1.4, -0.6]);
    bench.drive(first, third);
    match place {
        "moving" => add(&mut bench, first, second),
        "on the ground" => add(&mut bench, Part::GROUND, second),
        _ => add(&mut bench, second, Part::GROUND),
    }
    bench
}

fn note<const M: usize>(bench: &mut Bench, sigma: [Multiplier; M]) {
    bench.multipliers.extend(sigma);
}

#[test]
fn the_gradient_with_a_revolute_joint_is_exact() {
    assert_exact("revolute", |bench, a, b| bench.hinge(a, b, HINGE));
}

#[test]
fn the_gradient_with_a_prismatic_joint_is_exact() {
    assert_exact("prismatic", |bench, a, b| {
        let direction = 0.6f64;
        let there = [HINGE[0] + 0.3 * direction.cos(), HINGE[1] + 0.3 * direction.sin()];
        let (from, to) = (bench.point(a, HINGE), bench.point(b, there));
        let (axis, angle) = (bench.bound(direction - a.angle()), bench.bound(b.angle() - a.angle()));
        let sigma = bench.scene.prismatic("slider", from, axis, to, angle);
        note(bench, sigma);
    });
}

#[test]
fn the_gradient_with_a_weld_is_exact() {
    assert_exact("weld", |bench, a, b| {
        let (from, to) = (bench.point(a, HINGE), bench.point(b, HINGE));
        let angle = bench.bound(b.angle() - a.angle());
        let sigma = bench.scene.weld("weld", from, to, angle);
        note(bench, sigma);
    });
}

#[test]
fn the_gradient_with_a_distance_joint_is_exact() {
    assert_exact("distance", |bench, a, b| {
        let (from, to) = (bench.point(a, HINGE), bench.point(b, [1.3, -1.1]));
        let length = bench.bound(0.4f64.hypot(0.5));
        let sigma = bench.scene.distance("rod", from, to, length);
        note(bench, sigma);
    });
}

/// Adds a hinge and a driven angle f(t) whose first parameter is its value at t = 0 less `rest`.
fn driven<F: Motion<P>, const P: usize>(bench: &mut Bench, a: Part, b: Part, motion: F, rest: f64, others: &[f64]) {
    bench.hinge(a, b, HINGE);
    let first = b.angle() - a.angle() - rest;
    let parameters: [Param; P] = std::array::from_fn(|p| bench.bound(if p == 0 { first } else { others[p - 1] }).into());
    let sigma = bench.scene.driven_angle("motor", a.body, b.body, motion, parameters);
    note(bench, sigma);
}

#[test]
fn the_gradient_with_an_angle_driven_at_constant_speed_is_exact() {
    assert_exact("constant speed", |bench, a, b| driven(bench, a, b, ConstantSpeed, 0.0, &[1.7]));
}

#[test]
fn the_gradient_with_an_angle_driven_harmonically_is_exact() {
    let start = 0.4 * 0.3f64.sin();
    assert_exact("harmonic", |bench, a, b| driven(bench, a, b, Harmonic, start, &[0.4, 5.0, 0.3]));
}

/// φ₀ + c t³ eᵗ.
struct Own;
impl Motion<2> for Own {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 2>) -> S {
        b[0] + b[1] * t.powi(3) * t.exp()
    }
}

#[test]
fn the_gradient_with_an_angle_driven_by_a_motion_of_the_users_own_is_exact() {
    assert_exact("own motion", |bench, a, b| driven(bench, a, b, Own, 0.0, &[2.0]));
}

#[test]
fn the_gradient_with_a_spring_and_damper_is_exact() {
    assert_exact("spring and damper", |bench, a, b| {
        let (from, to) = (bench.point(a, HINGE), bench.point(b, [1.3, -1.1]));
        let (stiffness, length, damping) = (bench.bound(40.0), bench.bound(0.5), bench.bound(1.5));
        bench.scene.spring_damper("strut", from, to, stiffness, length, damping);
    });
}

#[test]
fn the_gradient_with_a_torsional_spring_and_damper_is_exact() {
    assert_exact("torsional spring and damper", |bench, a, b| {
        let (stiffness, angle, damping) = (bench.bound(3.0), bench.bound(0.5), bench.bound(0.2));
        bench.scene.torsional_spring_damper("coil", a.body, b.body, stiffness, angle, damping);
    });
}

#[test]
fn the_gradient_with_joint_friction_is_exact() {
    assert_exact("joint friction", |bench, a, b| {
        let damping = bench.bound(0.3);
        bench.scene.joint_friction("friction", a.body, b.body, damping);
    });
}

#[test]
fn the_gradient_with_sliding_friction_is_exact() {
    assert_exact("sliding friction", |bench, a, b| {
        let (from, to) = (bench.point(a, HINGE), bench.point(b, [1.3, -1.1]));
        let (axis, damping) = (bench.bound(0.5), bench.bound(1.2));
        bench.scene.sliding_friction("friction", from, axis, to, damping);
    });
}

#[test]
fn the_gradient_with_an_actuator_is_exact() {
    assert_exact("actuator", |bench, a, b| {
        let (from, to) = (bench.point(a, HINGE), bench.point(b, [1.3, -1.1]));
        let axis = bench.bound(0.5);
        let force = bench.control;
        bench.scene.actuator("cylinder", from, axis, to, force);
    });
}

#[test]
fn the_gradient_with_a_torque_actuator_is_exact() {
    assert_exact("torque actuator", |bench, a, b| {
        let torque = bench.control;
        bench.scene.torque_actuator("motor", a.body, b.body, torque);
    });
}
