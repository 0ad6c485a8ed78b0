//! Joints against formulas found by hand: a driven crank, and the reaction in the hinge of a pendulum.

use crate::common::{assert_order, largest_difference};
use hamiltonian_adjoint::planar::{Body, ConstantSpeed, Harmonic, Motion};
use hamiltonian_adjoint::{Grid, Inputs, Param, Scene, Settings, Start, System, Trajectory, simulate};
use nalgebra::{DVector, SVector};

const MASS: f64 = 1.3;
const INERTIA: f64 = 0.07;
/// From the hinge at the origin to the centre of mass.
const ARM: f64 = 0.45;
/// About the hinge.
const TOTAL_INERTIA: f64 = INERTIA + MASS * ARM * ARM;

/// A rod on a hinge; with a motion, a motor turns it.
fn rod<F: Motion<P>, const P: usize>(angle: f64, gravity: f64, motor: Option<(F, [f64; P])>) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -gravity);
    let (sin, cos) = angle.sin_cos();
    let rod = scene.body("rod", MASS, INERTIA, [ARM * cos, ARM * sin, angle]);
    scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(-ARM, 0.0));
    if let Some((motion, parameters)) = motor {
        scene.driven_angle("motor", Body::GROUND, rod, motion, parameters.map(Param::from));
    }
    scene.compile().expect("scene")
}

/// The motion from t = 0 to 2 s of a rod that turns at this speed at first.
fn turned(system: &System, speed: f64, steps: usize) -> Trajectory {
    let q = system.initial_coordinates();
    let v = DVector::from_column_slice(&[-q[1] * speed, q[0] * speed, speed]);
    let grid = Grid::uniform(steps, 2.0 / steps as f64);
    let inputs = Inputs { start: Start::Velocity { q, v }, ..Inputs::at_rest(system, grid) };
    simulate(system, &inputs, Settings::default()).expect("motion")
}

/// Row `i` of a matrix of nodes.
fn row(matrix: &nalgebra::DMatrix<f64>, i: usize) -> Vec<f64> {
    matrix.row(i).iter().copied().collect()
}

#[test]
fn a_crank_driven_at_constant_speed_turns_exactly_and_its_multiplier_is_the_impulse_of_the_motor() {
    let (start, speed, gravity) = (0.3, 4.0, 9.81);
    let system = rod(start, gravity, Some((ConstantSpeed, [start, speed])));
    let errors = [100, 200, 400, 800].map(|steps| {
        let motion = turned(&system, speed, steps);
        let angle: Vec<f64> = motion.times.iter().map(|t| start + speed * t).collect();
        assert!(largest_difference(&row(&motion.q, 2), &angle) < 1e-12, "a linear motion is exact for the rule");
        // The motor carries the weight: τ = m g a cos φ, λ = −τ.
        let impulse = |phi: &f64| -MASS * gravity * ARM * (phi.sin() - start.sin()) / speed;
        largest_difference(&row(&motion.sigma, 2), &angle.iter().map(impulse).collect::<Vec<_>>())
    });
    assert_order("impulse of the motor", &errors, 2.0, 0.05);
}

#[test]
fn a_crank_driven_harmonically_has_the_exact_speed_and_its_motor_gives_the_angular_momentum() {
    let parameters = [0.3, 0.5, 3.0, 0.2];
    let b = SVector::from(parameters);
    let [_, amplitude, omega, phase] = parameters;
    let speed = |t: f64| amplitude * omega * (omega * t + phase).cos();
    let system = rod(Harmonic.value(0.0, &b), 0.0, Some((Harmonic, parameters)));
    let errors = [100, 200, 400, 800].map(|steps| {
        let motion = turned(&system, speed(0.0), steps);
        let at_nodes = |f: &dyn Fn(f64) -> f64| motion.times.iter().map(|&t| f(t)).collect::<Vec<_>>();
        let speed_error = largest_difference(&row(&motion.v, 2), &at_nodes(&speed));
        assert!(speed_error < 1e-13, "dΦ/dt = 0 holds at every node: {speed_error:.1e}");
        let angle = largest_difference(&row(&motion.q, 2), &at_nodes(&|t| Harmonic.value(t, &b)));
        let impulse = at_nodes(&|t| -TOTAL_INERTIA * (speed(t) - speed(0.0)));
        (angle, largest_difference(&row(&motion.sigma, 2), &impulse))
    });
    assert_order("driven angle", &errors.map(|e| e.0), 2.0, 0.05);
    assert_order("impulse of the motor", &errors.map(|e| e.1), 2.0, 0.05);
}

#[test]
fn the_reaction_in_the_hinge_of_a_pendulum_is_mass_times_acceleration_plus_weight() {
    let gravity = 9.81;
    let system = rod(0.0, gravity, None::<(ConstantSpeed, [f64; 2])>);
    let errors = [100, 200, 400, 800].map(|steps| {
        let motion = turned(&system, 0.0, steps);
        let dt = 2.0 / steps as f64;
        let error = |i: usize| {
            let (phi, speed) = (motion.q[(2, i)], motion.v[(2, i)]);
            let (sin, cos) = phi.sin_cos();
            let turning = -MASS * gravity * ARM * cos / TOTAL_INERTIA;
            let x = MASS * ARM * (-turning * sin - speed * speed * cos);
            let y = MASS * ARM * (turning * cos - speed * speed * sin) + MASS * gravity;
            // The force on the rod is −λ, and λ is the rate of σ.
            let force = |j: usize| -(motion.sigma[(j, i + 1)] - motion.sigma[(j, i - 1)]) / (2.0 * dt);
            largest_difference(&[force(0), force(1)], &[x, y])
        };
        (1..steps).map(error).fold(0.0, f64::max)
    });
    assert_order("reaction", &errors, 2.0, 0.05);
}

#[test]
fn a_place_of_the_plane_is_found_in_every_frame_as_it_is_at_the_start() {
    let mut scene = Scene::new();
    let upright = scene.body("upright", MASS, INERTIA, [1.0, 2.0, std::f64::consts::FRAC_PI_2]);
    let tilted = scene.body("tilted", MASS, INERTIA, [0.3, -0.4, 1.1]);
    let [along, across] = scene.local(upright, [1.5, 3.0]);
    assert!((along - 1.0).abs() < 1e-15 && (across + 0.5).abs() < 1e-15);
    assert_eq!(scene.local(Body::GROUND, [1.5, 3.0]), [1.5, 3.0]);
    assert!(Scene::new().local(upright, [1.5, 3.0])[0].is_nan(), "a body of another scene");
    // A hinge between points of several frames that are at one place is closed.
    let pins = [scene.at_world(Body::GROUND, 0.7, 0.2), scene.at_world(upright, 0.7, 0.2), scene.at_world(tilted, 0.7, 0.2)];
    scene.revolute("first", pins[0], pins[1]);
    scene.revolute("second", pins[1], pins[2]);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(0, 1.0));
    let motion = simulate(&system, &inputs, Settings::default()).expect("start");
    assert!(motion.phi(&system, &inputs).expect("sizes").amax() < 1e-15);
}
