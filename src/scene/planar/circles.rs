//! Contact of a point or a circle with a half-plane, of two circles, and of a pin with its bore.

use nalgebra::SVector;

use super::geometry::{Link, turned};
use super::ground::{Ends, of_both};
use super::joints::{axis, points};
use super::onset::normal_force;
use crate::model::element::{ForcePoint, ListCost, ListPoint};
use crate::model::{Param, Point, Shape};
use crate::scene::ready::{Kind, Part};
use crate::{Force, Scalar, Scene};

/// Rounding of the distance of two centres, relative to the radii and squared, so that centres that coincide have a direction.
const COINCIDENT: f64 = 1e-20;

/// Contact of a circle of body b with a circle or with a half-plane of body a ([`Scene::circle_contact`], [`Scene::circle_pair_contact`]), or of a point
/// if r_b = 0 ([`Scene::contact`]); `b` = [s_a, s_b, r_a or normal angle in a, r_b, k, c, μ, v_s, w].
#[derive(Clone, Copy, Debug)]
pub struct CircleContact {
    /// True for a circle of a, false for a half-plane.
    pub is_pair: bool,
    /// True if the force begins over the width w > 0, false if it has a kink.
    pub is_smooth: bool,
}

impl Force<6, 0, 11> for CircleContact {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 6, 0>, b: &SVector<S, 11>) -> SVector<S, 6> {
        let (link, normal, gap) = touch(self.is_pair, &at.q, b.as_slice());
        push(&link, &normal, &at.v, [b[8], b[9]], |rate| {
            normal_force(self.is_smooth, 1.5, [-gap, rate], [b[6], b[7], b[10]])
        })
    }
}

/// The forces of a contact at the end of a link: a normal force, computed from the rate of the depth, and friction with [μ, v_s].
fn push<S: Scalar>(
    link: &Link<S>,
    normal: &SVector<S, 2>,
    v: &SVector<S, 6>,
    [mu, speed]: [S; 2],
    force: impl FnOnce(S) -> S,
) -> SVector<S, 6> {
    let (away, along) = (link.along_axis(normal), link.along_axis(&turned(normal)));
    let push = force(-away.dot(v));
    let friction = mu * (along.dot(v) / speed).tanh();
    // Both act at the point of b; the reaction on a acts there, too.
    away * push - along * (push * friction)
}

/// The link from the point of a to the contact point of b, the normal towards b, and the gap.
fn touch<S: Scalar>(is_pair: bool, q: &SVector<S, 6>, b: &[S]) -> (Link<S>, SVector<S, 2>, S) {
    let link = Link::new(q, b);
    let (normal, distance) = if is_pair {
        // The circle of b is outside that of a, or inside it if r_a < 0.
        let (d, side, size) = (link.between, b[4].signum(), b[4] * b[4] + b[5] * b[5]);
        let length = (d.dot(&d) + size * COINCIDENT).sqrt();
        (d * (side / length), side * length - b[4])
    } else {
        let normal = axis(q, b[4]);
        (normal, normal.dot(&link.between))
    };
    let arm = normal * b[5];
    (Link { arm_b: link.arm_b - arm, between: link.between - arm, ..link }, normal, distance - b[5])
}

/// The gap of a contact (of a circle of a, or of a half-plane), which is negative during the contact, for the coordinates that are there.
pub(super) struct Gap(pub(super) bool, pub(super) &'static [usize]);

impl ListCost for Gap {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        touch(self.0, &of_both(self.1, at.q), at.b).2
    }
}

pub(super) static CONTACT: Kind =
    Kind::of_points("contact", &["normal", "stiffness", "damping", "friction", "speed"], |scene, name, part| {
        let ([normal, k, c, mu, speed], zero) = ([0, 1, 2, 3, 4].map(|i| part.number(i)), Param::from(0.0));
        scene.draw(name, Shape::Ground { normal }, part.points[0], part.points[1]);
        add(scene, name, part, false, [normal, zero, k, c, mu, speed, zero]);
    });

const ON_LINE: &[&str] = &["normal", "radius", "stiffness", "damping", "friction", "speed", "width"];
const OF_PAIR: &[&str] = &["radius_a", "radius_b", "stiffness", "damping", "friction", "speed", "width"];

pub(super) static CIRCLE_CONTACT: Kind = Kind::of_points("circle contact", ON_LINE, |scene, name, part| {
    let numbers = [0, 1, 2, 3, 4, 5, 6].map(|i| part.number(i));
    scene.draw(name, Shape::Ground { normal: numbers[0] }, part.points[0], part.points[1]);
    scene.draw(name, Shape::Wheel { radius: numbers[1] }, part.points[1], part.points[1]);
    add(scene, name, part, false, numbers);
});

pub(super) static CIRCLE_PAIR: Kind = Kind::of_points("contact of circles", OF_PAIR, |scene, name, part| {
    let numbers = [0, 1, 2, 3, 4, 5, 6].map(|i| part.number(i));
    (0..2).for_each(|i| scene.draw(name, Shape::Wheel { radius: numbers[i] }, part.points[i], part.points[i]));
    add(scene, name, part, true, numbers);
});

fn add(scene: &mut Scene, name: &str, part: &Part, is_pair: bool, numbers: [Param; 7]) {
    let ([a, b], [_, radius, .., speed, width]) = (part.both(), numbers);
    let (ends, parameters) = ((part.frames(), Ends::Points), points::<7, 11>(a, b, numbers));
    scene.require_nonnegative(radius, format!("the radius of `{name}`"));
    scene.require_positive(speed, format!("the friction speed of `{name}`"));
    let is_smooth = scene.is_smooth(name, width);
    scene.between_force(name, CircleContact { is_pair, is_smooth }, ends, [], parameters);
    if !is_smooth {
        scene.between_event(name, |there| Gap(is_pair, there), ends, &parameters[..6]);
    }
}

impl Scene {
    /// Adds the contact of the point `b` with the half-plane through `a` whose outer `normal` is at an angle (rad) in a's frame.
    ///
    /// `law` = [k in N/m^(3/2), c in s/m, μ, v_s in m/s]: Hertz' stiffness, Hunt and Crossley's damping, coefficient and speed of regularised
    /// friction. The force is only as smooth as δ^(3/2). Steps must resolve the duration of a contact; otherwise the gradient is that of
    /// a motion that misses the contact ([`Warning::UnresolvedElement`](crate::Warning::UnresolvedElement)). There is no sticking.
    ///
    /// The contact is also an event of this name ([`event_named`](Self::event_named)): its function is n · d with the vector d from `a` to `b`, which
    /// is negative during the contact.
    pub fn contact(&mut self, name: &str, a: Point, normal: impl Into<Param>, b: Point, law: [Param; 4]) {
        self.ready_between(name, &CONTACT, [a, b], [normal.into(), law[0], law[1], law[2], law[3]]);
    }

    /// Adds the contact of a circle of radius r (m) about the point `b` with the half-plane through `a` whose outer `normal` is at an angle (rad)
    /// in a's frame.
    ///
    /// `law` = [k in N/m^(3/2), c in s/m, μ, v_s in m/s, w in m]. With the outer normal n, the vector d from `a` to `b` and the depth δ = r −
    /// n · d, the normal force along n is N = k δ^(3/2) max(1 + c dδ/dt, 0) for δ > 0. The friction force −μ N tanh(v_t/v_s) acts at the contact
    /// point, which is fixed to b at the distance r from `b`; its tangential velocity v_t includes r dφ_b/dt.
    ///
    /// The force begins smoothly over the width w: for δ < w it is multiplied by t² (1 + 2 r + 3 r²) with t = δ/w and r = 1 − t, and where 1 + c dδ/dt < ½,
    /// this factor is rounded likewise, so that the force has continuous second derivatives.
    /// Gradients then need no located events if ten or more steps cross the width ([Is it true?](crate::guide::is_it_true)). If w is the constant 0,
    /// the force has the kink of [`contact`](Self::contact), and there is an event of this name, whose function is −δ. A width that is a
    /// design variable must be positive. A radius of 0 is the contact of a point.
    pub fn circle_contact(
        &mut self,
        name: &str,
        a: Point,
        normal: impl Into<Param>,
        b: Point,
        radius: impl Into<Param>,
        law: [Param; 5],
    ) {
        let [k, c, mu, speed, width] = law;
        self.ready_between(name, &CIRCLE_CONTACT, [a, b], [normal.into(), radius.into(), k, c, mu, speed, width]);
    }

    /// Adds the contact of a circle about the point `a` with a circle about the point `b`, with radii r_a and r_b in m.
    ///
    /// With the vector d from `a` to `b`, the depth is δ = r_a + r_b − |d|. A negative radius r_a is that of a bore of a around the circle of b: δ = |d| −
    /// (|r_a| − r_b), where |r_a| − r_b is the radial clearance, for example of a worn hinge. The law is that of
    /// [`circle_contact`](Self::circle_contact).
    pub fn circle_pair_contact(
        &mut self,
        name: &str,
        a: Point,
        radius_a: impl Into<Param>,
        b: Point,
        radius_b: impl Into<Param>,
        law: [Param; 5],
    ) {
        let [k, c, mu, speed, width] = law;
        self.ready_between(name, &CIRCLE_PAIR, [a, b], [radius_a.into(), radius_b.into(), k, c, mu, speed, width]);
    }
}
