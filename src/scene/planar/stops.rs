//! End stops of relative angles and displacements.

use nalgebra::SVector;

use super::forces::torque;
use super::geometry::Link;
use super::ground::{Ends, of_both};
use super::joints::{axis, points};
use super::onset::normal_force;
use crate::model::element::{ForcePoint, ListCost, ListPoint};
use crate::model::{Frame, Param, Point, Shape};
use crate::scene::ready::Kind;
use crate::{Force, Scalar, Scene};

/// End stops of the angle s = φ_b − φ_a ([`Scene::end_stop`]), smooth for a width w > 0 if true; b = [lower and upper limit, k, c, w].
#[derive(Clone, Copy, Debug)]
pub struct EndStop(pub bool);

impl Force<6, 0, 5> for EndStop {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 5>) -> SVector<S, 6> {
        torque(stop_force(self.0, at.q[5] - at.q[2], at.v[5] - at.v[2], b.as_slice()))
    }
}

/// End stops of the coordinate s of body b's point along an axis of a ([`Scene::sliding_end_stop`]), smooth for a width w > 0 if true; b = [s_a, s_b, axis
/// angle, lower and upper limit, k, c, w].
#[derive(Clone, Copy, Debug)]
pub struct SlidingEndStop(pub bool);

impl Force<6, 0, 10> for SlidingEndStop {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 10>) -> SVector<S, 6> {
        let (link, axis) = (Link::new(&at.q, b.as_slice()), axis(&at.q, b[4]));
        let along = link.along_axis(&axis);
        along * stop_force(self.0, axis.dot(&link.between), along.dot(&at.v), &b.as_slice()[5..])
    }
}

/// The force of both stops along s; b = [lower and upper limit, k, c, w].
pub(in crate::scene) fn stop_force<S: Scalar>(is_smooth: bool, s: S, rate: S, b: &[S]) -> S {
    let normal = |at| normal_force(is_smooth, 1.0, at, [b[2], b[3], b[4]]);
    normal([b[0] - s, -rate]) - normal([s - b[1], rate])
}

/// (s − lower) (upper − s)/(upper − lower), negative beyond the limits.
pub(in crate::scene) fn within<S: Scalar>(s: S, [lower, upper]: [S; 2]) -> S {
    (s - lower) * (upper - s) / (upper - lower)
}

/// The function of a stop's event, for the coordinates that are there; b = [s_a, s_b, axis angle, lower,
/// upper] for a displacement, [lower, upper] for an angle.
struct Range(&'static [usize]);

impl ListCost for Range {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let q = of_both(self.0, at.q);
        match at.b {
            [lower, upper] => within(q[5] - q[2], [*lower, *upper]),
            b => within(axis(&q, b[4]).dot(&Link::new(&q, b).between), [b[5], b[6]]),
        }
    }
}

const NUMBERS: &[&str] = &["axis", "lower", "upper", "stiffness", "damping", "width"];

pub(super) static END_STOP: Kind = Kind::of_frames("end stop", NUMBERS.split_at(1).1, |scene, name, part| {
    let (ends, numbers) = ((part.frames(), Ends::Bodies), [0, 1, 2, 3, 4].map(|i| part.number(i)));
    scene.require_positive(numbers[1] - numbers[0], format!("the upper limit minus the lower limit of `{name}`"));
    let is_smooth = scene.is_smooth(name, numbers[4]);
    scene.between_force(name, EndStop(is_smooth), ends, [], numbers);
    if !is_smooth {
        scene.between_event(name, Range, ends, &numbers[..2]);
    }
});

pub(super) static SLIDING_END_STOP: Kind = Kind::of_points("sliding end stop", NUMBERS, |scene, name, part| {
    let ([a, b], numbers) = (part.both(), [0, 1, 2, 3, 4, 5].map(|i| part.number(i)));
    let [axis, lower, upper, .., width] = numbers;
    for (limit, normal) in [(lower, axis), (upper, axis + std::f64::consts::PI)] {
        let [x, y] = a.at();
        let wall = a.frame().at(x + axis.cos() * limit, y + axis.sin() * limit);
        scene.draw(name, Shape::Ground { normal }, wall, b);
    }
    scene.require_positive(upper - lower, format!("the upper limit minus the lower limit of `{name}`"));
    let (ends, parameters) = ((part.frames(), Ends::Points), points::<6, 10>(a, b, numbers));
    let is_smooth = scene.is_smooth(name, width);
    scene.between_force(name, SlidingEndStop(is_smooth), ends, [], parameters);
    if !is_smooth {
        scene.between_event(name, Range, ends, &parameters[..7]);
    }
});

impl Scene {
    /// Adds end stops of the relative angle s = φ_b − φ_a at the `limits` [lower, upper] (rad).
    ///
    /// `law` = [k in N m/rad, c in s/rad, w in rad]. Beyond a limit by δ > 0, a torque k δ max(1 + c dδ/dt, 0) acts on b towards the range, and
    /// its reaction on a. It begins smoothly over the width w, as in [`circle_contact`](Self::circle_contact). If w is the constant 0, there is
    /// an event of this name, whose function (s − lower) (upper − s)/(upper − lower) is negative beyond the limits.
    pub fn end_stop(&mut self, name: &str, a: impl Into<Frame>, b: impl Into<Frame>, limits: [Param; 2], law: [Param; 3]) {
        let frames = [a.into(), b.into()].map(Frame::origin);
        self.ready_between(name, &END_STOP, frames, [limits.as_slice(), &law].concat());
    }

    /// Adds end stops of the point `b` along the axis of `a` (rad, in a's frame) at the `limits` [lower, upper] of its coordinate s along the axis
    /// (m, 0 at `a`).
    ///
    /// `law` = [k in N/m, c in s/m, w in m]; force and event are those of [`end_stop`](Self::end_stop) for this s.
    pub fn sliding_end_stop(
        &mut self,
        name: &str,
        a: Point,
        axis: impl Into<Param>,
        b: Point,
        limits: [Param; 2],
        law: [Param; 3],
    ) {
        let numbers = [[axis.into()].as_slice(), &limits, &law].concat();
        self.ready_between(name, &SLIDING_END_STOP, [a, b], numbers);
    }

    /// Whether a contact or a stop has a smooth onset; its width is then required to be positive.
    pub(in crate::scene) fn is_smooth(&mut self, name: &str, width: Param) -> bool {
        let is_smooth = width.constant() != Some(0.0);
        if is_smooth {
            self.require_positive(width, format!("the width of `{name}`"));
        }
        is_smooth
    }
}
