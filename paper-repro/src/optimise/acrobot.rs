//! An acrobot: two links with a motor between them, which swings them from hanging to rest upright with the least effort.

use std::f64::consts::FRAC_PI_2;

use hamiltonian_adjoint::optimize::{Free, Interval};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Error as MotionError, Grid, Inputs, Scene, Settings};

use super::problems::Posed;

/// The length of a link, m, and its mass, kg.
const LENGTH: f64 = 1.0;
const MASS: f64 = 1.0;
/// The largest torque, N m.
const TORQUE: f64 = 20.0;
/// s.
const DURATION: f64 = 3.0;
const STEPS: usize = 100;

/// The problem.
pub fn pose() -> Result<Posed, MotionError> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let inertia = MASS * LENGTH * LENGTH / 12.0;
    let mut link = |name: &str, y: f64| scene.body(name, MASS, inertia, [0.0, y, -FRAC_PI_2]);
    let (upper, lower) = (link("upper link", -0.5 * LENGTH), link("lower link", -1.5 * LENGTH));
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-0.5 * LENGTH, 0.0));
    scene.revolute("elbow", upper.at(0.5 * LENGTH, 0.0), lower.at(-0.5 * LENGTH, 0.0));
    let control = scene.control("torque");
    scene.torque_actuator("motor", upper, lower, control);
    scene.effort("effort", control, 1.0);
    let ends = [upper, lower].map(|link| scene.end_state(link.coordinates[2]));
    let of_end = ends.iter().flat_map(|end| [(end.position, Interval::equal(FRAC_PI_2)), (end.rate, Interval::ZERO)]);
    let constraints = of_end.collect();
    let system = scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, DURATION / STEPS as f64));
    let free = vec![Free::control(control).within(-TORQUE, TORQUE)];
    Ok(Posed { system, settings: Settings::default(), inputs, control, free, constraints, lines: &[] })
}
