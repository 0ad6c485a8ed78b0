//! [`Shape`]: solids and lines in space, as faces, polylines and balls.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};

/// The colour of marks, which depends on the background.
pub(super) const INK: &str = "ink";
/// The colours of the axes x, y and z.
pub(super) const AXES: [&str; 3] = ["#d62728", "#2ca02c", "#1f77b4"];
/// Number of sides of round shapes.
const SIDES: usize = 12;
/// Smallest edge of a cuboid, and half the length and the radius of a hinge, in units of marks.
const THIN: f64 = 0.5;
const HINGE: [f64; 2] = [2.2, 1.1];

/// A shape; lengths are in m, or in units of marks if they do not belong to the scene.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// Edges around a pose.
    Cuboid(Isometry3<f64>, [f64; 3]),
    /// A flat polygon.
    Outline(Vec<Point3<f64>>),
    /// Points and a width in units.
    Line(Vec<Point3<f64>>, f64),
    /// Centre and radius in units.
    Ball(Point3<f64>, f64),
    /// Centre and axis.
    Hinge(Point3<f64>, Vector3<f64>),
    /// The range of a slider, and its axis.
    Rail([Point3<f64>; 2], Vector3<f64>),
    /// An axis (0, 1, 2) of a pose.
    Axis(Isometry3<f64>, usize),
}

/// Polygons, polylines with their widths, and balls with their radii, all in m. The corners of a solid's faces are counter-clockwise from outside.
#[derive(Default)]
pub(super) struct Drawn {
    pub(super) faces: Vec<Vec<Point3<f64>>>,
    pub(super) lines: Vec<(Vec<Point3<f64>>, f64)>,
    pub(super) balls: Vec<(Point3<f64>, f64)>,
}

impl Shape {
    pub(super) fn centre(&self) -> Point3<f64> {
        match self {
            Shape::Cuboid(pose, _) | Shape::Axis(pose, _) => pose.translation.vector.into(),
            Shape::Outline(points) | Shape::Line(points, _) => points.first().copied().unwrap_or_default(),
            Shape::Ball(at, _) | Shape::Hinge(at, _) => *at,
            Shape::Rail([from, _], _) => *from,
        }
    }

    /// The points that determine the size of the scene.
    pub(super) fn points(&self) -> Vec<Point3<f64>> {
        match self {
            Shape::Cuboid(pose, edges) => corners(pose, *edges).to_vec(),
            Shape::Outline(points) | Shape::Line(points, _) => points.clone(),
            Shape::Rail(ends, _) => ends.to_vec(),
            _ => vec![self.centre()],
        }
    }

    /// True if the faces enclose a volume, so that only one side of each of them is seen.
    pub(super) fn is_solid(&self) -> bool {
        !matches!(self, Shape::Outline(_))
    }

    pub(super) fn drawn(&self, unit: f64) -> Drawn {
        match self {
            Shape::Cuboid(pose, edges) => {
                let corners = corners(pose, edges.map(|edge| edge.max(THIN * unit)));
                Drawn { faces: FACES.map(|face| face.map(|k| corners[k]).to_vec()).to_vec(), ..Drawn::default() }
            }
            Shape::Outline(points) => Drawn { faces: vec![points.clone()], ..Drawn::default() },
            Shape::Line(points, width) => Drawn { lines: vec![(points.clone(), width * unit)], ..Drawn::default() },
            Shape::Ball(at, radius) => Drawn { balls: vec![(*at, radius * unit)], ..Drawn::default() },
            Shape::Hinge(at, axis) => {
                let [half, radius] = HINGE.map(|x| x * unit);
                Drawn { faces: cone([at - axis * half, at + axis * half], [radius; 2]), ..Drawn::default() }
            }
            Shape::Rail([from, to], axis) => {
                let (from, back, tip) = (from - axis * (4.0 * unit), to + axis * (5.0 * unit), to + axis * (8.5 * unit));
                Drawn {
                    faces: cone([back, tip], [1.2 * unit, 0.0]),
                    lines: vec![(vec![from, back], 0.5 * unit)],
                    ..Drawn::default()
                }
            }
            Shape::Axis(pose, axis) => {
                let end = pose * Point3::from(Vector3::ith(*axis, 4.0 * unit));
                Drawn { lines: vec![(vec![pose.translation.vector.into(), end], 0.5 * unit)], ..Drawn::default() }
            }
        }
    }

    /// As [`drawn`](Self::drawn), but hinges are lines.
    pub(super) fn short(&self, unit: f64) -> Drawn {
        let Shape::Hinge(at, axis) = self else { return self.drawn(unit) };
        let [half, radius] = HINGE.map(|x| x * unit);
        Drawn { lines: vec![(vec![at - axis * half, at + axis * half], 2.0 * radius)], ..Drawn::default() }
    }
}

/// The corners of every face of a cuboid; the bits of a corner's number are its sides along x, y and z.
const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

pub(super) fn corners(pose: &Isometry3<f64>, edges: [f64; 3]) -> [Point3<f64>; 8] {
    std::array::from_fn(|k| {
        let side = |axis: usize| if k >> axis & 1 == 1 { 0.5 } else { -0.5 };
        pose * Point3::from([0, 1, 2].map(|axis| side(axis) * edges[axis]))
    })
}

/// The faces of a cylinder or a cone with these centres and radii of its ends.
fn cone(ends: [Point3<f64>; 2], radii: [f64; 2]) -> Vec<Vec<Point3<f64>>> {
    let axis = Unit::new_normalize(ends[1] - ends[0]);
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.5 * TAU));
    let at = |end: usize, k: usize| {
        let (sin, cos) = (TAU * k as f64 / SIDES as f64).sin_cos();
        ends[end] + turn * (Vector3::new(cos, sin, 0.0) * radii[end])
    };
    let side = |k: usize| {
        let tip = (radii[1] > 0.0).then(|| at(1, k));
        [at(0, k), at(0, k + 1), at(1, k + 1)].into_iter().chain(tip).collect()
    };
    let mut faces: Vec<Vec<Point3<f64>>> = (0..SIDES).map(side).collect();
    faces.push((0..SIDES).rev().map(|k| at(0, k)).collect());
    if radii[1] > 0.0 {
        faces.push((0..SIDES).map(|k| at(1, k)).collect());
    }
    faces
}

/// A flat regular polygon, as a disc.
pub(super) fn disc([x, y]: [f64; 2], radius: f64) -> Vec<Point3<f64>> {
    let corner = |k: usize| TAU * k as f64 / (2 * SIDES) as f64;
    (0..2 * SIDES).map(|k| Point3::new(x + radius * corner(k).cos(), y + radius * corner(k).sin(), 0.0)).collect()
}
