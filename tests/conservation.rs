//! What a motion keeps: energy to the order of the rule, linear momentum to rounding, and power in balance.

mod common;

use common::{assert_order, largest_difference};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Grid, Inputs, KineticEnergy, LongSolver, PotentialEnergy, Scalar, Scene, Settings, Start, System, Trajectory, simulate,
};
use nalgebra::{DVector, SVector};

const GRAVITY: f64 = 9.81;

/// Bodies with mass, moment of inertia and gravity, as the energy needs them.
struct Bodies {
    scene: Scene,
    inertias: Vec<[f64; 2]>,
    gravity: f64,
}

impl Bodies {
    fn new(gravity: f64) -> Self {
        let mut scene = Scene::new();
        scene.gravity(0.0, -gravity);
        Bodies { scene, inertias: Vec::new(), gravity }
    }

    /// A thin rod and its half length.
    fn rod(&mut self, mass: f64, from: [f64; 2], to: [f64; 2]) -> (Body, f64) {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let place = [from[0] + 0.5 * dx, from[1] + 0.5 * dy, dy.atan2(dx)];
        (self.body(mass, mass * (dx * dx + dy * dy) / 12.0, place), 0.5 * dx.hypot(dy))
    }

    fn body(&mut self, mass: f64, inertia: f64, place: [f64; 3]) -> Body {
        self.inertias.push([mass, inertia]);
        self.scene.body(&format!("body {}", self.inertias.len()), mass, inertia, place)
    }

    fn finish(self) -> (System, impl Fn(&[f64], &[f64]) -> f64) {
        let Bodies { scene, inertias, gravity } = self;
        let energy = move |q: &[f64], v: &[f64]| {
            let of = |(k, [mass, inertia]): (usize, &[f64; 2])| {
                let [x, y, phi] = [0, 1, 2].map(|i| v[3 * k + i]);
                0.5 * (mass * (x * x + y * y) + inertia * phi * phi) + mass * gravity * q[3 * k + 1]
            };
            inertias.iter().enumerate().map(of).sum()
        };
        (scene.compile().expect("scene"), energy)
    }
}

/// Two rods hanging from the ground, a motor and friction in the first hinge.
fn chain(friction: f64) -> (System, impl Fn(&[f64], &[f64]) -> f64) {
    let mut bodies = Bodies::new(GRAVITY);
    let tip = [0.4f64, 1.0].map(|s| [s * (-1.2f64).cos(), s * (-1.2f64).sin()]);
    let ((upper, a), (lower, b)) = (bodies.rod(1.0, [0.0; 2], tip[0]), bodies.rod(0.7, tip[0], tip[1]));
    let torque = bodies.scene.control("torque");
    bodies.scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-a, 0.0));
    bodies.scene.revolute("elbow", upper.at(a, 0.0), lower.at(-b, 0.0));
    bodies.scene.torque_actuator("motor", Body::GROUND, upper, torque);
    bodies.scene.joint_friction("friction", Body::GROUND, upper, friction);
    bodies.finish()
}

/// A crank, a rod and a slider: one closed loop.
fn slider_crank() -> (System, impl Fn(&[f64], &[f64]) -> f64) {
    let mut bodies = Bodies::new(GRAVITY);
    let (elbow, end) = ([0.2, 0.3], [1.0, 0.0]);
    let ((crank, a), (rod, b)) = (bodies.rod(1.0, [0.0; 2], elbow), bodies.rod(1.5, elbow, end));
    let slider = bodies.body(0.7, 0.05, [end[0], end[1], 0.0]);
    bodies.scene.revolute("main", Body::GROUND.at(0.0, 0.0), crank.at(-a, 0.0));
    bodies.scene.revolute("elbow", crank.at(a, 0.0), rod.at(-b, 0.0));
    bodies.scene.revolute("pin", rod.at(b, 0.0), slider.at(0.0, 0.0));
    bodies.scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, slider.at(0.0, 0.0), 0.0);
    bodies.finish()
}

/// A double pendulum in its angles.
struct Angles;

impl KineticEnergy<2> for Angles {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, _: &SVector<S, 0>) -> S {
        v[0] * v[0] + v[1] * v[1] * 0.5 + v[0] * v[1] * (q[0] - q[1]).cos()
    }
}

impl PotentialEnergy<2> for Angles {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> S {
        -(q[0].cos() * 2.0 + q[1].cos()) * GRAVITY
    }
}

fn minimal() -> (System, impl Fn(&[f64], &[f64]) -> f64) {
    let mut scene = Scene::new();
    let q = scene.coordinates("pendulum", ["φ1", "φ2"]);
    scene.kinetic_energy("T", Angles, q, []);
    scene.potential_energy("V", Angles, q, []);
    q.into_iter().zip([0.9, 0.6]).for_each(|(q, angle)| scene.place(q, angle));
    let energy = |q: &[f64], v: &[f64]| {
        let ([q, v], b) = ([q, v].map(SVector::<f64, 2>::from_column_slice), SVector::from([]));
        Angles.kinetic_energy(&q, &v, &b) + Angles.potential_energy(&q, &b, 0.0)
    };
    (scene.compile().expect("scene"), energy)
}

fn run(system: &System, start: Option<Start>, steps: usize, duration: f64, torque: fn(f64) -> f64) -> (Trajectory, Inputs) {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, duration / steps as f64));
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = torque(t));
    inputs.start = start.unwrap_or(inputs.start);
    (simulate(system, &inputs, Settings::default()).expect("motion"), inputs)
}

/// The largest deviation of the energy from what it is at first plus the work of `power` by the trapezoidal rule.
fn imbalance(motion: &Trajectory, energy: impl Fn(&[f64], &[f64]) -> f64, power: impl Fn(usize) -> f64) -> f64 {
    let at = |i: usize| energy(motion.q.column(i).as_slice(), motion.v.column(i).as_slice());
    let (start, mut work, mut worst) = (at(0), 0.0, 0.0f64);
    for i in 1..motion.computed {
        work += 0.5 * (motion.times[i] - motion.times[i - 1]) * (power(i - 1) + power(i));
        worst = worst.max((at(i) - start - work).abs());
    }
    worst
}

fn assert_energy_has_order_two(what: &str, (system, energy): &(System, impl Fn(&[f64], &[f64]) -> f64)) {
    let errors = [500, 1000, 2000, 4000].map(|steps| {
        let (motion, _) = run(system, None, steps, 5.0, |_| 0.0);
        imbalance(&motion, energy, |_| 0.0)
    });
    assert_order(what, &errors, 2.0, 0.05);
}

#[test]
fn the_error_of_the_energy_falls_with_the_square_of_the_step() {
    assert_energy_has_order_two("chain", &chain(0.0));
    assert_energy_has_order_two("slider-crank", &slider_crank());
    assert_energy_has_order_two("double pendulum, M(q)", &minimal());
}

#[test]
fn the_work_of_motor_and_friction_is_the_change_of_energy() {
    const FRICTION: f64 = 0.3;
    let (system, energy) = chain(FRICTION);
    let errors = [500, 1000, 2000, 4000].map(|steps| {
        let (motion, inputs) = run(&system, None, steps, 5.0, |t| 3.0 * (3.0 * t).sin());
        let power = |i: usize| inputs.controls[i] * motion.v[(2, i)] - FRICTION * motion.v[(2, i)] * motion.v[(2, i)];
        imbalance(&motion, &energy, power)
    });
    assert_order("work", &errors, 2.0, 0.05);
}

/// Ten thousand steps of two hinged rods and a third on springs, free in the plane.
#[test]
fn linear_momentum_is_kept_to_rounding() {
    let mut bodies = Bodies::new(0.0);
    let ((one, a), (two, b)) = (bodies.rod(1.0, [0.0; 2], [0.0, 1.0]), bodies.rod(0.7, [0.0, 1.0], [0.5, 1.6]));
    let (three, _) = bodies.rod(2.0, [2.0, 0.0], [2.0, 1.0]);
    bodies.scene.revolute("hinge", one.at(a, 0.0), two.at(-b, 0.0));
    bodies.scene.spring_damper("first", one.at(-a, 0.0), three.at(-0.5, 0.0), 40.0, 1.5, 0.2);
    bodies.scene.spring_damper("second", two.at(b, 0.0), three.at(0.5, 0.0), 25.0, 1.2, 0.0);
    let torque = bodies.scene.control("torque");
    bodies.scene.torque_actuator("motor", one, two, torque);
    let masses = bodies.inertias.clone();
    let (system, _) = bodies.finish();
    let p_star = DVector::from_fn(system.n(), |i, _| 0.4 * (12.9 * (i + 1) as f64).sin());
    let start = Start::Momentum { q: system.initial_coordinates(), p_star };
    let (motion, _) = run(&system, Some(start), 10_000, 50.0, |t| (2.0 * t).sin());
    let momentum = |i: usize, axis: usize| -> f64 {
        masses.iter().enumerate().map(|(k, [mass, _])| mass * motion.v[(3 * k + axis, i)]).sum()
    };
    for axis in [0, 1] {
        let all: Vec<f64> = (0..motion.computed).map(|i| momentum(i, axis)).collect();
        let drift = largest_difference(&all, &vec![all[0]; all.len()]);
        println!("momentum along {axis}: {:.3} N s, drift {drift:.1e} N s", all[0]);
        assert!(drift < 1e-12, "drift {drift:.1e} N s");
    }
}

/// The largest energy error in the first and in the last tenth of a motion of 200 s.
fn errors_early_and_late(system: &System, energy: &Energy, rebase_every: usize) -> (f64, f64) {
    let steps = 20_000;
    let inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.01));
    let (mut start, mut early, mut late) = (0.0, 0.0f64, 0.0f64);
    let settings = Settings { rebase_every, ..Settings::default() };
    let run = LongSolver::new(system, settings, 10_000_000).simulate(&inputs, |state| {
        let now = energy(state.q, state.v);
        match state.node {
            0 => start = now,
            node if node <= steps / 10 => early = early.max((now - start).abs()),
            node if node > steps - steps / 10 => late = late.max((now - start).abs()),
            _ => (),
        }
    });
    // Without rebasing a motion may stop: then there is no late error.
    if run.is_ok() { (early, late) } else { (early, f64::INFINITY) }
}

#[test]
fn the_energy_does_not_drift_if_the_multipliers_begin_anew() {
    for (name, (system, energy)) in [("chain", boxed(chain(0.0))), ("slider-crank", boxed(slider_crank()))] {
        let plain = errors_early_and_late(&system, &energy, 0);
        assert!(plain.1 > 2.0 * plain.0, "{name}: nothing to be seen without rebasing");
        for every in [1, 5, 10, 50] {
            let rebased = errors_early_and_late(&system, &energy, every);
            println!("{name}: energy error early and late: {plain:.2?} J, rebased at every {every}th node {rebased:.4?} J");
            assert!(rebased.1 <= 1.25 * rebased.0, "{name}, every {every}: {rebased:?}");
        }
    }
}

type Energy = Box<dyn Fn(&[f64], &[f64]) -> f64>;

fn boxed((system, energy): (System, impl Fn(&[f64], &[f64]) -> f64 + 'static)) -> (System, Energy) {
    (system, Box::new(energy))
}
