//! The figure of bodies in the plane as shapes in the x–y plane of space.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::figure::{Figure, LinkKind, Mark, MarkKind, Outline, Place};
use super::shapes::{INK, Shape, disc};
use super::space::{Group, Link, Part, Space};
use super::vector::COLOURS;

impl Space {
    /// Adds the bodies of a figure, their marks, and lines between them; arrows are left out.
    pub(super) fn add_flat(&mut self, figure: &Figure) {
        let (first, unit) = (self.groups.len(), self.unit);
        let ground = first - 1;
        let others = self.groups.iter().flat_map(|group| &group.parts).filter(|part| part.trail.is_some()).count();
        let group_of = |place: Place| place.body.map_or(ground, |body| first + body);
        for (k, piece) in figure.bodies.iter().enumerate() {
            let point = |[x, y]: [f64; 2]| Point3::new(x, y, 0.0);
            let shape = match &piece.outline {
                Outline::Hull(points) if points.len() == 2 => Shape::Line(points.iter().copied().map(point).collect(), 1.6),
                Outline::Hull(points) => Shape::Outline(points.iter().copied().map(point).collect()),
                Outline::Carriage([x, y], angle) => {
                    let at = pose([*x, *y, *angle]);
                    let corners = [[-4.0, -2.2], [4.0, -2.2], [4.0, 2.2], [-4.0, 2.2]];
                    Shape::Outline(corners.map(|[x, y]| at * Point3::new(x * unit, y * unit, 0.0)).to_vec())
                }
                Outline::Disc => Shape::Outline(disc([0.0; 2], 2.0 * unit)),
                Outline::Dot => Shape::Ball(Point3::origin(), 0.7),
            };
            let is_dot = piece.outline == Outline::Dot;
            let colour = if is_dot { INK } else { COLOURS[(k + others) % COLOURS.len()] };
            let part = Part { name: piece.name.clone(), colour, shape, trail: (!is_dot).then(Point3::origin) };
            self.groups.push(Group { poses: piece.poses.iter().map(|at| pose(*at)).collect(), parts: vec![part] });
        }
        for mark in &figure.marks {
            let shapes = marked(mark, unit).into_iter();
            let parts = shapes.map(|shape| Part { name: mark.name.clone(), colour: INK, shape, trail: None });
            self.groups[group_of(mark.place)].parts.extend(parts);
        }
        self.links.extend(figure.links.iter().map(|link| {
            let width = if link.kind == LinkKind::Cylinder { 1.5 } else { 0.6 };
            let end = |place: Place| (group_of(place), Point3::new(place.at[0], place.at[1], 0.0));
            Link { name: link.name.clone(), width, ends: link.ends.map(end) }
        }));
    }
}

fn pose([x, y, angle]: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(Vector3::new(x, y, 0.0).into(), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle))
}

fn marked(mark: &Mark, unit: f64) -> Vec<Shape> {
    let [x, y] = mark.place.at;
    let at = Point3::new(x, y, 0.0);
    let line = |angle: f64, half: f64, width: f64| {
        let along = Vector3::new(angle.cos(), angle.sin(), 0.0) * half;
        Shape::Line(vec![at - along, at + along], width)
    };
    let long = if mark.place.body.is_none() { 40.0 * unit } else { 12.0 * unit };
    match mark.kind {
        MarkKind::Hinge => vec![Shape::Hinge(at, Vector3::z())],
        MarkKind::Rail(angle) => vec![line(angle, long, 0.4)],
        MarkKind::Weld => vec![Shape::Ball(at, 0.7)],
        MarkKind::Surface(normal) => vec![line(normal + std::f64::consts::FRAC_PI_2, long, 0.8)],
        MarkKind::Wheel(radius) => {
            let mut circle = disc([x, y], radius);
            circle.extend(circle.first().copied());
            vec![Shape::Line(circle, 0.4)]
        }
        MarkKind::Wall([x, y]) => vec![Shape::Line(vec![at, Point3::new(x, y, 0.0)], 1.2)],
        MarkKind::Obstacle(radius) => vec![Shape::Outline(disc([x, y], radius))],
        MarkKind::Target => [0.0, std::f64::consts::FRAC_PI_2].map(|angle| line(angle, 1.8 * unit, 0.5)).to_vec(),
    }
}
