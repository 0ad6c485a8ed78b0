//! Bushings and dry friction: force laws that are steep, but smooth enough for a gradient.

use nalgebra::SVector;

use super::forces::torque;
use super::geometry::{Link, turned};
use super::ground::Ends;
use super::joints::{axis, points};
use crate::model::element::ForcePoint;
use crate::model::{Frame, Point, Shape};
use crate::scene::ready::Kind;
use crate::{Force, Param, PotentialEnergy, Scalar, Scene};

/// A bushing: V = ½ (c_x d_x² + c_y d_y² + c_φ (φ_b − φ_a)²), with d from the point of a to that of b in the frame of a; b = [s_a, s_b,
/// c_x, c_y, c_φ].
#[derive(Clone, Copy, Debug)]
pub struct Bushing;

impl PotentialEnergy<6, 7> for Bushing {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 7>, _t: S) -> S {
        let (link, x) = (Link::new(q, b.as_slice()), axis(q, S::zero()));
        let (along, across, turn) = (x.dot(&link.between), turned(&x).dot(&link.between), q[5] - q[2]);
        (b[4] * along * along + b[5] * across * across + b[6] * turn * turn) * 0.5
    }
}

/// The damping of a bushing: viscous forces that oppose the rates of the displacements d_x and d_y (see [`Bushing`]) and of φ_b − φ_a; `b`
/// = [s_a, s_b, damping constants along x, along y and of rotation].
#[derive(Clone, Copy, Debug)]
pub struct BushingDamper;

impl Force<6, 0, 7> for BushingDamper {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 7>) -> SVector<S, 6> {
        let (link, x) = (Link::new(&at.q, b.as_slice()), axis(&at.q, S::zero()));
        let along = |e: &SVector<S, 2>, damping: S| {
            let gradient = link.along_axis(e);
            gradient * -(damping * gradient.dot(&at.v))
        };
        along(&x, b[4]) + along(&turned(&x), b[5]) + torque(b[6] * (at.v[2] - at.v[5]))
    }
}

/// Regularised dry friction in a hinge: the torque −M tanh((φ̇_b − φ̇_a)/ω_s) on body b and its reaction on body a, with the parameters `b`
/// = [M, ω_s].
#[derive(Clone, Copy, Debug)]
pub struct CoulombFriction;

impl Force<6, 0, 2> for CoulombFriction {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 2>) -> SVector<S, 6> {
        torque(dry_friction(at.v[5] - at.v[2], [b[0], b[1]]))
    }
}

/// Regularised dry friction along an axis of a: the force −F tanh(ṡ/v_s), with the coordinate s of body b's point along the axis and the
/// parameters `b` = [s_a, s_b, axis angle, F, v_s].
#[derive(Clone, Copy, Debug)]
pub struct CoulombSliding;

impl Force<6, 0, 7> for CoulombSliding {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 7>) -> SVector<S, 6> {
        let along = Link::new(&at.q, b.as_slice()).along_axis(&axis(&at.q, b[4]));
        along * dry_friction(along.dot(&at.v), [b[5], b[6]])
    }
}

/// The regularised dry friction −F tanh(v/v_s) against a relative speed v.
pub(in crate::scene) fn dry_friction<S: Scalar>(v: S, [force, speed]: [S; 2]) -> S {
    -(force * (v / speed).tanh())
}

pub(super) static BUSHING: Kind = Kind::of_points(
    "bushing",
    &["stiffness_x", "stiffness_y", "stiffness_angle", "damping_x", "damping_y", "damping_angle"],
    |scene, name, part| {
        let [a, b] = part.both();
        let (stiffness, damping) = ([0, 1, 2].map(|i| part.number(i)), [3, 4, 5].map(|i| part.number(i)));
        scene.draw(name, Shape::Spring, a, b);
        let is_zero = |list: &[Param]| list.iter().all(|x| x.constant() == Some(0.0));
        if !is_zero(&stiffness) {
            scene.between_potential(
                &format!("{name} (spring)"),
                Bushing,
                (part.frames(), Ends::Bodies),
                points(a, b, stiffness),
            );
        }
        if !is_zero(&damping) {
            scene.between_force(
                &format!("{name} (damper)"),
                BushingDamper,
                (part.frames(), Ends::Bodies),
                [],
                points(a, b, damping),
            );
        }
    },
);

pub(super) static COULOMB_FRICTION: Kind = Kind::of_frames("Coulomb friction", &["torque", "speed"], |scene, name, part| {
    let [torque, speed] = [0, 1].map(|i| part.number(i));
    scene.require_positive(speed, format!("the speed of `{name}`"));
    scene.between_force(name, CoulombFriction, (part.frames(), Ends::Bodies), [], [torque, speed]);
});

pub(super) static COULOMB_SLIDING: Kind =
    Kind::of_points("Coulomb sliding friction", &["axis", "force", "speed"], |scene, name, part| {
        let ([a, b], numbers) = (part.both(), [0, 1, 2].map(|i| part.number(i)));
        scene.require_positive(numbers[2], format!("the speed of `{name}`"));
        scene.between_force(name, CoulombSliding, (part.frames(), Ends::Points), [], points(a, b, numbers));
    });

impl Scene {
    /// Adds a bushing between two points: stiffnesses along x and y of a's frame (N/m) and against rotation (N m/rad), and the three
    /// damping constants (N s/m, N m s/rad).
    pub fn bushing(&mut self, name: &str, a: Point, b: Point, stiffness: [Param; 3], damping: [Param; 3]) {
        self.ready_between(name, &BUSHING, [a, b], [stiffness, damping].concat());
    }

    /// Adds dry friction in a hinge, regularised: a torque of at most `torque` (N m), reached at a few times `speed` (rad/s).
    ///
    /// There is no sticking: with M = `torque` and ω_s = `speed`, the joint creeps under a torque M₁ < M at the speed ω_s artanh(M₁/M).
    /// Near rest the friction acts as a damper with the constant M/ω_s; for a small `speed` it is stiff and needs an L-stable scheme.
    pub fn coulomb_friction(
        &mut self,
        name: &str,
        a: impl Into<Frame>,
        b: impl Into<Frame>,
        torque: impl Into<Param>,
        speed: impl Into<Param>,
    ) {
        let frames = [a.into(), b.into()].map(Frame::origin);
        self.ready_between(name, &COULOMB_FRICTION, frames, [torque.into(), speed.into()]);
    }

    /// Adds regularised dry friction of `b` sliding along the axis of `a` (rad, in a's frame): a force of at most `force` (N), reached at a few
    /// times `speed` (m/s). There is no sticking.
    pub fn coulomb_sliding(
        &mut self,
        name: &str,
        a: Point,
        axis: impl Into<Param>,
        b: Point,
        force: impl Into<Param>,
        speed: impl Into<Param>,
    ) {
        self.ready_between(name, &COULOMB_SLIDING, [a, b], [axis.into(), force.into(), speed.into()]);
    }
}
