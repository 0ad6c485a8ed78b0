//! Joints between two bodies a and b.

use nalgebra::SVector;

use super::geometry::{Link, rotated, turned};
use super::ground::{
    BetweenParticles, FromGround, FromParticle, GroundToParticle, ParticleToGround, ToGround, ToParticle, between,
    between_any,
};
use super::motion::Motion;
use crate::model::{Frame, Owner, Point, Shape};
use crate::{Constraint, Multiplier, Param, Scalar, Scene};

/// A hinge: the points coincide, Φ = r_b + R_b s_b − r_a − R_a s_a; b = [s_a, s_b].
#[derive(Clone, Copy, Debug)]
pub struct Revolute;

impl Constraint<6, 2, 4> for Revolute {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 4>, _t: S) -> SVector<S, 2> {
        Link::new(q, b.as_slice()).between
    }
}

/// A slider: the point of b stays on a line of a, and b does not turn against a; b = [s_a, s_b, axis angle in a, φ_b − φ_a].
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

/// A massless rod: the points keep their distance, Φ = (|d|² − l²)/(2 l); b = [s_a, s_b, l].
///
/// Φ is the change of length to first order, and smooth where |d| itself has a kink.
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

/// The unit vector at an angle to body a's x axis.
pub(super) fn axis<S: Scalar>(q: &SVector<S, 6>, angle: S) -> SVector<S, 2> {
    rotated(q[2] + angle, [S::one(), S::zero()])
}

impl Scene {
    /// Adds a hinge between two points.
    pub fn revolute(&mut self, name: &str, a: Point, b: Point) -> [Multiplier; 2] {
        self.draw(name, Shape::Hinge, a, b);
        self.joint_of_points(name, Revolute, (a.frame, b.frame), points(a, b, []))
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
        let axis = axis.into();
        self.draw(name, Shape::Slider { axis }, a, b);
        self.joint(name, Prismatic, (a.frame, b.frame), points(a, b, [axis, angle.into()]))
    }

    /// Adds a rigid connection of two points at a relative angle (rad).
    pub fn weld(&mut self, name: &str, a: Point, b: Point, angle: impl Into<Param>) -> [Multiplier; 3] {
        self.draw(name, Shape::Weld, a, b);
        self.joint(name, Weld, (a.frame, b.frame), points(a, b, [angle.into()]))
    }

    /// Adds a massless rod of a given length (m) between two points.
    pub fn distance(&mut self, name: &str, a: Point, b: Point, length: impl Into<Param>) -> [Multiplier; 1] {
        let length = length.into();
        self.draw(name, Shape::Rod, a, b);
        self.require_positive(length, format!("the length of `{name}`"));
        self.joint_of_points(name, Distance, (a.frame, b.frame), points(a, b, [length]))
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
        self.joint(name, DrivenAngle(motion), (a.into(), b.into()), parameters)
    }

    pub(super) fn joint<E, const M: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        (a, b): (Frame, Frame),
        parameters: [Param; P],
    ) -> [Multiplier; M]
    where
        E: Constraint<6, M, P>,
    {
        between!((a.0, b.0), element, q, self.constraint(name, element, q, parameters), {
            self.report_frames(name, (a.0, b.0));
            self.no_multipliers()
        })
    }

    /// The same for one that goes with particles too.
    fn joint_of_points<E, const M: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        (a, b): (Frame, Frame),
        parameters: [Param; P],
    ) -> [Multiplier; M]
    where
        E: Constraint<6, M, P>,
    {
        between_any!((a.0, b.0), element, q, self.constraint(name, element, q, parameters), {
            self.report_frames(name, (a.0, b.0));
            self.no_multipliers()
        })
    }
}

/// The parameters [s_a, s_b, more].
pub(super) fn points<const MORE: usize, const P: usize>(a: Point, b: Point, more: [Param; MORE]) -> [Param; P] {
    points_and(a, b, more, [])
}

/// The parameters [s_a, s_b, more, those of a formula, zeros].
pub(super) fn points_and<const MORE: usize, const F: usize, const P: usize>(
    a: Point,
    b: Point,
    more: [Param; MORE],
    of_formula: [Param; F],
) -> [Param; P] {
    const { assert!(4 + MORE + F <= P, "too many parameters") };
    padded([a.at, b.at].into_iter().flatten().chain(more).chain(of_formula))
}

/// Some parameters and zeros behind them.
pub(super) fn padded<const P: usize>(parameters: impl IntoIterator<Item = Param>) -> [Param; P] {
    let mut all = parameters.into_iter();
    std::array::from_fn(|_| all.next().unwrap_or(0.0.into()))
}
