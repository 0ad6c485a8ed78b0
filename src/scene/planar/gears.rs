//! Gears, racks and points on curves.

use nalgebra::SVector;

use super::body::Body;
use super::geometry::{Link, rotated};
use super::ground::Ends;
use super::joints::points_and;
use crate::model::{Frame, Point, Shape};
use crate::scene::ready::Kind;
use crate::{Constraint, Error, Multiplier, Param, Scalar, Scene};

/// Two wheels that roll on each other: Φ = r_a φ_a + r_b φ_b − c; b = [r_a, r_b, c].
#[derive(Clone, Copy, Debug)]
pub struct Gear;

impl Constraint<2, 1, 3> for Gear {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 3>, _t: S) -> SVector<S, 1> {
        SVector::from([b[0] * q[0] + b[1] * q[1] - b[2]])
    }
}

/// A rack on which a wheel rolls: Φ = e · r − ρ φ − c with the rack's centre r and an axis e of the inertial frame; b = [axis angle, ρ, c].
#[derive(Clone, Copy, Debug)]
pub struct Rack;

impl Constraint<3, 1, 3> for Rack {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 3>, _t: S) -> SVector<S, 1> {
        let (sin, cos) = b[0].sin_cos();
        SVector::from([cos * q[0] + sin * q[1] - b[1] * q[2] - b[2]])
    }
}

/// A curve F(x, y; b) = 0, for [`Scene::point_on_curve`]; F in m, with |grad F| ≈ 1, so that Φ is a distance.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a curve with this number of parameters",
    note = "implement `Curve<P>` with P the number of given parameters"
)]
pub trait Curve<const P: usize>: Send + Sync + 'static {
    /// The value of F, m.
    fn value<S: Scalar>(&self, x: S, y: S, b: &SVector<S, P>) -> S;
}

/// A point of body b on a curve of body a: Φ = F(R_aᵀ d), with the vector d from the point of a to that of b and the parameters `b` = [s_a,
/// s_b, parameters of F, zeros].
#[derive(Clone, Copy, Debug)]
pub struct PointOnCurve<F, const P: usize>(pub F);

impl<F: Curve<P>, const P: usize> Constraint<6, 1, 12> for PointOnCurve<F, P> {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 12>, _t: S) -> SVector<S, 1> {
        let between = Link::new(q, b.as_slice()).between;
        let local = rotated(-q[2], [between[0], between[1]]);
        SVector::from([self.0.value(local[0], local[1], &SVector::from_fn(|i, _| b[4 + i]))])
    }
}

pub(super) static GEAR: Kind = Kind::of_frames("gear", &["radius_a", "radius_b"], |scene, name, part| {
    let (Some(a), Some(b)) = (part.points[0].frame.coordinates(), part.points[1].frame.coordinates()) else {
        return scene.report(Error::NoBody { element: name.to_string() });
    };
    let ([radius_a, radius_b], q) = ([part.number(0), part.number(1)], [a[2], b[2]]);
    for (at, radius) in part.both().into_iter().zip([radius_a, radius_b]) {
        scene.draw(name, Shape::Wheel { radius }, at, at);
    }
    let offset = radius_a * scene.initial(q[0]) + radius_b * scene.initial(q[1]);
    scene.constraint(name, Gear, q, [radius_a, radius_b, offset]);
});

pub(super) static RACK: Kind = Kind::of_frames("rack", &["axis", "radius"], |scene, name, part| {
    let (Some(rack), Some(pinion)) = (part.points[0].frame.coordinates(), part.points[1].frame.coordinates()) else {
        return scene.report(Error::NoBody { element: name.to_string() });
    };
    let ([axis, radius], q) = ([part.number(0), part.number(1)], [rack[0], rack[1], pinion[2]]);
    let [x, y, phi] = q.map(|q| scene.initial(q));
    scene.draw(name, Shape::Wheel { radius }, part.points[1], part.points[1]);
    let offset = axis.cos() * x + axis.sin() * y - radius * phi;
    scene.constraint(name, Rack, q, [axis, radius, offset]);
})
.at(&["rack", "pinion"]);

impl Scene {
    /// Adds a pair of wheels with radii (m) that roll on each other, starting from their initial angles and turning in opposite directions.
    /// A negative radius is that of a ring gear around the other wheel. The axles must be fixed, with revolute joints to the ground.
    pub fn gear(
        &mut self,
        name: &str,
        a: Body,
        radius_a: impl Into<Param>,
        b: Body,
        radius_b: impl Into<Param>,
    ) -> [Multiplier; 1] {
        self.ready_joint(name, &GEAR, [a, b].map(|body| Frame::from(body).origin()), [radius_a.into(), radius_b.into()])
    }

    /// Adds a rack that slides along an axis (rad, in the inertial frame) while a wheel of the given radius (m) rolls on it, starting from
    /// their initial positions.
    pub fn rack(
        &mut self,
        name: &str,
        rack: Body,
        axis: impl Into<Param>,
        pinion: Body,
        radius: impl Into<Param>,
    ) -> [Multiplier; 1] {
        self.ready_joint(name, &RACK, [rack, pinion].map(|body| Frame::from(body).origin()), [axis.into(), radius.into()])
    }

    /// Keeps the point `b` on a curve that is fixed in the frame of `a` with its origin at the point `a`: a cam or a slot.
    pub fn point_on_curve<F, const P: usize>(
        &mut self,
        name: &str,
        a: Point,
        curve: F,
        b: Point,
        parameters: [Param; P],
    ) -> [Multiplier; 1]
    where
        F: Curve<P>,
    {
        self.joint(name, PointOnCurve(curve), ((a.frame, b.frame), Ends::Points), points_and(a, b, [], parameters))
    }
}
