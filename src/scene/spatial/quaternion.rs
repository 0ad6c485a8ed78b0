//! Orientations as quaternions.

use nalgebra::UnitQuaternion;

use super::elements::Arguments;
use super::formula::{Follows, Number, cross, dot, plus, scaled, values};
use crate::model::space::{Bodies, Carried, Matrix, Motion};
use crate::model::{Coordinate, Param};
use crate::{Scalar, Scene};

/// A quaternion (e₀, x).
pub(super) type Quaternion<S> = [S; 4];

/// The orientation of a marker in a frame: turns that are fixed and motions of joints, in this order, and the turn of the marker.
#[derive(Clone, Debug)]
pub(super) struct Orientation {
    turns: Vec<([Number; 4], Motion<Follows>)>,
    end: [Number; 4],
}

/// a b.
fn product<S: Scalar>([a0, a @ ..]: Quaternion<S>, [b0, b @ ..]: Quaternion<S>) -> Quaternion<S> {
    let [x, y, z] = plus(plus(scaled(b, a0), scaled(a, b0)), cross(a, b));
    [a0 * b0 - dot(a, b), x, y, z]
}

/// ā b: the orientation b seen from a.
pub(super) fn seen_from<S: Scalar>([a0, x, y, z]: Quaternion<S>, b: Quaternion<S>) -> Quaternion<S> {
    product([a0, -x, -y, -z], b)
}

impl Scene {
    /// Sets the initial Euler parameters of a [`Ball`](super::Ball) or [`Free`](super::Free) joint, `joint.orientation`, to a rotation of b relative to a.
    pub fn place_rotation(&mut self, orientation: [Coordinate; 4], rotation: UnitQuaternion<f64>) {
        let e = [rotation.w, rotation.i, rotation.j, rotation.k];
        orientation.into_iter().zip(e).for_each(|(coordinate, e)| self.place(coordinate, e));
    }
}

impl Motion<Follows> {
    fn quaternion<S: Scalar>(&self, q: &[S], b: &[S]) -> Quaternion<S> {
        let mut turn = [1.0, 0.0, 0.0, 0.0].map(S::from);
        match self {
            Motion::Turn(axis, angle) => (turn[1 + axis], turn[0]) = (angle.place(q, b) * 0.5).sin_cos(),
            Motion::Slide(..) => {}
            Motion::Ball(e) => turn = e.each_ref().map(|e| e.place(q, b)),
        }
        turn
    }
}

impl Orientation {
    pub(super) fn at<S: Scalar>(&self, q: &[S], b: &[S]) -> Quaternion<S> {
        let mut turns = self.turns.iter().map(|(fixed, motion)| product(values(*fixed, b), motion.quaternion(q, b)));
        let first = turns.next().unwrap_or([1.0, 0.0, 0.0, 0.0].map(S::from));
        product(turns.fold(first, product), values(self.end, b))
    }
}

impl Bodies {
    /// The orientation of a marker in another frame, or in that of the ground.
    pub(super) fn orientation(
        &self,
        from: Option<usize>,
        to: &Carried,
        value: &dyn Fn(Param) -> f64,
        of: &mut Arguments,
    ) -> Orientation {
        let chain = self.chain(from, to.frame).into_iter().map(|which| &self.frames[which]);
        let turns = chain.map(|frame| (of.b.numbers(quaternion(frame.turn, value)), of.motion(&frame.motion))).collect();
        Orientation { turns, end: of.b.numbers(quaternion(to.turn, value)) }
    }
}

/// The quaternion of a rotation, divided by its entry that is the largest for the present values before it gets the length 1.
fn quaternion(turn: Matrix, value: &dyn Fn(Param) -> f64) -> [Param; 4] {
    let entry = |i: usize, j: usize| turn[i][j];
    let one = Param::from(1.0);
    let sum = |i: usize, j: usize| entry(i, j) + entry(j, i);
    let skew = |i: usize, j: usize| entry(i, j) - entry(j, i);
    let all = [
        [one + entry(0, 0) + entry(1, 1) + entry(2, 2), skew(2, 1), skew(0, 2), skew(1, 0)],
        [skew(2, 1), one + entry(0, 0) - entry(1, 1) - entry(2, 2), sum(0, 1), sum(0, 2)],
        [skew(0, 2), sum(0, 1), one - entry(0, 0) + entry(1, 1) - entry(2, 2), sum(1, 2)],
        [skew(1, 0), sum(0, 2), sum(1, 2), one - entry(0, 0) - entry(1, 1) + entry(2, 2)],
    ];
    // The traces of R and of R after half turns about the axes: values of new expressions are not known yet.
    let [x, y, z] = [0, 1, 2].map(|i| value(entry(i, i)));
    let traces = [x + y + z, x - y - z, y - x - z, z - x - y];
    let largest = (0..4).max_by(|&i, &j| traces[i].total_cmp(&traces[j])).unwrap_or(0);
    let length = all[largest].into_iter().fold(Param::from(0.0), |sum, entry| sum + entry * entry).sqrt();
    all[largest].map(|entry| entry / length)
}
