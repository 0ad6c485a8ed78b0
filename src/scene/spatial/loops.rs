//! Constraints between markers, which close loops.

use nalgebra::SVector;

use super::elements::Arguments;
use super::formula::{Number, dot, minus, values};
use super::path::Path;
use super::{Marker, Spatial};
use crate::model::space::{Connection, ConnectionKind};
use crate::model::{Multiplier, Param};
use crate::planar::{Constant, Motion};
use crate::scene::planar::with_motion;
use crate::scene::ready::{Kind, Part};
use crate::{ListConstraint, Scalar};

/// A constraint between two markers a and b. Both paths begin at the last frame that carries both, so that Φ does not depend on other coordinates.
struct Between {
    paths: [Path; 2],
    rows: Vec<Rows>,
}

#[derive(Clone, Copy)]
enum Rows {
    /// p_b − p_a = 0 along the axes of a.
    Point,
    /// x_a·z_b = y_a·z_b = 0.
    Axis,
    /// x_a·y_b = 0, which together with `Axis` fixes the orientation.
    Turn,
    /// x_a·(p_b − p_a) = y_a·(p_b − p_a) = 0.
    Line,
    /// z_a·(p_b − p_a) = 0.
    Plane,
}

impl Rows {
    fn equations(self) -> usize {
        match self {
            Rows::Point => 3,
            Rows::Axis | Rows::Line => 2,
            Rows::Turn | Rows::Plane => 1,
        }
    }
}

impl ListConstraint for Between {
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], _t: S, phi: &mut [S]) {
        let [(from, axes), (to, other)] = self.paths.each_ref().map(|path| path.place(q, b));
        let between = minus(to, from);
        let mut rest = phi.iter_mut();
        let mut put = |value: S| rest.next().into_iter().for_each(|phi| *phi = value);
        for rows in &self.rows {
            match rows {
                Rows::Point => axes.iter().for_each(|axis| put(dot(*axis, between))),
                Rows::Axis => axes[..2].iter().for_each(|axis| put(dot(*axis, other[2]))),
                Rows::Turn => put(dot(axes[0], other[1])),
                Rows::Line => axes[..2].iter().for_each(|axis| put(dot(*axis, between))),
                Rows::Plane => put(dot(axes[2], between)),
            }
        }
    }
}

/// (|p_b − p_a|² − l²)/(2 l) = 0 with a length l = f(t).
struct Apart<F, const P: usize> {
    paths: [Path; 2],
    motion: F,
    parameters: [Number; P],
}

impl<F: Motion<P>, const P: usize> ListConstraint for Apart<F, P> {
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], t: S, phi: &mut [S]) {
        let [from, to] = self.paths.each_ref().map(|path| path.place(q, b).0);
        let (between, length) = (minus(to, from), self.motion.value(t, &SVector::from(values(self.parameters, b))));
        phi[0] = (dot(between, between) / length - length) * 0.5;
    }
}

/// A kind of constraints with these equations, and what is drawn of it.
macro_rules! closing {
    ($($kind:ident $name:literal [$($rows:ident),*] $($drawn:ident)?;)*) => {$(
        pub(super) static $kind: Kind = Kind::of_markers($name, &[], |scene, name, part| {
            $(scene.spatial().connect(name, part.pair(), ConnectionKind::$drawn);)?
            let rows = vec![$(Rows::$rows),*];
            let equations = rows.iter().map(|rows| rows.equations()).sum();
            scene.spatial().between(name, part.pair(), equations, |paths, _| Between { paths, rows });
        });
    )*};
}

closing! {
    CLOSE_BALL "close ball" [Point] Ball;
    CLOSE_PARALLEL "close parallel" [Axis];
    CLOSE_REVOLUTE "close revolute" [Point, Axis] Hinge;
    CLOSE_CYLINDRICAL "close cylindrical" [Line, Axis];
    CLOSE_PRISMATIC "close prismatic" [Line, Axis, Turn];
    CLOSE_FIXED "close fixed" [Point, Axis, Turn];
    POINT_ON_PLANE "point on plane" [Plane];
    POINT_ON_LINE "point on line" [Line];
}

pub(super) static DISTANCE: Kind = Kind::of_markers("distance in space", &["length"], |scene, name, part| {
    let ([a, b], length) = (part.pair(), part.number(0));
    scene.require_positive(length, format!("the length of `{name}`"));
    scene.spatial().driven_distance(name, a, b, Constant, [length]);
});

pub(super) static DRIVEN_DISTANCE: Kind = Kind::of_markers("driven distance in space", &[], |scene, name, part| {
    let [a, b] = part.pair();
    with_motion!(part, motion, parameters, scene.spatial().driven_distance(name, a, b, motion, parameters));
})
.moving();

impl Spatial<'_> {
    /// Lets two markers coincide as by a ball joint: three equations, along the axes of a. The reactions λ (N) act on b as the force
    /// −(λ₁ x_a + λ₂ y_a + λ₃ z_a), and on a as the opposite one.
    pub fn close_ball(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 3] {
        self.close(name, &CLOSE_BALL, [a, b])
    }

    /// Lets the z axes of two markers be parallel: two equations, x_a·z_b = y_a·z_b = 0. The reactions λ (N m) act on b as the torque λ₂ x_a − λ₁ y_a, and
    /// on a as the opposite one.
    pub fn close_parallel(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 2] {
        self.close(name, &CLOSE_PARALLEL, [a, b])
    }

    /// Closes a loop by a hinge about the common z axis: five equations, those of [`close_ball`](Self::close_ball) and
    /// [`close_parallel`](Self::close_parallel).
    pub fn close_revolute(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 5] {
        self.close(name, &CLOSE_REVOLUTE, [a, b])
    }

    /// Closes a loop by a slider along and about the common z axis: four equations, those of [`point_on_line`](Self::point_on_line) and
    /// [`close_parallel`](Self::close_parallel).
    pub fn close_cylindrical(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 4] {
        self.close(name, &CLOSE_CYLINDRICAL, [a, b])
    }

    /// Closes a loop by a slider along the common z axis: five equations, those of [`close_cylindrical`](Self::close_cylindrical) and x_a·y_b = 0, whose
    /// reaction λ₅ (N m) acts on b as the torque λ₅ z_a, and on a as the opposite one.
    pub fn close_prismatic(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 5] {
        self.close(name, &CLOSE_PRISMATIC, [a, b])
    }

    /// Closes a loop by a weld: six equations, those of [`close_revolute`](Self::close_revolute) and x_a·y_b = 0, whose reaction λ₆ (N m) acts on b as the
    /// torque λ₆ z_a, and on a as the opposite one.
    pub fn close_fixed(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 6] {
        self.close(name, &CLOSE_FIXED, [a, b])
    }

    /// Keeps b in the x–y plane of a: one equation. The reaction λ (N) acts at b, on its body as the force −λ z_a and on that of a as the opposite one.
    pub fn point_on_plane(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 1] {
        self.close(name, &POINT_ON_PLANE, [a, b])
    }

    /// Keeps b on the z axis of a: two equations. The reactions λ (N) act at b, on its body as the force −(λ₁ x_a + λ₂ y_a) and on that of a as the
    /// opposite one.
    pub fn point_on_line(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 2] {
        self.close(name, &POINT_ON_LINE, [a, b])
    }

    /// Keeps two markers at a distance, m: one equation, as of a massless rod. The reaction λ (N) is the tension of the rod.
    pub fn distance(&mut self, name: &str, a: Marker, b: Marker, length: impl Into<Param>) -> [Multiplier; 1] {
        let part = Part::at_markers(&DISTANCE, &[a, b], &[length.into()]);
        self.scene.multipliers_of(|scene| scene.ready(name, part))
    }

    /// Keeps two markers at a prescribed distance f(t; parameters) > 0, m: one equation, as of a ram. The ram drives the markers apart with the force −λ (N),
    /// where λ is the reaction that belongs to the multiplier ([`CostPoint::lambda`](crate::CostPoint::lambda)).
    pub fn driven_distance<F, const P: usize>(
        &mut self,
        name: &str,
        a: Marker,
        b: Marker,
        motion: F,
        parameters: [Param; P],
    ) -> [Multiplier; 1]
    where
        F: Motion<P>,
    {
        if !self.scene.check_params(name, &parameters) {
            return self.scene.no_multipliers();
        }
        let part = Part::at_markers(&DRIVEN_DISTANCE, &[a, b], &[]);
        self.scene.multipliers_of(|scene| {
            scene.driven(name, part, motion, parameters, |scene, motion| {
                let mut space = scene.spatial();
                space.connect(name, [a, b], ConnectionKind::Line(0.9));
                space.between(name, [a, b], 1, |paths, of| Apart { paths, motion, parameters: of.b.numbers(parameters) });
            });
        })
    }

    /// Notes what is drawn between two markers; what is wrong with them is reported by the part itself.
    pub(super) fn connect(&mut self, name: &str, markers: [Marker; 2], kind: ConnectionKind) {
        let [Some(a), Some(b)] = markers.map(|marker| self.fixed_at(name, marker)) else { return };
        let connection = Connection { name: name.into(), ends: [a, b], kind };
        self.scene.parts.sketch.space.connections.push(connection);
    }

    fn close<const M: usize>(&mut self, name: &str, kind: &'static Kind, markers: [Marker; 2]) -> [Multiplier; M] {
        self.scene.multipliers_of(|scene| scene.ready(name, Part::at_markers(kind, &markers, &[])))
    }

    fn between<E: ListConstraint>(
        &mut self,
        name: &str,
        markers: [Marker; 2],
        equations: usize,
        element: impl FnOnce([Path; 2], &mut Arguments) -> E,
    ) {
        let Some((paths, mut of)) = self.paths_between(name, markers) else { return };
        let element = element(paths, &mut of);
        self.scene.list_constraint(name, element, equations, &of.q, &of.b.0);
    }
}
