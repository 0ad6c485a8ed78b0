//! Joints between two bodies a and b.

use nalgebra::SVector;

use super::geometry::{Link, rotated, turned};
use super::ground::Ends;
use super::motion::{Motion, with_motion};
use crate::model::{Frame, Point, Shape};
use crate::scene::ready::{Kind, Part};
use crate::system::{Fixed, Holonomic};
use crate::{Constraint, Multiplier, Param, Scalar, Scene};

/// A hinge: the points coincide, Φ = r_b + R_b s_b − r_a − R_a s_a; b = [s_a, s_b].
#[derive(Clone, Copy, Debug)]
pub struct Revolute;

impl Constraint<6, 2, 4> for Revolute {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 4>, _t: S) -> SVector<S, 2> {
        Link::new(q, b.as_slice()).between
    }
}

/// A slider: the point of body b stays on a line of body a, and b does not rotate relative to a; the parameters are `b` = [s_a, s_b, axis
/// angle in a, φ_b − φ_a].
#[derive(Clone, Copy, Debug)]
pub struct Prismatic;

impl Constraint<6, 2, 6> for Prismatic {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 6>, _t: S) -> SVector<S, 2> {
        let normal = turned(&axis(q, b[4]));
        SVector::from([normal.dot(&Link::new(q, b.as_slice()).between), q[5] - q[2] - b[5]])
    }
}

/// A rigid connection: the points coincide and φ_b − φ_a is constant; b = [s_a, s_b, φ_b − φ_a].
#[derive(Clone, Copy, Debug)]
pub struct Weld;

impl Constraint<6, 3, 5> for Weld {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 5>, _t: S) -> SVector<S, 3> {
        let between = Link::new(q, b.as_slice()).between;
        SVector::from([between[0], between[1], q[5] - q[2] - b[4]])
    }
}

/// A massless rod between two points at the distance l: Φ = (|d|² − l²)/(2 l); b = [s_a, s_b, l].
///
/// To first order, Φ is the deviation of the distance from l; it is smooth also at d = 0, where |d| has a kink.
#[derive(Clone, Copy, Debug)]
pub struct Distance;

impl Constraint<6, 1, 5> for Distance {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 5>, _t: S) -> SVector<S, 1> {
        let d = Link::new(q, b.as_slice()).between;
        SVector::from([(d.dot(&d) / b[4] - b[4]) * 0.5])
    }
}

/// A prescribed relative angle: Φ = φ_b − φ_a − f(t); b = parameters of the motion f.
#[derive(Clone, Copy, Debug)]
pub struct DrivenAngle<F>(pub F);

impl<F: Motion<P>, const P: usize> Constraint<6, 1, P> for DrivenAngle<F> {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, P>, t: S) -> SVector<S, 1> {
        SVector::from([q[5] - q[2] - self.0.value(t, b)])
    }
}

/// The unit vector at the given angle to the x axis of body a.
pub(super) fn axis<S: Scalar>(q: &SVector<S, 6>, angle: S) -> SVector<S, 2> {
    rotated(q[2] + angle, [S::one(), S::zero()])
}

pub(super) static REVOLUTE: Kind = Kind::of_points("revolute", &[], |scene, name, part| {
    let [a, b] = part.both();
    scene.draw(name, Shape::Hinge, a, b);
    scene.joint(name, Revolute, (part.frames(), Ends::Points), points(a, b, []));
});

pub(super) static PRISMATIC: Kind = Kind::of_points("prismatic", &["axis", "angle"], |scene, name, part| {
    let ([a, b], axis) = (part.both(), part.number(0));
    scene.draw(name, Shape::Slider { axis }, a, b);
    scene.joint(name, Prismatic, (part.frames(), Ends::Bodies), points(a, b, [axis, part.number(1)]));
});

pub(super) static WELD: Kind = Kind::of_points("weld", &["angle"], |scene, name, part| {
    let [a, b] = part.both();
    scene.draw(name, Shape::Weld, a, b);
    scene.joint(name, Weld, (part.frames(), Ends::Bodies), points(a, b, [part.number(0)]));
});

pub(super) static DISTANCE: Kind = Kind::of_points("distance", &["length"], |scene, name, part| {
    let ([a, b], length) = (part.both(), part.number(0));
    scene.draw(name, Shape::Rod, a, b);
    scene.require_positive(length, format!("the length of `{name}`"));
    scene.joint(name, Distance, (part.frames(), Ends::Points), points(a, b, [length]));
});

pub(super) static DRIVEN_ANGLE: Kind = Kind::of_frames("driven angle", &[], |scene, name, part| {
    let (a, b) = part.frames();
    with_motion!(part, motion, parameters, scene.driven_angle(name, a, b, motion, parameters));
})
.moving();

impl Scene {
    /// Adds a hinge between two points.
    pub fn revolute(&mut self, name: &str, a: Point, b: Point) -> [Multiplier; 2] {
        self.ready_joint(name, &REVOLUTE, [a, b], [])
    }

    /// Adds a slider: `b` moves along the line through `a` at `axis` (rad, in a's frame) and keeps the relative `angle`.
    pub fn prismatic(
        &mut self,
        name: &str,
        a: Point,
        axis: impl Into<Param>,
        b: Point,
        angle: impl Into<Param>,
    ) -> [Multiplier; 2] {
        self.ready_joint(name, &PRISMATIC, [a, b], [axis.into(), angle.into()])
    }

    /// Adds a rigid connection of two points at a relative angle (rad).
    pub fn weld(&mut self, name: &str, a: Point, b: Point, angle: impl Into<Param>) -> [Multiplier; 3] {
        self.ready_joint(name, &WELD, [a, b], [angle.into()])
    }

    /// Adds a massless rod of a given length (m) between two points.
    pub fn distance(&mut self, name: &str, a: Point, b: Point, length: impl Into<Param>) -> [Multiplier; 1] {
        self.ready_joint(name, &DISTANCE, [a, b], [length.into()])
    }

    /// Adds a prescribed angle φ_b − φ_a = f(t; parameters).
    pub fn driven_angle<F, const P: usize>(
        &mut self,
        name: &str,
        a: impl Into<Frame>,
        b: impl Into<Frame>,
        motion: F,
        parameters: [Param; P],
    ) -> [Multiplier; 1]
    where
        F: Motion<P>,
    {
        let points = [a.into(), b.into()].map(Frame::origin);
        self.multipliers_of(|scene| {
            let part = Part { points: points.to_vec(), ..Part::of(&DRIVEN_ANGLE) };
            scene.driven(name, part, motion, parameters, |scene, motion| {
                scene.joint(name, DrivenAngle(motion), (points.map(Point::frame).into(), Ends::Bodies), parameters);
            });
        })
    }

    pub(super) fn joint<E, const M: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        (frames, ends): ((Frame, Frame), Ends),
        parameters: [Param; P],
    ) -> [Multiplier; M]
    where
        E: Constraint<6, M, P>,
    {
        let formula = Holonomic::<Fixed<_, 6, M, 0, P>, 6>::fixed(element);
        let first = self.parts.equations;
        if self.between(name, formula, (frames, ends), (first..first + M, &[]), &parameters) {
            self.equations(name, M);
            self.multipliers(first)
        } else {
            self.no_multipliers()
        }
    }
}

/// The parameters [s_a, s_b, more].
pub(super) fn points<const MORE: usize, const P: usize>(a: Point, b: Point, more: [Param; MORE]) -> [Param; P] {
    points_and(a, b, more, [])
}

/// The parameters [s_a, s_b, more, parameters of a function, zeros].
pub(super) fn points_and<const MORE: usize, const F: usize, const P: usize>(
    a: Point,
    b: Point,
    more: [Param; MORE],
    of_formula: [Param; F],
) -> [Param; P] {
    const { assert!(4 + MORE + F <= P, "too many parameters") };
    padded([a.at, b.at].into_iter().flatten().chain(more).chain(of_formula))
}

/// The parameters, followed by zeros.
pub(super) fn padded<const P: usize>(parameters: impl IntoIterator<Item = Param>) -> [Param; P] {
    let mut all = parameters.into_iter();
    std::array::from_fn(|_| all.next().unwrap_or(0.0.into()))
}
