//! Rigid contact of a point with a line, for impacts and for constraints that hold only for a time.

use nalgebra::SVector;

use super::circles::Gap;
use super::geometry::Link;
use super::ground::Ends;
use super::joints::{axis, points};
use crate::model::{Event, Point, Shape};
use crate::scene::ready::Kind;
use crate::{Constraint, Multiplier, Param, Scalar, Scene};

/// The gap between a point of body b and a line of body a: Φ = n · d with the vector d from the point of a, through which the line passes, to that of b,
/// and the normal n of the line; b = [s_a, s_b, angle of the normal in a].
#[derive(Clone, Copy, Debug)]
pub struct PointOnLine;

impl Constraint<6, 1, 5> for PointOnLine {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 5>, _t: S) -> SVector<S, 1> {
        SVector::from([axis(q, b[4]).dot(&Link::new(q, b.as_slice()).between)])
    }
}

/// A rigid contact: a constraint equation, and the event at which its Φ is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RigidContact {
    /// The event.
    pub event: Event,
    /// The multiplier of the constraint equation.
    pub equation: Multiplier,
}

pub(super) static RIGID_CONTACT: Kind = Kind::of_points("rigid contact", &["normal"], |scene, name, part| {
    let ([a, b], normal) = (part.both(), part.number(0));
    scene.draw(name, Shape::Ground { normal }, a, b);
    let (ends, numbers) = ((part.frames(), Ends::Points), points::<_, 6>(a, b, [normal, 0.0.into()]));
    scene.joint(name, PointOnLine, ends, points(a, b, [normal]));
    scene.between_event(name, |there| Gap(false, there), ends, &numbers);
    scene.note_gap(name);
});

impl Scene {
    /// Adds the gap Φ = n · d between the point `b` and the line through `a` as a constraint equation and as the event Φ = 0. The `normal` n of the line is
    /// at an angle (rad) in a's frame, and d is the vector from `a` to `b`.
    ///
    /// Say what the event does: [`impact_at`](Self::impact_at), [`close_at`](Self::close_at) or [`open_at`](Self::open_at). Without it, the equation is a
    /// joint that always holds.
    pub fn rigid_contact(&mut self, name: &str, a: Point, normal: impl Into<Param>, b: Point) -> RigidContact {
        let normal = normal.into();
        let [equation] = self.ready_joint(name, &RIGID_CONTACT, [a, b], [normal]);
        let event = self.event_named(name).unwrap_or_else(|| Event(self.parts.scene.handle(0)));
        RigidContact { event, equation }
    }
}
