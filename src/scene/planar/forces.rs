//! Springs, dampers, friction and actuators between two bodies a and b.
//!
//! A force F along a length s(q) acts as Q = F s_q on both bodies: action and reaction in one formula.

use nalgebra::SVector;

use super::geometry::{Link, turned};
use super::ground::Ends;
use super::joints::{axis, points};
use crate::model::element::ForcePoint;
use crate::model::{Frame, Point, Shape};
use crate::scene::ready::Kind;
use crate::system::{Applied, Fixed, Potential};
use crate::{Control, Force, Param, PotentialEnergy, Scalar, Scene};

/// A linear spring between two points: V = ½ c (|d| − l₀)²; b = [s_a, s_b, c, l₀].
#[derive(Clone, Copy, Debug)]
pub struct LinearSpring;

impl PotentialEnergy<6, 6> for LinearSpring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 6>, _t: S) -> S {
        let between = Link::new(q, b.as_slice()).between;
        let stretch = between.dot(&between).sqrt() - b[5];
        b[4] * stretch * stretch * 0.5
    }
}

/// A linear spring of zero free length: V = ½ c dᵀd, smooth also if the points coincide; b = [s_a, s_b, c].
#[derive(Clone, Copy, Debug)]
pub struct ZeroLengthSpring;

impl PotentialEnergy<6, 5> for ZeroLengthSpring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 5>, _t: S) -> S {
        let between = Link::new(q, b.as_slice()).between;
        b[4] * between.dot(&between) * 0.5
    }
}

/// A viscous damper between two points: F = −η d|d|/dt along the line between them, with the vector d from one point to the other and the
/// damping constant η; `b` = [s_a, s_b, η].
#[derive(Clone, Copy, Debug)]
pub struct Damper;

impl Force<6, 0, 5> for Damper {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 5>) -> SVector<S, 6> {
        let link = Link::new(&at.q, b.as_slice());
        let direction = link.direction();
        let speed = direction.dot(&link.velocity(&at.v));
        link.along(&direction) * -(b[4] * speed)
    }
}

/// A torsional spring: V = ½ c (φ_b − φ_a − φ₀)²; b = [c, φ₀].
#[derive(Clone, Copy, Debug)]
pub struct TorsionalSpring;

impl PotentialEnergy<6, 2> for TorsionalSpring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 2>, _t: S) -> S {
        let twist = q[5] - q[2] - b[1];
        b[0] * twist * twist * 0.5
    }
}

/// Viscous friction in a hinge: the torque −d (φ̇_b − φ̇_a) on body b and its reaction on body a, with the parameter `b = [d]`.
#[derive(Clone, Copy, Debug)]
pub struct JointFriction;

impl Force<6, 0, 1> for JointFriction {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 1>) -> SVector<S, 6> {
        torque(b[0] * (at.v[2] - at.v[5]))
    }
}

/// Viscous friction along an axis of a: the force −d ds/dt, with the coordinate s of body b's point along the axis and the parameters `b` =
/// [s_a, s_b, axis angle, d].
#[derive(Clone, Copy, Debug)]
pub struct SlidingFriction;

impl Force<6, 0, 6> for SlidingFriction {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 6>) -> SVector<S, 6> {
        let (link, axis) = (Link::new(&at.q, b.as_slice()), axis(&at.q, b[4]));
        let speed = axis.dot(&link.velocity(&at.v)) + turned(&axis).dot(&link.between) * at.v[2];
        link.along_axis(&axis) * -(b[5] * speed)
    }
}

/// The force u along an axis of body a on the point of body b, and its reaction on a; the parameters are `b` = [s_a, s_b, axis angle].
#[derive(Clone, Copy, Debug)]
pub struct Actuator;

impl Force<6, 1, 5> for Actuator {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 1>, b: &SVector<S, 5>) -> SVector<S, 6> {
        Link::new(&at.q, b.as_slice()).along_axis(&axis(&at.q, b[4])) * at.u[0]
    }
}

/// The torque u on b and its reaction on a.
#[derive(Clone, Copy, Debug)]
pub struct TorqueActuator;

impl Force<6, 1, 0> for TorqueActuator {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 1>, _b: &SVector<S, 0>) -> SVector<S, 6> {
        torque(at.u[0])
    }
}

/// A torque on b and its reaction on a.
pub(super) fn torque<S: Scalar>(torque: S) -> SVector<S, 6> {
    let zero = S::zero();
    SVector::from([zero, zero, -torque, zero, zero, torque])
}

pub(super) static SPRING_DAMPER: Kind =
    Kind::of_points("spring and damper", &["stiffness", "free_length", "damping"], |scene, name, part| {
        let ([a, b], [stiffness, free_length, damping]) = (part.both(), [0, 1, 2].map(|i| part.number(i)));
        scene.draw(name, Shape::Spring, a, b);
        let (spring, ends) = (format!("{name} (spring)"), (part.frames(), Ends::Points));
        match (stiffness.constant(), free_length.constant()) {
            (Some(0.0), _) => {}
            (_, Some(0.0)) => scene.between_potential(&spring, ZeroLengthSpring, ends, points(a, b, [stiffness])),
            _ => scene.between_potential(&spring, LinearSpring, ends, points(a, b, [stiffness, free_length])),
        }
        if damping.constant() != Some(0.0) {
            scene.between_force(&format!("{name} (damper)"), Damper, ends, [], points(a, b, [damping]));
        }
    });

pub(super) static TORSIONAL_SPRING_DAMPER: Kind =
    Kind::of_frames("torsional spring and damper", &["stiffness", "free_angle", "damping"], |scene, name, part| {
        let [stiffness, free_angle, damping] = [0, 1, 2].map(|i| part.number(i));
        if stiffness.constant() != Some(0.0) {
            let spring = [stiffness, free_angle];
            scene.between_potential(&format!("{name} (spring)"), TorsionalSpring, (part.frames(), Ends::Bodies), spring);
        }
        if damping.constant() != Some(0.0) {
            scene.between_force(&format!("{name} (damper)"), JointFriction, (part.frames(), Ends::Bodies), [], [damping]);
        }
    });

pub(super) static JOINT_FRICTION: Kind = Kind::of_frames("joint friction", &["damping"], |scene, name, part| {
    scene.between_force(name, JointFriction, (part.frames(), Ends::Bodies), [], [part.number(0)]);
});

pub(super) static SLIDING_FRICTION: Kind = Kind::of_points("sliding friction", &["axis", "damping"], |scene, name, part| {
    let [a, b] = part.both();
    scene.between_force(
        name,
        SlidingFriction,
        (part.frames(), Ends::Points),
        [],
        points(a, b, [part.number(0), part.number(1)]),
    );
});

pub(super) static ACTUATOR: Kind = Kind::of_points("actuator", &["axis"], |scene, name, part| {
    let ([a, b], axis, [control]) = (part.both(), part.number(0), part.by());
    scene.draw(name, Shape::Force { axis, control }, a, b);
    scene.between_force(name, Actuator, (part.frames(), Ends::Points), [control], points(a, b, [axis]));
})
.driven_by("force");

pub(super) static TORQUE_ACTUATOR: Kind = Kind::of_frames("torque actuator", &[], |scene, name, part| {
    let ([a, b], [control]) = (part.both(), part.by());
    scene.draw(name, Shape::Torque { control }, a, b);
    scene.between_force(name, TorqueActuator, (part.frames(), Ends::Bodies), [control], []);
})
.driven_by("torque");

impl Scene {
    /// Adds a spring and a damper between two points: stiffness (N/m), free length (m), damping (N s/m).
    ///
    /// The points must not coincide, because the direction of the force would be undefined. They may coincide if the free length and the
    /// damping are the constant 0.
    pub fn spring_damper(
        &mut self,
        name: &str,
        a: Point,
        b: Point,
        stiffness: impl Into<Param>,
        free_length: impl Into<Param>,
        damping: impl Into<Param>,
    ) {
        self.ready_between(name, &SPRING_DAMPER, [a, b], [stiffness.into(), free_length.into(), damping.into()]);
    }

    /// Adds a torsional spring and damper: stiffness (N m/rad), free angle φ_b − φ_a (rad), damping (N m s/rad).
    pub fn torsional_spring_damper(
        &mut self,
        name: &str,
        a: impl Into<Frame>,
        b: impl Into<Frame>,
        stiffness: impl Into<Param>,
        free_angle: impl Into<Param>,
        damping: impl Into<Param>,
    ) {
        let (frames, numbers) = ([a.into(), b.into()], [stiffness.into(), free_angle.into(), damping.into()]);
        self.ready_between(name, &TORSIONAL_SPRING_DAMPER, frames.map(Frame::origin), numbers);
    }

    /// Adds viscous friction against relative rotation (N m s/rad).
    pub fn joint_friction(&mut self, name: &str, a: impl Into<Frame>, b: impl Into<Frame>, damping: impl Into<Param>) {
        self.ready_between(name, &JOINT_FRICTION, [a.into(), b.into()].map(Frame::origin), [damping.into()]);
    }

    /// Adds viscous friction (N s/m) of `b` sliding along the axis of `a` (rad, in a's frame).
    pub fn sliding_friction(&mut self, name: &str, a: Point, axis: impl Into<Param>, b: Point, damping: impl Into<Param>) {
        self.ready_between(name, &SLIDING_FRICTION, [a, b], [axis.into(), damping.into()]);
    }

    /// Adds a force (N) on `b` along the axis of `a` (rad, in a's frame), driven by a control.
    pub fn actuator(&mut self, name: &str, a: Point, axis: impl Into<Param>, b: Point, force: Control) {
        self.ready_driven(name, &ACTUATOR, [a, b], &[axis.into()], force);
    }

    /// Adds a torque (N m) on `b` and its reaction on `a`, driven by a control.
    pub fn torque_actuator(&mut self, name: &str, a: impl Into<Frame>, b: impl Into<Frame>, torque: Control) {
        self.ready_driven(name, &TORQUE_ACTUATOR, [a.into(), b.into()].map(Frame::origin), &[], torque);
    }

    pub(super) fn between_potential<E, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        (frames, ends): ((Frame, Frame), Ends),
        parameters: [Param; P],
    ) where
        E: PotentialEnergy<6, P>,
    {
        let formula = Potential::<Fixed<_, 6, 0, 0, P>, 6>::fixed(element);
        self.between(name, formula, (frames, ends), (0..0, &[]), &parameters);
    }

    pub(super) fn between_force<E, const K: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        (frames, ends): ((Frame, Frame), Ends),
        u: [Control; K],
        parameters: [Param; P],
    ) where
        E: Force<6, K, P>,
    {
        let formula = Applied::<Fixed<_, 6, 0, K, P>, 6>::fixed(element);
        self.between(name, formula, (frames, ends), (0..0, &u), &parameters);
    }
}
