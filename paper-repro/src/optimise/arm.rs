//! Arms with a motor in each joint, which hang at the start and come to rest in a pose with the least effort.

use std::f64::consts::FRAC_PI_2;

use hamiltonian_adjoint::optimize::{Free, Interval};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Cost, CostPoint, EndState, Error as MotionError, Grid, Inputs, Output, Scalar, Scene, Settings};
use nalgebra::SVector;

use super::problems::Posed;

/// An arm, and the motion that is asked of it.
struct Arm<'a> {
    /// Lengths in m and masses in kg.
    links: &'a [(f64, f64)],
    /// N m s/rad, in all joints.
    friction: f64,
    /// Absolute angles at the end, rad.
    end: &'a [f64],
    /// s.
    duration: f64,
}

const THREE: Arm<'_> =
    Arm { links: &[(0.5, 2.0), (0.5, 1.5), (0.4, 1.0)], friction: 0.0, end: &[FRAC_PI_2; 3], duration: 1.5 };
/// The number of links of the chain, and the length and the mass of each.
const COUNT: usize = 10;
const LINK: (f64, f64) = (0.2, 0.4);
/// The largest angle between the last two links, rad, and the largest distance of the tip from the first joint to the right, m.
const ELBOW: f64 = 0.4;
const REACH: f64 = 0.9;

/// The angle between two links.
#[derive(Clone)]
struct Between;

impl Cost<2> for Between {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[1] - at.q[0]
    }
}

/// The place of the tip.
#[derive(Clone)]
struct Tip;

impl Cost<3> for Tip {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, _b: &SVector<S, 0>) -> S {
        (0..3).fold(S::zero(), |x, k| x + at.q[k].cos() * THREE.links[k].0)
    }
}

/// Three links, which come to rest upright, in 100 steps, or in 200 steps with limits at all nodes.
pub fn three(is_limited: bool) -> Result<Posed, MotionError> {
    pose(&THREE, if is_limited { 200 } else { 100 }, is_limited)
}

/// Ten links with friction in the joints, which come to rest in a quarter of a circle, with the last link horizontal.
pub fn chain(steps: usize) -> Result<Posed, MotionError> {
    let angles = std::array::from_fn::<_, COUNT, _>(|k| FRAC_PI_2 * ((k + 1) as f64 / COUNT as f64 - 1.0));
    pose(&Arm { links: &[LINK; COUNT], friction: 0.5, end: &angles, duration: 2.0 }, steps, false)
}

fn pose(of: &Arm<'_>, steps: usize, is_limited: bool) -> Result<Posed, MotionError> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let (mut y, mut before, mut parent) = (0.0, Body::GROUND.at(0.0, 0.0), Body::GROUND);
    let (mut angles, mut controls) = (Vec::new(), Vec::new());
    for (k, (length, mass)) in of.links.iter().copied().enumerate() {
        let place = [0.0, y - 0.5 * length, -FRAC_PI_2];
        let body = scene.body(&format!("link {k}"), mass, mass * length * length / 12.0, place);
        scene.revolute(&format!("joint {k}"), before, body.at(-0.5 * length, 0.0));
        let torque = scene.control(&format!("torque {k}"));
        scene.torque_actuator(&format!("motor {k}"), parent, body, torque);
        if of.friction > 0.0 {
            scene.joint_friction(&format!("friction {k}"), parent, body, of.friction);
        }
        scene.effort(&format!("effort {k}"), torque, 1e-2);
        controls.push(torque);
        angles.push(body.coordinates[2]);
        (y, before, parent) = (y - length, body.at(0.5 * length, 0.0), body.into());
    }
    let ends = angles.iter().map(|angle| scene.end_state(*angle)).collect::<Vec<_>>();
    let of_end = |(end, angle): (&EndState, &f64)| [(end.position, Interval::equal(*angle)), (end.rate, Interval::ZERO)];
    let mut constraints: Vec<(Output, Interval)> = ends.iter().zip(of.end).flat_map(of_end).collect();
    if is_limited {
        let ([first, second, third], nodes) = ([angles[0], angles[1], angles[2]], 0..=steps);
        let elbow = scene.outputs_at("elbow", Between, nodes.clone(), [second, third], [], [], []);
        let tip = scene.outputs_at("tip", Tip, nodes, [first, second, third], [], [], []);
        constraints.extend(elbow.into_iter().map(|elbow| (elbow, Interval::new(-ELBOW, ELBOW))));
        constraints.extend(tip.into_iter().map(|tip| (tip, Interval::at_most(REACH))));
    }
    let system = scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(steps, of.duration / steps as f64));
    let (control, free) = (controls[0], controls.into_iter().map(Free::control).collect());
    Ok(Posed { system, settings: Settings::default(), inputs, control, free, constraints, lines: &[] })
}
