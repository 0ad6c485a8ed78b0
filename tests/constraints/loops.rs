//! Mechanisms with closed loops, branches, several parts or no ground: the constraints hold and every derivative is exact.

use crate::common::bench::{Bench, Part, from_velocity, lively};
use crate::common::{assert_gradient_is_exact, assert_order, largest};
use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::planar::ConstantSpeed;
use hamiltonian_adjoint::{Inputs, Param, Settings, Sum, System, Trajectory, simulate};

fn motion(system: &System, inputs: &Inputs) -> Trajectory {
    simulate(system, inputs, Settings::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Adds the mechanism to a scene, asserts dΦ/dt = 0 along a motion, and derivatives for all inputs of a shorter one.
fn assert_sound(what: &str, freedom: usize, running: Sum, build: impl Fn(&mut Bench)) {
    let mut bench = Bench::new();
    build(&mut bench);
    let system = bench.compile(running);
    assert_eq!(system.n() - system.m(), freedom, "{what}: degrees of freedom");
    let inputs = lively(&system, 200, 0.005);
    let rate = largest(motion(&system, &inputs).phi_dot(&system, &inputs).expect("motion").as_slice());
    println!("{what}: dΦ/dt {rate:.1e}");
    assert!(rate <= 1e-12, "{what}: dΦ/dt = {rate:.2e}");
    assert_gradient_is_exact(what, &system, &lively(&system, 12, 0.02));
}

#[test]
fn the_gradient_of_a_four_bar_agrees_with_complex_step() {
    assert_sound("four-bar", 1, Sum::Trapezoidal, Bench::four_bar);
}

/// All orders of four things.
fn orders() -> Vec<[usize; 4]> {
    let all = (0..256).map(|k| [k % 4, k / 4 % 4, k / 16 % 4, k / 64]);
    all.filter(|order| (0..4).all(|i| order.contains(&i))).collect()
}

/// A loop of four rods with four hinges, listed in some order; on the ground if the last rod is.
fn closed_loop(bench: &mut Bench, fourth_is_ground: bool, order: [usize; 4]) {
    let corners = [[0.0, 0.0], [0.1, 0.4], [0.9, 0.7], [1.0, 0.0]];
    let mut rods: Vec<Part> = (0..3).map(|i| bench.rod(corners[i], corners[i + 1])).collect();
    rods.push(if fourth_is_ground { Part::GROUND } else { bench.rod(corners[3], corners[0]) });
    for i in order {
        bench.hinge(rods[i], rods[(i + 1) % 4], corners[(i + 1) % 4]);
    }
    bench.drive(rods[0], rods[1]);
}

#[test]
fn a_loop_may_list_its_joints_in_any_order() {
    for order in orders() {
        assert_sound(&format!("four-bar {order:?}"), 1, Sum::Plain, |bench| closed_loop(bench, true, order));
        assert_sound(&format!("free loop {order:?}"), 4, Sum::Plain, |bench| closed_loop(bench, false, order));
    }
}

#[test]
fn the_gradient_of_a_slider_crank_agrees_with_complex_step() {
    assert_sound("slider-crank", 1, Sum::Rectangle, |bench| {
        let [a, b, c] = [[0.0, 0.0], [0.2, 0.3], [1.0, 0.0]];
        let (crank, rod, slider) = (bench.rod(a, b), bench.rod(b, c), bench.body([1.0, 0.0, 0.0]));
        bench.hinge(Part::GROUND, crank, a);
        bench.hinge(crank, rod, b);
        bench.hinge(rod, slider, c);
        let (rail, centre) = (bench.point(Part::GROUND, a), bench.point(slider, c));
        let (axis, angle) = (bench.bound(0.0), bench.bound(0.0));
        let sigma = bench.scene.prismatic("guide", rail, axis, centre, angle);
        bench.multipliers.extend(sigma);
        bench.drive(Part::GROUND, crank);
    });
}

#[test]
fn the_gradient_of_a_body_with_three_children_agrees_with_complex_step() {
    assert_sound("tree", 5, Sum::Plain, |bench| {
        let trunk = bench.rod([0.0, 0.0], [0.0, -1.0]);
        bench.hinge(Part::GROUND, trunk, [0.0, 0.0]);
        let ends = [[-0.5, -1.2], [0.1, -1.6], [0.6, -1.1]];
        let children = ends.map(|end| {
            let child = bench.rod([0.0, -1.0], end);
            bench.hinge(trunk, child, [0.0, -1.0]);
            child
        });
        let grandchild = bench.rod(ends[1], [0.3, -2.0]);
        bench.hinge(children[1], grandchild, ends[1]);
        bench.drive(trunk, children[0]);
    });
}

/// Four-bars on top of one another, each on the rung of the one below; the hinges of each are listed in this order.
fn ladder(bench: &mut Bench, base: Part, loops: usize, order: [usize; 4]) {
    let mut rung = base;
    let corner = |side: f64, k: usize| [side * (0.5 - 0.04 * k as f64) + 0.03 * (k * k) as f64, 0.5 * k as f64];
    for k in 0..loops {
        let [left, right] = [-1.0, 1.0].map(|side| [corner(side, k), corner(side, k + 1)]);
        let rails = [bench.rod(left[0], left[1]), bench.rod(right[0], right[1])];
        let next = bench.rod(left[1], right[1]);
        let hinges =
            [(rung, rails[0], left[0]), (rung, rails[1], right[0]), (rails[0], next, left[1]), (rails[1], next, right[1])];
        for (a, b, at) in order.map(|i| hinges[i]) {
            bench.hinge(a, b, at);
        }
        rung = next;
    }
    bench.drive(bench.parts[0], bench.parts[2]);
}

#[test]
fn the_gradient_of_a_ladder_of_five_loops_agrees_with_complex_step() {
    let build = |bench: &mut Bench| ladder(bench, Part::GROUND, 5, [0, 1, 2, 3]);
    assert_sound("ladder", 5, Sum::Trapezoidal, build);
}

#[test]
fn a_ladder_moves_in_whatever_order_its_joints_are_listed_and_without_ground_too() {
    let all = orders().into_iter().flat_map(|order| [0, 1, 2, 3].map(|k| (order, k / 2 == 0, k % 2 == 0)));
    for (order, on_ground, sprung) in all {
        let mut bench = Bench::new();
        let base = if on_ground { Part::GROUND } else { bench.rod([-0.5, 0.0], [0.5, 0.0]) };
        ladder(&mut bench, base, 4, order);
        // Springs between the rails couple them, which changes the order of elimination.
        for k in 0..if sprung { 4 } else { 0 } {
            let first = 3 * k + usize::from(!on_ground);
            let [left, right] = [bench.parts[first], bench.parts[first + 1]];
            let (from, to) = (bench.point(left, [-0.4, 0.1]), bench.point(right, [0.4, 0.1]));
            bench.scene.spring_damper(&format!("spring {k}"), from, to, 5.0, 0.7, 0.1);
        }
        let system = bench.compile(Sum::Plain);
        let inputs = lively(&system, 20, 0.005);
        let rate = largest(motion(&system, &inputs).phi_dot(&system, &inputs).expect("motion").as_slice());
        assert!(rate <= 1e-12, "{order:?}: dΦ/dt = {rate:.2e}");
    }
}

#[test]
fn the_gradient_of_two_pendulums_coupled_by_springs_agrees_with_complex_step() {
    assert_sound("coupled pendulums", 2, Sum::Rectangle, |bench| {
        let (one, two) = (bench.rod([0.0, 0.0], [0.1, -1.0]), bench.rod([1.0, 0.0], [0.8, -1.0]));
        bench.hinge(Part::GROUND, one, [0.0, 0.0]);
        bench.hinge(Part::GROUND, two, [1.0, 0.0]);
        for (name, height) in [("upper", -0.4), ("lower", -0.9)] {
            let (from, to) = (bench.point(one, [0.05, height]), bench.point(two, [0.9, height]));
            let (stiffness, length, damping) = (bench.bound(30.0), bench.bound(0.7), bench.bound(0.5));
            bench.scene.spring_damper(name, from, to, stiffness, length, damping);
        }
        bench.drive(Part::GROUND, one);
    });
}

#[test]
fn the_gradient_of_two_mechanisms_in_one_scene_agrees_with_complex_step() {
    assert_sound("two mechanisms", 3, Sum::Plain, |bench| {
        let one = bench.rod([0.0, 0.0], [0.6, -0.5]);
        bench.hinge(Part::GROUND, one, [0.0, 0.0]);
        bench.drive(Part::GROUND, one);
        let (two, three) = (bench.rod([5.0, 0.0], [5.3, -0.7]), bench.rod([5.3, -0.7], [5.9, -1.0]));
        bench.hinge(two, three, [5.3, -0.7]);
        bench.hinge(Part::GROUND, two, [5.0, 0.0]);
    });
}

/// Three rods that nothing holds, with a motor between the first two.
fn free_chain(bench: &mut Bench) {
    let points = [[0.0, 0.0], [0.7, 0.2], [1.2, -0.3], [1.9, 0.0]];
    let rods = [0, 1, 2].map(|i| bench.rod(points[i], points[i + 1]));
    bench.hinge(rods[0], rods[1], points[1]);
    bench.hinge(rods[1], rods[2], points[2]);
    bench.drive(rods[0], rods[1]);
}

#[test]
fn the_gradient_of_a_chain_without_ground_agrees_with_complex_step() {
    assert_sound("free chain", 5, Sum::Trapezoidal, free_chain);
}

/// Masses and moments of inertia of the chain's rods (see `Bench::body`).
fn momenta(motion: &Trajectory, i: usize) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for k in 0..3 {
        let (mass, inertia) = (0.8 + 0.3 * k as f64, 0.05 + 0.02 * k as f64);
        let at = |matrix: &nalgebra::DMatrix<f64>| [0, 1, 2].map(|j| matrix[(3 * k + j, i)]);
        let ([x, y, _], [vx, vy, turn]) = (at(&motion.q), at(&motion.v));
        sum[0] += mass * vx;
        sum[1] += mass * vy;
        sum[2] += mass * (x * vy - y * vx) + inertia * turn;
    }
    sum
}

/// Linear momentum is conserved by the step, being linear; angular momentum with the order of the rule.
#[test]
fn a_chain_without_ground_and_gravity_keeps_its_momentum() {
    let mut bench = Bench::new();
    free_chain(&mut bench);
    let system = bench.compile(Sum::Plain);
    let errors = [100, 200, 400, 800].map(|steps| {
        let mut inputs = lively(&system, steps, 1.0 / steps as f64);
        inputs.grid.steps.fill(1.0 / steps as f64);
        // The first two design variables are gravity. The motor's torque is internal.
        inputs.design.rows_mut(0, 2).fill(0.0);
        inputs.controls.fill(0.3);
        let motion = motion(&system, &inputs);
        let drift =
            |j: usize| (0..=steps).map(|i| (momenta(&motion, i)[j] - momenta(&motion, 0)[j]).abs()).fold(0.0, f64::max);
        assert!(drift(0).max(drift(1)) < 1e-13, "linear momentum changes by {:.1e} N s", drift(0).max(drift(1)));
        drift(2)
    });
    assert_order("angular momentum", &errors, 2.0, 0.05);
}

#[test]
fn complex_step_of_a_driven_four_bar_near_its_dead_centre_converges() {
    for offset in [0.03, 0.01, 0.003, 0.001, -0.001, -0.003, -0.01] {
        let mut bench = Bench::new();
        let [a, b, c, d] = [[0.0, 0.0], [0.1, 0.4], [0.5, 0.22 + offset], [1.0, 0.0]];
        let (crank, coupler, rocker) = (bench.rod(a, b), bench.rod(b, c), bench.rod(d, c));
        bench.hinge(Part::GROUND, crank, a);
        bench.hinge(crank, coupler, b);
        bench.hinge(coupler, rocker, c);
        bench.hinge(Part::GROUND, rocker, d);
        let motion = [bench.bound(crank.angle()), bench.bound(0.5)].map(Param::from);
        let sigma = bench.scene.driven_angle("motor", Part::GROUND.body, crank.body, ConstantSpeed, motion);
        bench.multipliers.extend(sigma);
        let system = bench.compile(Sum::Plain);
        let inputs = from_velocity(&system, &lively(&system, 1, 1e-6));
        let derivatives = complex_step(&system, &inputs, Settings::default(), &Input::all(&inputs));
        assert!(derivatives.is_ok(), "{offset} m: {derivatives:?}");
    }
}
