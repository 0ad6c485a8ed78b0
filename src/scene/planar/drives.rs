//! Prescribed distances and positions, actuators between two points, and forces and torques as functions of time.

use nalgebra::SVector;

use super::body::Body;
use super::geometry::{Link, rotated, turned};
use super::ground::Ends;
use super::joints::{axis, padded, points, points_and};
use super::motion::{Motion, with_motion};
use crate::model::element::ForcePoint;
use crate::model::{Frame, Owner, Point, Shape};
use crate::scene::ready::{Kind, Part};
use crate::{Constraint, Control, Error, Force, Multiplier, Param, Scalar, Scene};

/// Largest number of parameters of a prescribed function f(t) in elements that are attached at points.
pub const MOST_PARAMETERS: usize = 8;

/// The parameters of a prescribed function, which follow the other parameters of an element.
fn behind<S: Scalar, const P: usize>(b: &[S]) -> SVector<S, P> {
    const { assert!(P <= MOST_PARAMETERS, "a function at points has at most MOST_PARAMETERS parameters") };
    SVector::from_fn(|i, _| b[i])
}

/// A prescribed distance f(t): Φ = (|d|²/f(t) − f(t))/2, to first order the deviation of the distance; b = [s_a, s_b, parameters of f,
/// zeros].
#[derive(Clone, Copy, Debug)]
pub struct DrivenDistance<F, const P: usize>(pub F);

impl<F: Motion<P>, const P: usize> Constraint<6, 1, 12> for DrivenDistance<F, P> {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 12>, t: S) -> SVector<S, 1> {
        let (d, length) = (Link::new(q, b.as_slice()).between, self.0.value(t, &behind(&b.as_slice()[4..])));
        SVector::from([(d.dot(&d) / length - length) * 0.5])
    }
}

/// A prescribed position along an axis of a: Φ = e · d − f(t); b = [s_a, s_b, axis angle, parameters of f, zeros].
#[derive(Clone, Copy, Debug)]
pub struct DrivenSlider<F, const P: usize>(pub F);

impl<F: Motion<P>, const P: usize> Constraint<6, 1, 13> for DrivenSlider<F, P> {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 13>, t: S) -> SVector<S, 1> {
        let along = axis(q, b[4]).dot(&Link::new(q, b.as_slice()).between);
        SVector::from([along - self.0.value(t, &behind(&b.as_slice()[5..]))])
    }
}

/// The force u along the line between two points, positive if it pushes them apart; b = [s_a, s_b].
#[derive(Clone, Copy, Debug)]
pub struct TwoPointActuator;

impl Force<6, 1, 4> for TwoPointActuator {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 1>, b: &SVector<S, 4>) -> SVector<S, 6> {
        let link = Link::new(&at.q, b.as_slice());
        link.along(&link.direction()) * at.u[0]
    }
}

/// The force f(t) at a point of a body, in a direction of the inertial frame; b = [s, direction angle, parameters of f, zeros].
#[derive(Clone, Copy, Debug)]
pub struct AppliedForce<F, const P: usize>(pub F);

impl<F: Motion<P>, const P: usize> Force<3, 0, 11> for AppliedForce<F, P> {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 0>, b: &SVector<S, 11>) -> SVector<S, 3> {
        let direction = rotated(b[2], [S::one(), S::zero()]);
        let turn = direction.dot(&turned(&rotated(at.q[2], [b[0], b[1]])));
        SVector::from([direction[0], direction[1], turn]) * self.0.value(at.t, &behind(&b.as_slice()[3..]))
    }
}

impl<F: Motion<P>, const P: usize> Force<2, 0, 11> for AppliedForce<F, P> {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 11>) -> SVector<S, 2> {
        rotated(b[2], [S::one(), S::zero()]) * self.0.value(at.t, &behind(&b.as_slice()[3..]))
    }
}

/// The torque f(t) on a body; b = parameters of f.
#[derive(Clone, Copy, Debug)]
pub struct AppliedTorque<F>(pub F);

impl<F: Motion<P>, const P: usize> Force<1, 0, P> for AppliedTorque<F> {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, P>) -> SVector<S, 1> {
        SVector::from([self.0.value(at.t, b)])
    }
}

pub(super) static DRIVEN_DISTANCE: Kind = Kind::of_points("driven distance", &[], |scene, name, part| {
    let [a, b] = part.both();
    with_motion!(part, motion, parameters, scene.driven_distance(name, a, b, motion, parameters));
})
.moving();

pub(super) static DRIVEN_SLIDER: Kind = Kind::of_points("driven slider", &["axis"], |scene, name, part| {
    let ([a, b], axis) = (part.both(), part.number(0));
    with_motion!(part, motion, parameters, scene.driven_slider(name, (a, axis), b, motion, parameters));
})
.moving();

pub(super) static TWO_POINT_ACTUATOR: Kind = Kind::of_points("two-point actuator", &[], |scene, name, part| {
    let ([a, b], [control]) = (part.both(), part.by());
    scene.draw(name, Shape::Cylinder { control: Some(control) }, a, b);
    scene.between_force(name, TwoPointActuator, (part.frames(), Ends::Points), [control], points(a, b, []));
})
.driven_by("force");

pub(super) static APPLIED_FORCE: Kind = Kind::of_points("applied force", &["direction"], |scene, name, part| {
    let (at, direction) = (part.points[0], part.number(0));
    with_motion!(part, motion, parameters, scene.applied_force(name, at, direction, motion, parameters));
})
.at(&["at"])
.moving();

pub(super) static APPLIED_TORQUE: Kind =
    Kind::of_frames("applied torque", &[], |scene, name, part| match part.points[0].frame.0 {
        Owner::Body(coordinates) => {
            let body = Body { coordinates };
            with_motion!(part, motion, parameters, scene.applied_torque(name, body, motion, parameters));
        }
        _ => scene.report(Error::NoBody { element: name.to_string() }),
    })
    .at(&["body"])
    .moving();

impl Scene {
    /// Adds a prescribed distance f(t; parameters) > 0, m, between two points, for example a driven cylinder.
    pub fn driven_distance<F, const P: usize>(
        &mut self,
        name: &str,
        a: Point,
        b: Point,
        motion: F,
        parameters: [Param; P],
    ) -> [Multiplier; 1]
    where
        F: Motion<P>,
    {
        self.multipliers_of(|scene| {
            let part = Part { points: vec![a, b], ..Part::of(&DRIVEN_DISTANCE) };
            scene.driven(name, part, motion, parameters, |scene, motion| {
                scene.draw(name, Shape::Cylinder { control: None }, a, b);
                scene.joint(
                    name,
                    DrivenDistance(motion),
                    ((a.frame, b.frame), Ends::Points),
                    points_and(a, b, [], parameters),
                );
            });
        })
    }

    /// Adds a prescribed position f(t; parameters), m, of `b` along the axis of `a` (rad, in a's frame).
    pub fn driven_slider<F, const P: usize>(
        &mut self,
        name: &str,
        (a, axis): (Point, impl Into<Param>),
        b: Point,
        motion: F,
        parameters: [Param; P],
    ) -> [Multiplier; 1]
    where
        F: Motion<P>,
    {
        let axis = axis.into();
        self.multipliers_of(|scene| {
            let part = Part { points: vec![a, b], numbers: vec![axis], ..Part::of(&DRIVEN_SLIDER) };
            scene.driven(name, part, motion, parameters, |scene, motion| {
                scene.draw(name, Shape::Slider { axis }, a, b);
                scene.joint(
                    name,
                    DrivenSlider(motion),
                    ((a.frame, b.frame), Ends::Points),
                    points_and(a, b, [axis], parameters),
                );
            });
        })
    }

    /// Adds a force (N) along the line between two points, driven by a control and positive if it pushes them apart, for example a
    /// hydraulic cylinder.
    ///
    /// The points must not coincide, because the direction of the force would be undefined.
    pub fn two_point_actuator(&mut self, name: &str, a: Point, b: Point, force: Control) {
        self.ready_driven(name, &TWO_POINT_ACTUATOR, [a, b], &[], force);
    }

    /// Adds a force f(t; parameters), N, at a point of a body, in a direction (rad) of the inertial frame; use
    /// [`Constant`](super::Constant) for a constant force.
    pub fn applied_force<F, const P: usize>(
        &mut self,
        name: &str,
        at: Point,
        direction: impl Into<Param>,
        motion: F,
        parameters: [Param; P],
    ) where
        F: Motion<P>,
    {
        let direction = direction.into();
        let part = Part { points: vec![at], numbers: vec![direction], ..Part::of(&APPLIED_FORCE) };
        self.driven(name, part, motion, parameters, |scene, motion| {
            let b = padded([at.at[0], at.at[1], direction].into_iter().chain(parameters));
            match at.frame.0 {
                Owner::Body(q) => scene.force(name, AppliedForce(motion), q, [], b),
                Owner::Particle(q) => scene.force(name, AppliedForce(motion), q, [], b),
                Owner::Ground => scene.report(Error::NoBody { element: name.to_string() }),
            }
        });
    }

    /// Adds a torque f(t; parameters), N m, on a body.
    pub fn applied_torque<F, const P: usize>(&mut self, name: &str, body: Body, motion: F, parameters: [Param; P])
    where
        F: Motion<P>,
    {
        let part = Part { points: vec![Frame::from(body).origin()], ..Part::of(&APPLIED_TORQUE) };
        self.driven(name, part, motion, parameters, |scene, motion| {
            scene.force(name, AppliedTorque(motion), [body.coordinates[2]], [], parameters);
        });
    }
}
