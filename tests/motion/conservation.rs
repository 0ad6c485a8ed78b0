//! What a motion keeps: energy to the order of the rule, linear momentum to rounding, and power in balance.

use crate::common::{assert_order, largest_difference};
use crate::scenes::assembly::{Assembly, GRAVITY, GROUND, Mechanism, Units};
use crate::scenes::by_hand::DoublePendulum;
use crate::scenes::mechanisms;
use crate::scenes::mechanisms::motor;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Grid, Inputs, LongSolver, Settings, Start, System, Trajectory, simulate};
use nalgebra::DVector;

/// Two rods hanging from the ground, a motor and friction in the first hinge.
fn chain(friction: f64) -> Mechanism {
    let mut assembly = Assembly::new(Units::SI, GRAVITY);
    let tip = [0.4f64, 1.0].map(|s| [s * (-1.2f64).cos(), s * (-1.2f64).sin()]);
    let (upper, lower) = (assembly.rod(1.0, [0.0; 2], tip[0]), assembly.rod(0.7, tip[0], tip[1]));
    assembly.hinge(GROUND, upper, [0.0; 2]);
    assembly.hinge(upper, lower, tip[0]);
    motor(&mut assembly, GROUND, upper);
    let upper = assembly.frame(upper);
    assembly.scene.joint_friction("friction", Body::GROUND, upper, friction);
    assembly.finish().expect("scene")
}

/// A crank, a rod and a slider: one closed loop.
fn slider_crank() -> Mechanism {
    let mut assembly = Assembly::new(Units::SI, GRAVITY);
    let (elbow, end) = ([0.2, 0.3], [1.0, 0.0]);
    let (crank, rod) = (assembly.rod(1.0, [0.0; 2], elbow), assembly.rod(1.5, elbow, end));
    let slider = assembly.body(0.7, 0.05, [end[0], end[1], 0.0]);
    assembly.hinge(GROUND, crank, [0.0; 2]);
    assembly.hinge(crank, rod, elbow);
    assembly.hinge(rod, slider, end);
    assembly.rail(slider, end);
    assembly.finish().expect("scene")
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

fn assert_energy_has_order_two(what: &str, system: &System, energy: impl Fn(&[f64], &[f64]) -> f64) {
    let errors = [500, 1000, 2000, 4000].map(|steps| {
        let (motion, _) = run(system, None, steps, 5.0, |_| 0.0);
        imbalance(&motion, &energy, |_| 0.0)
    });
    assert_order(what, &errors, 2.0, 0.05);
}

#[test]
fn the_error_of_the_energy_falls_with_the_square_of_the_step() {
    for (name, mechanism) in [("chain", chain(0.0)), ("slider-crank", slider_crank())] {
        assert_energy_has_order_two(name, &mechanism.system, |q, v| mechanism.energy(q, v));
    }
    let minimal = mechanisms::minimal().expect("scene");
    assert_energy_has_order_two("double pendulum, M(q)", &minimal, DoublePendulum::energy);
}

#[test]
fn the_work_of_motor_and_friction_is_the_change_of_energy() {
    const FRICTION: f64 = 0.3;
    let chain = chain(FRICTION);
    let errors = [500, 1000, 2000, 4000].map(|steps| {
        let (motion, inputs) = run(&chain.system, None, steps, 5.0, |t| 3.0 * (3.0 * t).sin());
        let power = |i: usize| inputs.controls[i] * motion.v[(2, i)] - FRICTION * motion.v[(2, i)] * motion.v[(2, i)];
        imbalance(&motion, |q, v| chain.energy(q, v), power)
    });
    assert_order("work", &errors, 2.0, 0.05);
}

/// Ten thousand steps of two hinged rods and a third on springs, free in the plane.
#[test]
fn linear_momentum_is_kept_to_rounding() {
    let mut assembly = Assembly::new(Units::SI, 0.0);
    let (one, two) = (assembly.rod(1.0, [0.0; 2], [0.0, 1.0]), assembly.rod(0.7, [0.0, 1.0], [0.5, 1.6]));
    let three = assembly.rod(2.0, [2.0, 0.0], [2.0, 1.0]);
    assembly.hinge(one, two, [0.0, 1.0]);
    assembly.spring((one, [0.0; 2]), (three, [2.0, 0.0]), 40.0, 1.5, 0.2);
    assembly.spring((two, [0.5, 1.6]), (three, [2.0, 1.0]), 25.0, 1.2, 0.0);
    motor(&mut assembly, one, two);
    let mechanism = assembly.finish().expect("scene");
    let system = &mechanism.system;
    let p_star = DVector::from_fn(system.n(), |i, _| 0.4 * (12.9 * (i + 1) as f64).sin());
    let start = Start::Momentum { q: system.initial_coordinates(), p_star };
    let (motion, _) = run(system, Some(start), 10_000, 50.0, |t| (2.0 * t).sin());
    let momentum =
        |i: usize, axis: usize| mechanism.momenta(motion.q.column(i).as_slice(), motion.v.column(i).as_slice())[axis];
    for axis in [0, 1] {
        let all: Vec<f64> = (0..motion.computed).map(|i| momentum(i, axis)).collect();
        let drift = largest_difference(&all, &vec![all[0]; all.len()]);
        println!("momentum along {axis}: {:.3} N s, drift {drift:.1e} N s", all[0]);
        assert!(drift < 1e-12, "drift {drift:.1e} N s");
    }
}

/// The largest energy error in the first and in the last tenth of a motion of 200 s.
fn errors_early_and_late(mechanism: &Mechanism, rebase_every: usize) -> (f64, f64) {
    let (system, steps) = (&mechanism.system, 20_000);
    let inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.01));
    let (mut start, mut early, mut late) = (0.0, 0.0f64, 0.0f64);
    let settings = Settings { rebase_every, ..Settings::default() };
    let run = LongSolver::new(system, settings, 10_000_000).simulate(&inputs, |state| {
        let now = mechanism.energy(state.q, state.v);
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
    for (name, mechanism) in [("chain", chain(0.0)), ("slider-crank", slider_crank())] {
        let plain = errors_early_and_late(&mechanism, 0);
        assert!(plain.1 > 2.0 * plain.0, "{name}: nothing to be seen without rebasing");
        for every in [1, 5, 10, 50] {
            let rebased = errors_early_and_late(&mechanism, every);
            println!("{name}: energy error early and late: {plain:.2?} J, rebased at every {every}th node {rebased:.4?} J");
            assert!(rebased.1 <= 1.25 * rebased.0, "{name}, every {every}: {rebased:?}");
        }
    }
}
