//! [`Path`]: the frames from the ground, or from another frame, to a marker; [`MarkerState`]: how the marker moves.

use super::formula::{Fixed, Follows, Moved, Vector, cross, dot, minus, plus, scaled, values, zero};
use super::tree::Rates;
use crate::Scalar;
use crate::model::space::Motion;

/// The frames to a marker, each with its motion, and the marker in the last of them.
#[derive(Clone, Debug)]
pub(super) struct Path {
    pub(super) frames: Vec<(Fixed, Motion<Follows>)>,
    pub(super) end: Fixed,
}

/// Position and motion of a marker, with components in the inertial frame.
#[derive(Clone, Copy, Debug)]
pub struct MarkerState<S> {
    /// The position, m.
    pub position: [S; 3],
    /// The directions of the axes x, y and z: the columns of the rotation matrix.
    pub axes: [[S; 3]; 3],
    /// The velocity, m/s.
    pub velocity: [S; 3],
    /// The angular velocity, rad/s.
    pub angular_velocity: [S; 3],
    /// The acceleration, m/s².
    pub acceleration: [S; 3],
    /// The angular acceleration, rad/s².
    pub angular_acceleration: [S; 3],
}

/// A force and a torque, with components in the inertial frame.
#[derive(Clone, Copy, Debug)]
pub struct Load<S> {
    /// The force at the marker, N.
    pub force: [S; 3],
    /// The torque on the body of the marker, N m.
    pub torque: [S; 3],
}

/// The angular acceleration of a frame and the acceleration of its origin, in its axes.
#[derive(Clone, Copy)]
struct Accelerations<S> {
    turning: Vector<S>,
    origin: Vector<S>,
}

/// a + α × x + w × (w × x).
fn carried<S: Scalar>(of: &Accelerations<S>, w: Vector<S>, x: Vector<S>) -> Vector<S> {
    plus(of.origin, plus(cross(of.turning, x), cross(w, cross(w, x))))
}

impl<S: Scalar> Accelerations<S> {
    /// The accelerations of a frame that moves relative to this one, whose rates are `outer`.
    fn of_inner(&self, outer: &Rates<S>, fixed: &Fixed, motion: &Motion<Follows>, [q, v, v_dot, b]: [&[S]; 4]) -> Self {
        let moved = motion.at(q, b);
        let (turns, slides) = motion.rates(q, v, b);
        let (turns_faster, slides_faster) = motion.accelerations(q, v, v_dot, b);
        let before = Accelerations {
            turning: fixed.inward(self.turning, b),
            origin: fixed.inward(carried(self, outer.turning, fixed.origin(b)), b),
        };
        let w = fixed.inward(outer.turning, b);
        let origin = plus(carried(&before, w, moved.origin()), scaled(cross(w, slides), S::from(2.0)));
        let turning = plus(moved.inward(before.turning), cross(moved.inward(w), turns));
        Accelerations { turning: plus(turning, turns_faster), origin: plus(moved.inward(origin), slides_faster) }
    }
}

impl Path {
    fn moved<S: Scalar>(&self, q: &[S], b: &[S]) -> Vec<Moved<S>> {
        self.frames.iter().map(|(_, motion)| motion.at(q, b)).collect()
    }

    /// A vector of the last frame with its components in the first one.
    fn outward<S: Scalar>(&self, moved: &[Moved<S>], x: Vector<S>, b: &[S]) -> Vector<S> {
        let frames = self.frames.iter().zip(moved).rev();
        frames.fold(x, |x, ((fixed, _), moved)| fixed.outward(moved.outward(x), b))
    }

    fn axes<S: Scalar>(&self, moved: &[Moved<S>], b: &[S]) -> [Vector<S>; 3] {
        let column = |j: usize| values([0, 1, 2].map(|i| self.end.turn[i][j]), b);
        [0, 1, 2].map(|j| self.outward(moved, column(j), b))
    }

    fn position<S: Scalar>(&self, moved: &[Moved<S>], b: &[S]) -> Vector<S> {
        let frames = self.frames.iter().zip(moved).rev();
        frames.fold(self.end.origin(b), |x, ((fixed, _), moved)| {
            plus(fixed.outward(plus(moved.outward(x), moved.origin()), b), fixed.origin(b))
        })
    }

    /// The components of a point in the last frame, from those in the first one.
    pub(super) fn inward<S: Scalar>(&self, x: Vector<S>, q: &[S], b: &[S]) -> Vector<S> {
        let x = self.frames.iter().fold(x, |x, (fixed, motion)| {
            let moved = motion.at(q, b);
            moved.inward(minus(fixed.inward(minus(x, fixed.origin(b)), b), moved.origin()))
        });
        self.end.inward(minus(x, self.end.origin(b)), b)
    }

    /// Position and axes.
    pub(super) fn place<S: Scalar>(&self, q: &[S], b: &[S]) -> (Vector<S>, [Vector<S>; 3]) {
        let moved = self.moved(q, b);
        (self.position(&moved, b), self.axes(&moved, b))
    }

    /// Position and motion.
    pub(super) fn state<S: Scalar>(&self, [q, v, v_dot, b]: [&[S]; 4]) -> MarkerState<S> {
        let moved = self.moved(q, b);
        let mut rates = Rates::none();
        let mut faster = Accelerations { turning: zero(), origin: zero() };
        for (fixed, motion) in &self.frames {
            faster = faster.of_inner(&rates, fixed, motion, [q, v, v_dot, b]);
            rates = rates.of_inner(fixed, motion, [q, v, b]);
        }
        let at = self.end.origin(b);
        let out = |x| self.outward(&moved, x, b);
        MarkerState {
            position: self.position(&moved, b),
            axes: self.axes(&moved, b),
            velocity: out(plus(rates.origin, cross(rates.turning, at))),
            angular_velocity: out(rates.turning),
            acceleration: out(carried(&faster, rates.turning, at)),
            angular_acceleration: out(faster.turning),
        }
    }

    /// Adds the generalized forces of a load on the marker.
    pub(super) fn pull_back<S: Scalar>(&self, load: &Load<S>, [q, b]: [&[S]; 2], force: &mut [S]) {
        let moved = self.moved(q, b);
        let inward =
            |x: Vector<S>| self.frames.iter().zip(&moved).fold(x, |x, ((fixed, _), moved)| moved.inward(fixed.inward(x, b)));
        let own = inward(load.force);
        let mut now = Load { force: own, torque: plus(inward(load.torque), cross(self.end.origin(b), own)) };
        for ((fixed, motion), moved) in self.frames.iter().zip(&moved).rev() {
            motion.pull_back(&now, [q, b], force);
            let outer = moved.outward(now.force);
            let torque = plus(moved.outward(now.torque), cross(moved.origin(), outer));
            let force = fixed.outward(outer, b);
            now = Load { force, torque: plus(fixed.outward(torque, b), cross(fixed.origin(b), force)) };
        }
    }
}

impl Motion<Follows> {
    /// Adds the generalized forces of a load at the origin of the inner frame, in its axes.
    fn pull_back<S: Scalar>(&self, load: &Load<S>, [q, b]: [&[S]; 2], force: &mut [S]) {
        let mut add = |of: &Follows, x: S| force[of.q] += x * of.factor.value(b);
        match self {
            Motion::Turn(axis, angle) => add(angle, load.torque[*axis]),
            Motion::Slide(axis, offset) => add(offset, load.force[*axis]),
            Motion::Ball(e) => {
                let [e0, x @ ..] = e.each_ref().map(|e| e.place(q, b));
                let twice = (e0 * e0 + dot(x, x)).recip() * 2.0;
                add(&e[0], -(dot(x, load.torque) * twice));
                let rest = plus(scaled(load.torque, e0), cross(x, load.torque));
                e[1..].iter().zip(rest).for_each(|(of, x)| add(of, x * twice));
            }
        }
    }
}
