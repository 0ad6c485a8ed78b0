//! Mechanisms that tests and the stress report try.
#![allow(dead_code)]

use std::f64::consts::FRAC_PI_2;

use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Error, Grid, Inputs, Scene, Sum, System};

use super::assembly::{Assembly, GRAVITY, GROUND, Mechanism, Part, Units};
use super::by_hand::{DoublePendulum, Ends, Gears, Quadratic, Runaway, SameAbscissa};

/// A motor (N m) in the joint of two parts.
pub fn motor(assembly: &mut Assembly, a: Part, b: Part) {
    let (name, a, b) = (assembly.name("motor"), assembly.frame(a), assembly.frame(b));
    let torque = assembly.scene.control(&name);
    assembly.scene.torque_actuator(&name, a, b, torque);
}

/// The cost ½ (φ − 1)² at the end on every body.
fn aim(assembly: &mut Assembly) {
    for k in 0..assembly.bodies.len() {
        let name = assembly.name("angle");
        let [_, _, angle] = assembly.bodies[k].body.coordinates;
        assembly.scene.cost(&name, AngleError, Sum::Terminal, [angle], [], [], [1.0.into()]);
    }
}

/// A chain of rods of 1 m that hangs from the origin at this angle, with these masses, a motor in the first hinge, and viscous
/// friction (N m s/rad) there.
pub fn chain(units: Units, masses: &[f64], angle: f64, friction: f64) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(units, GRAVITY);
    let tip = |k: usize| [k as f64 * angle.cos(), k as f64 * angle.sin()];
    let mut inner = GROUND;
    for (k, &mass) in masses.iter().enumerate() {
        let rod = assembly.rod(mass, tip(k), tip(k + 1));
        assembly.hinge(inner, rod, tip(k));
        inner = rod;
    }
    motor(&mut assembly, GROUND, Some(0));
    if friction > 0.0 {
        let first = assembly.frame(Some(0));
        let friction = friction * units.torque() * units.time;
        assembly.scene.joint_friction("friction", assembly.frame(GROUND), first, friction);
    }
    aim(&mut assembly);
    assembly.finish()
}

/// A crank at this angle, a rod and a slider on a rail with a motor at the crank; of equal lengths, it passes a singular
/// configuration where crank and rod lie over each other.
pub fn slider_crank(units: Units, crank: f64, rod: f64, angle: f64) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(units, GRAVITY);
    let elbow = [crank * angle.cos(), crank * angle.sin()];
    let slider = [elbow[0] + (rod * rod - elbow[1] * elbow[1]).sqrt(), 0.0];
    let first = assembly.rod(1.0, [0.0; 2], elbow);
    let second = assembly.rod(1.5, elbow, slider);
    let block = assembly.body(0.7, 0.05, [slider[0], 0.0, 0.0]);
    assembly.hinge(GROUND, first, [0.0; 2]);
    assembly.hinge(first, second, elbow);
    assembly.hinge(second, block, slider);
    assembly.rail(block, slider);
    motor(&mut assembly, GROUND, first);
    aim(&mut assembly);
    assembly.finish()
}

/// Parallel cranks of 1 m at this angle that carry a coupler of 2 m, with a motor at the first: it passes flat at the angles 0 and π,
/// and more than two cranks are redundant.
pub fn parallelogram(cranks: usize, angle: f64) -> Result<Mechanism, Error> {
    cranks_on_coupler(cranks, cranks, angle)
}

/// The same with three cranks, of which the middle one is joined to the coupler by half a hinge, and nothing is redundant.
pub fn parallelogram_with_half_a_hinge(angle: f64) -> Result<Mechanism, Error> {
    cranks_on_coupler(3, 2, angle)
}

/// Cranks of which the outer ones are hinged to the coupler; the others are too if that is asked for, else by half of a hinge.
fn cranks_on_coupler(cranks: usize, carrying: usize, angle: f64) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(Units::SI, GRAVITY);
    let foot = |k: usize| [2.0 * k as f64 / (cranks - 1) as f64, 0.0];
    let head = |k: usize| [foot(k)[0] + angle.cos(), angle.sin()];
    let all: Vec<Part> = (0..cranks).map(|k| assembly.rod(1.0, foot(k), head(k))).collect();
    let coupler = assembly.rod(1.0, head(0), head(cranks - 1));
    for (k, &crank) in all.iter().enumerate() {
        assembly.hinge(GROUND, crank, foot(k));
        if carrying == cranks || k == 0 || k == cranks - 1 {
            assembly.hinge(crank, coupler, head(k));
        } else {
            let ends = [crank, coupler].map(|part| (assembly.coordinates(part), assembly.local(part, head(k))));
            let [([x, y, phi], [along, across]), (q, [other_along, other_across])] = ends;
            let constants = [along, across, other_along, other_across].map(Into::into);
            assembly.scene.constraint("half a hinge", SameAbscissa, [x, y, phi, q[0], q[1], q[2]], constants);
        }
    }
    motor(&mut assembly, GROUND, all[0]);
    aim(&mut assembly);
    assembly.finish()
}

/// A four-bar whose ground link and coupler are as long as its cranks, which stand at this angle: at angle 0 its branches meet.
pub fn rhombus(angle: f64) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(Units::SI, 0.0);
    let [a, b] = [[angle.cos(), angle.sin()], [1.0 + angle.cos(), angle.sin()]];
    let (left, coupler) = (assembly.rod(1.0, [0.0; 2], a), assembly.rod(0.5, a, b));
    let right = assembly.rod(2.0, [1.0, 0.0], b);
    assembly.hinge(GROUND, left, [0.0; 2]);
    assembly.hinge(GROUND, right, [1.0, 0.0]);
    assembly.hinge(left, coupler, a);
    assembly.hinge(coupler, right, b);
    motor(&mut assembly, GROUND, left);
    aim(&mut assembly);
    assembly.finish()
}

/// A double pendulum whose elbow is hinged so many times.
pub fn doubled_hinge(hinges: usize) -> Result<Mechanism, Error> {
    elbow(|assembly, [upper, lower]| (1..hinges).for_each(|_| assembly.hinge(upper, lower, [1.0, 0.0])))
}

/// A double pendulum with more constraints on its rods.
pub fn elbow(add: impl FnOnce(&mut Assembly, [Part; 2])) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(Units::SI, GRAVITY);
    let (upper, lower) = (assembly.rod(1.0, [0.0; 2], [1.0, 0.0]), assembly.rod(1.0, [1.0, 0.0], [1.6, 0.8]));
    assembly.hinge(GROUND, upper, [0.0; 2]);
    assembly.hinge(upper, lower, [1.0, 0.0]);
    add(&mut assembly, [upper, lower]);
    motor(&mut assembly, GROUND, upper);
    aim(&mut assembly);
    assembly.finish()
}

/// A rigid triangle of three rods on a hinge, two corners welded, the third hinged (enough) or welded (three equations too many).
pub fn triangle(over_closed: bool) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(Units::SI, GRAVITY);
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.4, 0.7]];
    let sides = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| assembly.rod(1.0, corners[i], corners[j]));
    assembly.hinge(GROUND, sides[0], corners[0]);
    assembly.weld(sides[0], sides[1], corners[1]);
    assembly.weld(sides[1], sides[2], corners[2]);
    if over_closed {
        assembly.weld(sides[2], sides[0], corners[0]);
    }
    motor(&mut assembly, GROUND, sides[0]);
    aim(&mut assembly);
    assembly.finish()
}

/// Two pairs of hinged rods with springs between them and nothing else: free in the plane, without gravity.
pub fn free_pairs() -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(Units::SI, 0.0);
    let pair = |assembly: &mut Assembly, x: f64| {
        let (a, b) = (assembly.rod(1.0, [x, 0.0], [x, 1.0]), assembly.rod(0.7, [x, 1.0], [x + 0.5, 1.6]));
        assembly.hinge(a, b, [x, 1.0]);
        (a, b)
    };
    let ((a, b), (c, d)) = (pair(&mut assembly, 0.0), pair(&mut assembly, 2.0));
    assembly.spring((a, [0.0, 0.0]), (c, [2.0, 0.0]), 40.0, 1.5, 0.0);
    assembly.spring((b, [0.5, 1.6]), (d, [2.5, 1.6]), 25.0, 2.2, 0.0);
    motor(&mut assembly, a, b);
    aim(&mut assembly);
    assembly.finish()
}

/// What pulls the body of an oscillator.
#[derive(Clone, Copy, PartialEq)]
pub enum Pull {
    /// Nothing.
    None,
    /// A potential ½ c (x − 1)².
    Linear(f64),
    /// A spring c to the point x = 0, with a second place of rest at x = −1.
    Spring(f64),
}

/// A body of 1 kg on a rail with a damper (N s/m), 0.1 m away from its rest at x = 1; a force pushes it.
pub fn oscillator(pull: Pull, damping: f64) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(Units::SI, 0.0);
    let body = assembly.body(1.0, 0.1, [1.1, 0.0, 0.0]);
    assembly.rail(body, [1.1, 0.0]);
    let x = assembly.bodies[0].body.coordinates[0];
    match pull {
        Pull::None => {}
        Pull::Linear(stiffness) => assembly.scene.potential_energy("pull", Quadratic, [x], [stiffness.into()]),
        Pull::Spring(stiffness) => assembly.spring((GROUND, [0.0; 2]), (body, [1.1, 0.0]), stiffness, 1.0, 0.0),
    }
    let (origin, centre) = (assembly.point(GROUND, [0.0; 2]), assembly.point(body, [1.1, 0.0]));
    if damping > 0.0 {
        assembly.scene.sliding_friction("damper", origin, 0.0, centre, damping);
    }
    let push = assembly.scene.control("push");
    assembly.scene.actuator("push", origin, 0.0, centre, push);
    assembly.scene.cost("place", AngleError, Sum::Terminal, [x], [], [], [0.3.into()]);
    assembly.finish()
}

/// A rod of 1 m on a stiff spring (N/m) of 1 m in place of a hinge.
pub fn spring_pendulum(stiffness: f64) -> Result<Mechanism, Error> {
    let mut assembly = Assembly::new(Units::SI, GRAVITY);
    let rod = assembly.rod(1.0, [1.0, 0.0], [2.0, 0.0]);
    assembly.spring((GROUND, [0.0; 2]), (rod, [1.0, 0.0]), stiffness, 1.0, 0.0);
    motor(&mut assembly, GROUND, rod);
    aim(&mut assembly);
    assembly.finish()
}

/// The paper's cart with three links in any units.
pub fn cart(units: Units, links: usize) -> CartPendulum {
    let example = CartPendulum::with_links(links);
    let Units { length: l, mass: m, time: t } = units;
    CartPendulum {
        cart_mass: example.cart_mass * m,
        cart_inertia: example.cart_inertia * m * l * l,
        link_mass: example.link_mass * m,
        link_inertia: example.link_inertia * m * l * l,
        link_length: example.link_length * l,
        rail_friction: example.rail_friction * m / t,
        hinge_friction: example.hinge_friction * m * l * l / t,
        gravity: example.gravity * l / (t * t),
        ..example
    }
}

/// The system of the paper's cart with so many links.
pub fn paper_cart(links: usize) -> Result<System, Error> {
    cart(Units::SI, links).scene().compile()
}

/// The slider-crank that most rows are about.
pub fn crank() -> Result<Mechanism, Error> {
    slider_crank(Units::SI, 0.4, 0.9, 1.0)
}

/// A chain of three rods that swings a little, which is quasi-periodic.
pub fn swinging_chain() -> Result<Mechanism, Error> {
    chain(Units::SI, &[1.0, 0.8, 0.6], -1.2, 0.0)
}

/// The double pendulum in its angles, which start at 0.9 rad and 0.6 rad.
pub fn minimal() -> Result<System, Error> {
    let mut scene = Scene::new();
    let q = scene.coordinates("pendulum", ["φ1", "φ2"]);
    scene.kinetic_energy("masses", DoublePendulum, q, []);
    scene.potential_energy("weight", DoublePendulum, q, []);
    q.into_iter().zip([0.9, 0.6]).for_each(|(q, angle)| scene.place(q, angle));
    scene.cost("angle", AngleError, Sum::Terminal, [q[1]], [], [], [FRAC_PI_2.into()]);
    scene.compile()
}

/// A chain of three rods of which the middle one has this share of its mass, also none at all.
pub fn light_middle(share: f64) -> Result<Mechanism, Error> {
    chain(Units::SI, &[1.0, share, 1.0], -1.0, 0.0)
}

/// A chain whose middle is a massless coordinate of one's own between two bodies.
pub fn coordinate_without_inertia() -> Result<System, Error> {
    let mut scene = Scene::new();
    let q = scene.coordinates("chain", ["first", "middle", "last"]);
    scene.kinetic_energy("ends", Ends, q, []);
    scene.constraint("gears", Gears, q, []);
    scene.compile()
}

/// A sled driven by its own speed, costs summed in these ways: six easy steps, two that must be divided, and one more.
pub fn sled(sums: &[Sum]) -> Result<(System, Inputs), Error> {
    let mut scene = Scene::new();
    let q = scene.coordinates("sled", ["x"]);
    let (u, b) = (scene.control("push"), scene.design("gain", 1.0));
    scene.kinetic_energy("mass", Runaway, q, []);
    scene.force("drive", Runaway, q, [u], [b.into()]);
    for (k, sum) in sums.iter().enumerate() {
        scene.cost(&format!("cost {k}"), Runaway, *sum, q, [], [u], []);
    }
    let system = scene.compile()?;
    let steps = vec![0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.5, 0.15, 0.01];
    let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, steps));
    inputs.start.rate_mut()[0] = 1.0;
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 0.01 * (i as f64).sin());
    Ok((system, inputs))
}
