//! Restarts of mechanisms that pass through configurations where their constraints lose rank: parallelograms that lie flat.

use crate::common::{assert_same_derivatives_to, largest};
use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Solver, Sum, System, gradient,
};
use nalgebra::SVector;
use std::f64::consts::{FRAC_PI_2, PI};

fn projected() -> Settings {
    Settings { drift_bound: 0.0, ..Settings::default() }
}

/// A function of the place and speed of a body and of the torque.
struct Place;
impl Cost<3, 0, 1> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.q[1] * at.q[1] + at.q[2].cos() * 0.3 + at.v[2] * at.v[2] * 0.1 + at.u[0] * at.u[0] * 0.05
    }
}

/// IFToMM's benchmark: N parallelograms of rods of 1 m and 1 kg side by side, the cranks at this angle and with this angular velocity.
fn four_bars(count: usize, gravity: f64, angle: f64, rate: f64) -> (System, Vec<f64>) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -gravity);
    let (sin, cos) = angle.sin_cos();
    let at = |i: usize| i as f64;
    let mut rod = |name: String, place| scene.body(&name, 1.0, 1.0 / 12.0, place);
    let cranks: Vec<_> = (0..=count).map(|i| rod(format!("crank {i}"), [at(i) + 0.5 * cos, 0.5 * sin, angle])).collect();
    let couplers: Vec<_> = (0..count).map(|i| rod(format!("coupler {i}"), [at(i) + 0.5 + cos, sin, 0.0])).collect();
    for (i, crank) in cranks.iter().enumerate() {
        scene.revolute(&format!("foot {i}"), Body::GROUND.at(at(i), 0.0), crank.at(-0.5, 0.0));
    }
    for (i, coupler) in couplers.iter().enumerate() {
        scene.revolute(&format!("left {i}"), cranks[i].at(0.5, 0.0), coupler.at(-0.5, 0.0));
        scene.revolute(&format!("right {i}"), cranks[i + 1].at(0.5, 0.0), coupler.at(0.5, 0.0));
    }
    let torque = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, cranks[0], torque);
    for (i, body) in cranks.iter().chain(&couplers).enumerate() {
        scene.cost(&format!("place {i}"), Place, Sum::Trapezoidal, body.coordinates, [], [torque], []);
    }
    let of_cranks = (0..=count).flat_map(|_| [-0.5 * sin * rate, 0.5 * cos * rate, rate]);
    let of_couplers = (0..count).flat_map(|_| [-sin * rate, cos * rate, 0.0]);
    let v = of_cranks.chain(of_couplers).collect();
    (scene.compile().expect("scene"), v)
}

fn start((system, v): &(System, Vec<f64>), steps: usize, dt: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, dt));
    inputs.start.rate_mut().copy_from_slice(v);
    inputs
}

#[test]
fn parallelograms_are_projected_through_flat_configurations_at_every_step_length() {
    // Until they have been flat twice or more.
    for (count, dt, steps) in
        [(1, 2e-4, 10_000), (1, 5e-3, 2000), (2, 5e-4, 4000), (4, 1e-3, 2000), (40, 1e-3, 1600), (40, 5e-3, 400)]
    {
        let mechanism = four_bars(count, 9.81, FRAC_PI_2, -1.0);
        let inputs = start(&mechanism, steps, dt);
        let mut solver = Solver::new(&mechanism.0, projected());
        let motion = solver.simulate(&inputs).unwrap_or_else(|error| panic!("{count} at {dt} s: {error}"));
        let phi = largest(motion.phi(&mechanism.0, &inputs).expect("motion").as_slice());
        let couplers = (count + 1..2 * count + 1).map(|body| largest(motion.q.row(3 * body + 2).clone_owned().as_slice()));
        let tilt = couplers.fold(0.0, f64::max);
        let half_turns: Vec<f64> = motion.q.row(2).iter().map(|angle| (angle / PI).floor()).collect();
        let flat = half_turns.windows(2).filter(|pair| pair[0] != pair[1]).count();
        println!("{count} at {dt} s: flat {} times, Φ up to {phi:.1e}, couplers tilted by up to {tilt:.1e}", flat);
        assert!(flat >= 2 && motion.restarted.len() == steps);
        // What rounding leaves, and what it makes of the branch at θ of some 1e-4 or more.
        assert!(phi <= 4e-14 && tilt <= 1e-9, "{count} at {dt} s: Φ {phi:.1e}, tilt {tilt:.1e}");
    }
}

#[test]
fn the_gradient_through_flat_configurations_is_that_of_complex_step() {
    for (count, settings) in [(1, projected()), (2, Settings { rebase_every: 3, ..projected() }), (4, projected())] {
        let mechanism = four_bars(count, 9.81, 0.2, -2.0);
        let mut inputs = start(&mechanism, 120, 2e-3);
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (0.1 * i as f64).sin());
        let system = &mechanism.0;
        let adjoint = gradient(system, &inputs, settings).expect("gradient");
        // Coordinates and velocities at the start may not leave the constraints.
        let all: Vec<Input> = Input::all(&inputs)
            .into_iter()
            .filter(|input| matches!(input, Input::Control { .. } | Input::Step(_)))
            .collect();
        let ours: Vec<f64> = all.iter().map(|input| input.in_gradient(&adjoint)).collect();
        let reference = complex_step(system, &inputs, settings, &all).expect("complex step");
        let motion = hamiltonian_adjoint::simulate(system, &inputs, settings).expect("motion");
        let nearest = motion.q.row(2).iter().fold(f64::INFINITY, |nearest, angle| nearest.min(angle.abs()));
        println!("{count}: nearest to flat {nearest:.1e}");
        assert!(nearest < 3e-3);
        // Reactions, and with them rounding, are as large as 1/θ there.
        assert_same_derivatives_to(5e-14 / nearest, &format!("{count} parallelograms"), &all, &ours, &reference);
    }
}

#[test]
fn where_nothing_can_be_started_restarts_are_passed_over() {
    // Without gravity the cranks turn at 1 rad/s, and lie flat at node 1000 to the last digit.
    let mechanism = four_bars(2, 0.0, FRAC_PI_2, 1.0);
    let inputs = start(&mechanism, 1500, FRAC_PI_2 / 1000.0);
    let settings = Settings { rebase_every: 1, ..Settings::default() };
    let mut solver = Solver::new(&mechanism.0, settings);
    let restarted = solver.simulate(&inputs).expect("motion").restarted.clone();
    assert!(restarted.iter().copied().eq((1..=1500).filter(|&node| node != 1000)), "{}", restarted.len());
}

/// ½ Σ v²: of the angles of a chain of rods relative to each other.
struct Turning;
impl KineticEnergy<3> for Turning {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 3>, v: &SVector<S, 3>, _b: &SVector<S, 0>) -> S {
        (v[0] * v[0] * 2.0 + v[1] * v[1] + v[2] * v[2]) * 0.5
    }
}

/// Three rods of 1 m, one at the end of the other, lead from one foot to another 1 m away.
struct Closed;
impl Constraint<3, 2> for Closed {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 2> {
        let angles = [q[0], q[0] + q[1], q[0] + q[1] + q[2]];
        let [mut x, mut y] = [S::from(-1.0), S::zero()];
        for angle in angles {
            x += angle.cos();
            y += angle.sin();
        }
        SVector::from([x, y])
    }
}

#[test]
fn a_formula_whose_terms_are_not_known_is_restarted_around_flat_configurations() {
    // Flat to the last digit at t = 0.3 s, but for the last.
    for (dt, passed_over) in [(1e-4, 1), (3e-4, 1), (1e-3, 1), (4e-3, 1), (1.1e-3, 0)] {
        let mut scene = Scene::new();
        let angle = 0.3;
        let q = scene.coordinates("parallelogram", ["a", "b", "c"]);
        [angle, -angle, angle - PI].into_iter().zip(q).for_each(|(place, q)| scene.place(q, place));
        scene.kinetic_energy("T", Turning, q, []);
        scene.constraint("closed", Closed, q, []);
        let system = scene.compile().expect("scene");
        let steps = (4.0 / dt) as usize;
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
        inputs.start.rate_mut().copy_from_slice(&[-1.0, 1.0, -1.0]);
        for settings in [projected(), Settings { rebase_every: 1, ..Settings::default() }] {
            let mut solver = Solver::new(&system, settings);
            let motion = solver.simulate(&inputs).unwrap_or_else(|error| panic!("{dt}: {error}"));
            let phi = largest(motion.phi(&system, &inputs).expect("motion").as_slice());
            let error = motion.q[(0, steps)] - (angle - steps as f64 * dt);
            println!("{dt} s: Φ up to {phi:.1e}, angle at the end off by {error:.1e}");
            assert_eq!(motion.restarted.len(), steps - passed_over);
            // Eight times the rounding of angles and lengths that add up to 10; without projections, Δt².
            assert!(settings.drift_bound > 0.0 || phi <= 2e-14, "{dt}: {phi:.1e}");
            assert!(error.abs() <= 1e-8, "{dt}: {error:.1e}");
        }
    }
}
